"""The times of a simulated run, as one self-contained HTML file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from dineros.metamodel.errors import DinerosError
from dineros.views.reports.rendering import drawn_in_time, rendered


class Histogram(NamedTuple):
    """The times of a callback or chain.

    Attributes
    ----------
    name, text : str
        Its name, and its quantiles in words.
    least, greatest : str
        The ends of the axis, with units.
    counts : sequence of int
        By bar.
    """

    name: str
    text: str
    least: str
    greatest: str
    counts: Sequence[int]


@dataclass(frozen=True)
class SimulationContent:
    """The content of a page.

    Attributes
    ----------
    title, source, what : str
        The model, its file, and what was simulated.
    histograms : sequence of Histogram
    notes : sequence of str
        Lost messages, and missing times of the model.
    view : dict or None
        The beginning of the run: what `TraceCoder.snapshot` returns.
    """

    title: str
    source: str
    what: str
    histograms: Sequence[Histogram]
    notes: Sequence[str]
    view: dict[str, Any] | None


def simulation_page(content: SimulationContent) -> tuple[str, DinerosError | None]:
    """Return the page as HTML, and the reason if a picture is missing."""
    drawn, failure = drawn_in_time(content.view, fold=True)
    page = rendered("simulation.html.j2", content=content, drawn=drawn)
    return page, failure
