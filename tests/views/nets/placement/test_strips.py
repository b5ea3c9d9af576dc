"""A picture that would be a long strip is folded into several lines where that makes it much smaller."""

from __future__ import annotations

import pytest

from dineros.metamodel import pn
from dineros.metamodel.build import flow
from dineros.views.nets import layout, view_of


def line(places: int) -> pn.Net:
    nodes = [pn.Transition(id=f"t{n}") if n % 2 else pn.Place(id=f"p{n}") for n in range(2 * places - 1)]
    net = pn.Net(id="line", pages=[pn.Page(id="page", objects=nodes)])
    flow(*nodes)
    return net


def ring(cells: int) -> pn.Net:
    """Return philosophers who take both forks at once."""
    page = pn.Page(id="page")
    net = pn.Net(id="ring", pages=[page])
    forks = [pn.Place(id=f"fork{n}", tokens=1) for n in range(cells)]
    page.objects.extend(forks)
    for n, fork in enumerate(forks):
        thinks, eats = pn.Place(id=f"thinks{n}", tokens=1), pn.Place(id=f"eats{n}")
        take, put = pn.Transition(id=f"take{n}"), pn.Transition(id=f"put{n}")
        page.objects.extend([thinks, eats, take, put])
        flow(thinks, take, eats, put, thinks)
        for each in (fork, forks[(n + 1) % cells]):
            flow(each, take)
            flow(put, each)
    return net


@pytest.mark.long
def test_long_lines_and_rings_are_folded() -> None:
    for net in (line(60), ring(16)):
        picture = layout(view_of(net))
        assert max(picture["width"], 1.6 * picture["height"]) < 2500
        assert len(picture["nodes"]) == len(net.pages[0].objects)
        assert all(len(edge["points"]) > 1 for edge in picture["edges"])
        for node in picture["nodes"]:
            assert 0 <= node["x"] <= picture["width"] and 0 <= node["y"] <= picture["height"]


def test_what_fits_on_a_screen_or_two_stays_one_line() -> None:
    picture = layout(view_of(line(20)))
    assert len({node["y"] for node in picture["nodes"]}) == 1


def test_what_was_arranged_stays_as_it_is() -> None:
    net = line(60)
    for number, node in enumerate(net.pages[0].objects):
        node.graphics = pn.Graphics(positions=[pn.Point(x=100 * number, y=50)])
    picture = layout(view_of(net))
    assert picture["width"] > 11_000 and len({node["y"] for node in picture["nodes"]}) == 1
