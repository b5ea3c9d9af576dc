"""The figures of a sweep."""

from __future__ import annotations

from typing import Any

import pytest
from lxml import etree

from dineros.views.reports.sweep_figures import sweep_figures


def row(tokens: Any, signals: str, states: int | None, **more: Any) -> dict[str, Any]:
    return {
        "Red.tokens": tokens,
        "Blue.tokens": tokens,
        "signals": signals,
        "overflow": "weighted",
        "reduced": False,
        "states": states,
        "seconds": 0.5,
        "peak_memory_bytes": 200 << 20,
        "complete": states is not None,
        **more,
    }


ROWS = [row(n, signals, 10 ** (n + k)) for k, signals in enumerate(("none", "io-enabled")) for n in (0, 1, 2)]


def texts(rows: list[dict[str, Any]]) -> list[str]:
    picture: Any = etree.fromstring(sweep_figures(rows, title="sorting"))
    return list(picture.xpath("//s:text/text()", namespaces={"s": "http://www.w3.org/2000/svg"}))


@pytest.mark.long
def test_three_panels_one_series_per_variant_with_markers() -> None:
    said = texts(ROWS)
    assert {
        "sorting",
        "state space: places (markings); dotted: transitions",
        "time (s)",
        "peak memory (MiB)",
        "none",
        "io-enabled",
    } <= set(said)
    assert "Red.tokens = Blue.tokens" in said
    content = sweep_figures(ROWS)
    assert content.count(b"stroke-dasharray") >= 0
    assert sweep_figures(ROWS) == content  # the same file each time


@pytest.mark.long
def test_the_axis_is_named_above_the_legend() -> None:
    picture: Any = etree.fromstring(sweep_figures(ROWS, title="sorting"))
    space = {"s": "http://www.w3.org/2000/svg"}
    lines = {text.text: float(text.get("y")) for text in picture.xpath("//s:text[@y]", namespaces=space)}
    assert lines["none"] - lines["Red.tokens = Blue.tokens"] > 9  # a line of text, at least
    assert float(picture.get("viewBox").split()[3]) - lines["none"] > 3


@pytest.mark.long
def test_the_transitions_of_the_state_space_are_dotted_lines_as_in_figure_15() -> None:
    dotted = b"stroke-dasharray: 1,1.65"
    assert sweep_figures(ROWS).count(dotted) == 0  # a table without arcs
    drawn = sweep_figures([{**row, "arcs": 7 * row["states"]} for row in ROWS])
    assert drawn.count(dotted) == len(("none", "io-enabled"))


def test_a_point_that_was_given_up_is_a_cross() -> None:
    assert texts([*ROWS, row(3, "none", None)]).count("×") == 3


def test_further_axes_and_reduction_become_series() -> None:
    rows = [
        {
            "a": n,
            "b": m,
            "signals": "none",
            "overflow": "weighted",
            "reduced": reduced,
            "states": 5 + n,
            "seconds": 1.0,
            "peak_memory_bytes": 1 << 20,
            "complete": True,
        }
        for n in (1, 2)
        for m in ("x", "y")
        for reduced in (False, True)
    ]
    said = texts(rows)
    assert {"b = x, none", "b = x, none, reduced", "b = y, none", "b = y, none, reduced"} <= set(said)


def test_of_a_reduced_net_its_own_markings_are_drawn() -> None:
    rows = [row(n, "none", 10**6, reduced=True, reduced_states=10 + n) for n in (1, 2)]
    own = [row(n, "none", 10 + n, reduced=True) for n in (1, 2)]
    assert sweep_figures(rows) == sweep_figures(own)


def test_values_that_are_no_numbers_are_named() -> None:
    assert {"small", "large"} <= set(texts([row("small", "none", 5), row("large", "none", 50)]))


@pytest.mark.parametrize(("suffix", "start"), [(".png", b"\x89PNG"), (".pdf", b"%PDF")])
def test_other_formats(suffix: str, start: bytes) -> None:
    assert sweep_figures(ROWS, suffix).startswith(start)
