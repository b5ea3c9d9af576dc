"""Figures of traces without the page's scripts."""

from __future__ import annotations

from typing import Any

from lxml import etree

from dineros.views.traces.coding import TraceCoder
from dineros.views.traces.comparing import first_divergence
from dineros.views.traces.plain import plain_figure
from tests.views.samples import lasso, long_run
from tests.views.traces.test_building import built
from tests.views.traces.test_figures import lanes, parsed, snapshot, texts


def test_it_shows_the_lanes_of_the_other_figure() -> None:
    picture = parsed(plain_figure([snapshot(lasso())]))
    assert lanes(picture, "signal") == ["Red", "Danger"]
    assert lanes(picture, "queue") == ["SortRed"]
    assert lanes(picture, "client") == ["safety"]
    assert set(lanes(picture, "transition")) == {"SelectRed", "TRetry"}
    said = texts(picture)
    assert "sample — violated: G (Shown < 1 & signal(Red))" in said
    assert "LeftCellObjects (publisher SortRed …" in said
    assert "for ever from here" in said
    assert "p publish, d message lost, q request, s serve, f fires" in said
    assert all(float(x) >= 0 for x in picture.xpath("//@x"))


def test_two_traces_where_they_part_and_a_filter() -> None:
    a, b = built(lasso()), built(lasso(differs=True))
    parting = first_divergence(a, b)
    assert parting is not None
    views = [TraceCoder(builder, "x").snapshot() for builder in (a, b)]
    picture = parsed(plain_figure(views, "dark", filter="signals -red", divergence=parting.to_json()))
    assert texts(picture).count("first divergence") == 2
    assert lanes(picture, "signal") == ["Danger", "Blue"]
    assert lanes(picture, "queue") == []


def test_long_traces_empty_ones_and_names_with_markup() -> None:
    def width(picture: Any) -> float:
        return float(picture.get("width"))

    assert width(parsed(plain_figure([snapshot(long_run(4000))]))) < 2000
    scribe = lasso()
    object.__setattr__(scribe.records[0], "property", '<b> & "x"')
    scribe.records = scribe.records[:1]
    picture = parsed(plain_figure([snapshot(scribe)]))
    assert isinstance(picture, etree._Element)
    assert 'sample — violated: <b> & "x"' in texts(picture)
