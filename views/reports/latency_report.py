"""How long data takes through a model of ROS 2, as one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from jinja2 import Environment, PackageLoader, select_autoescape
from markupsafe import Markup

from dineros.metamodel.errors import DinerosError
from dineros.views.nets.drawing.svg import THEMES
from dineros.views.pages import own_markup
from dineros.views.traces.figures import trace_svg

LONG = 60
"""Steps beyond which the picture of a run folds what does not matter."""


class CallbackRow(NamedTuple):
    """One callback.

    Attributes
    ----------
    name, node : str
    period, duration, response : str
        Its least distance of runs in the long run, how long it works, and how long it takes to respond.
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
    """All that a page shows.

    Attributes
    ----------
    title, source : str
        The model and its file.
    settings : sequence of str
        How the model was changed.
    chains : sequence of str
        What is known of the chain that was asked for, in words.
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
    """Return the page as HTML, and why it lacks a picture, if it does."""
    environment = Environment(
        loader=PackageLoader("dineros.views", "static"),
        autoescape=select_autoescape(default=True, default_for_string=True),
        trim_blocks=True,
        lstrip_blocks=True,
    )
    drawn: dict[str, Markup] = {}
    failure: DinerosError | None = None
    if content.view is not None:
        try:
            fold = len(content.steps) > LONG
            drawn = {
                theme: Markup(trace_svg([content.view], theme, fold=fold, time=True)) for theme in THEMES
            }
        except DinerosError as error:
            failure = error
    most = max((row.greatest for row in content.rows if row.greatest), default=1.0)
    page = environment.get_template("latency.html.j2").render(
        content=content,
        style=own_markup("static/report.css"),
        drawn=drawn,
        width=lambda seconds: 100 * (seconds or 0.0) / most,
    )
    return page, failure
