"""The latencies of a model of ROS 2, as one self-contained HTML file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from dineros.metamodel.errors import DinerosError
from dineros.views.reports.rendering import drawn_in_time, rendered

LONG = 60
"""Number of steps beyond which the picture of a run folds irrelevant lanes and steps."""


class CallbackRow(NamedTuple):
    """One callback.

    Attributes
    ----------
    name, node : str
    period, duration, response : str
        Its least mean distance of runs, its duration, and its response time.
    reason : str
        Why the response time is open.
    greatest : float or None
        The greatest response time, in seconds.
    share : float or None
        Part of the time of a thread that it needs at most.
    """

    name: str
    node: str
    period: str
    duration: str
    response: str
    reason: str
    greatest: float | None
    share: float | None


@dataclass(frozen=True)
class LatencyContent:
    """The content of a page.

    Attributes
    ----------
    title, source : str
        The model and its file.
    settings : sequence of str
        How the model was changed.
    chains : sequence of str
        The results for the requested chain, in words.
    rows : sequence of CallbackRow
    readers : sequence of (str, int, str)
        Place, longest history, and whether it can overflow.
    timers : sequence of (str, str)
        Callback, and whether it loses ticks.
    worst : str
        What takes longest in the run that is shown.
    steps : sequence of str
        Its steps in words.
    view : dict or None
        Its picture: what `TraceCoder.snapshot` returns.
    notes : sequence of str
        What the answers rest on.
    """

    title: str
    source: str
    settings: Sequence[str]
    chains: Sequence[str]
    rows: Sequence[CallbackRow]
    readers: Sequence[tuple[str, int, str]]
    timers: Sequence[tuple[str, str]]
    worst: str = ""
    steps: Sequence[str] = ()
    view: dict[str, Any] | None = None
    notes: Sequence[str] = field(default_factory=tuple)


def latency_page(content: LatencyContent) -> tuple[str, DinerosError | None]:
    """Return the page as HTML, and the reason if a picture is missing."""
    drawn, failure = drawn_in_time(content.view, fold=len(content.steps) > LONG)
    most = max((row.greatest for row in content.rows if row.greatest), default=1.0)
    page = rendered(
        "latency.html.j2",
        content=content,
        drawn=drawn,
        width=lambda seconds: 100 * (seconds or 0.0) / most,
    )
    return page, failure
