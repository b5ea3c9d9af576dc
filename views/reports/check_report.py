"""The findings of a check of a model, as one self-contained HTML file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from markupsafe import Markup

from dineros.analysis.witnesses.step_rounds import Times, step_rounds
from dineros.metamodel import pn
from dineros.metamodel.errors import DinerosError
from dineros.views.nets import ViewModel, around, collapse_if_large, layout, to_svg, view_of
from dineros.views.nets.drawing.svg import THEMES
from dineros.views.reports.excerpts import Excerpt
from dineros.views.reports.rendering import rendered
from dineros.views.traces.figures import trace_svg

LONG = 60
"""Number of steps beyond which the picture of a trace folds irrelevant lanes and steps."""

MOST = 40
"""Number of elements beyond which the picture of a part of the net shows fewer steps around them."""

SIGNS = {"error": "✗", "warning": "▲", "note": "ℹ"}


@dataclass(frozen=True)
class FindingEntry:
    """One finding.

    Attributes
    ----------
    severity, rule, message : str
        The fault.
    elements : sequence of str
        Ids of the elements concerned.
    view : dict or None
        Its trace: the result of `TraceCoder.snapshot`.
    steps : sequence of str
        The steps in words.
    loop : int or None
        Index of the first step that repeats forever.
    consequences : sequence of (str, str)
        Message and rule of each fault that is there only because of this one.
    code : sequence of Excerpt
        The lines of source code that it is about, with those around them.
    times : sequence of FiringTime or None
        When the steps fire; empty if the net has no times.
    """

    severity: str
    rule: str
    message: str
    elements: Sequence[str] = ()
    view: dict[str, Any] | None = None
    steps: Sequence[str] = ()
    loop: int | None = None
    consequences: Sequence[tuple[str, str]] = ()
    code: Sequence[Excerpt] = ()
    times: Times = ()

    @property
    def rounds(self) -> list[Round]:
        """The steps; a repeated block is listed once."""
        loop = len(self.steps) if self.loop is None else self.loop
        found: list[Round] = []
        for begin, end in ((0, loop), (loop, len(self.steps))):
            is_loop = begin == loop
            for each in step_rounds(self.steps[begin:end], self.times[begin:end], begin):
                made = Round(each.first, each.last, list(each.steps), each.times, is_loop, each.heading)
                if found and found[-1].times == made.times == 1 and found[-1].is_loop == is_loop:
                    made = made._replace(first=found[-1].first, steps=[*found.pop().steps, *made.steps])
                found.append(made)
        return found


class Round(NamedTuple):
    """Steps of a witness that are listed once.

    Attributes
    ----------
    first, last : int
        Numbers of the first step, and of the last one of the last round; the first step of all is 1.
    steps : list of str
        Of one round, in words.
    times : int
        How often they come in a row.
    is_loop : bool
        Whether they repeat forever.
    heading : str
        What stands above them if they come more than once.
    """

    first: int
    last: int
    steps: list[str]
    times: int
    is_loop: bool
    heading: str


@dataclass(frozen=True)
class CheckContent:
    """The content of a report.

    Attributes
    ----------
    title, source : str
        The model and its file.
    findings : sequence of FindingEntry
        The fault.
    proved, unknown, assumed : sequence of str
        What holds, what is not known, and what holds under an assumption that `unknown` names.
    spaces : sequence of dict
        Rows of a sweep over the signal variants: the state spaces.
    settings : sequence of str
        How the model was changed.
    accepted : sequence of (str, str, str)
        Message, rule and reason of each finding that does not count.
    notes : sequence of str
        What limits the answers, and the figures of the state spaces.
    """

    title: str
    source: str
    findings: Sequence[FindingEntry]
    proved: Sequence[str]
    unknown: Sequence[str]
    spaces: Sequence[dict[str, Any]] = ()
    settings: Sequence[str] = field(default_factory=tuple)
    accepted: Sequence[tuple[str, str, str]] = ()
    notes: Sequence[str] = ()
    assumed: Sequence[str] = ()


def check_page(content: CheckContent, model: pn.Net | None = None) -> tuple[str, DinerosError | None]:
    """Return the report as HTML, and the reason if pictures are missing.

    Parameters
    ----------
    content : CheckContent
        Its content.
    model : pn.Net, optional
        The model, for pictures of the parts concerned.
    """
    view = view_of(model) if model is not None else None
    most = max((row["states"] or 1 for row in content.spaces), default=1)
    failures: list[DinerosError] = []
    page = rendered(
        "report.html.j2",
        content=content,
        signs=SIGNS,
        figures=[_figures(finding, view, failures) for finding in content.findings],
        counts={name: sum(one.severity == name for one in content.findings) for name in SIGNS},
        width=lambda states: 100 * len(str(states or 1)) / max(len(str(most)), 1),
    )
    return page, failures[0] if failures else None


def _figures(
    finding: FindingEntry, view: ViewModel | None, failures: list[DinerosError]
) -> dict[str, dict[str, Markup]]:
    """Return the pictures of a finding: part of the net, and trace, each in light and dark."""
    found: dict[str, dict[str, Markup]] = {}
    known = {shape.id for shape in view.shapes()} if view is not None else ()
    shown = [element for element in finding.elements if element in known]
    if view is not None and shown:
        with _noted(failures):
            positioned = layout(collapse_if_large(_part(view, shown)))
            found["net"] = {
                theme: Markup(to_svg(positioned, highlights=shown, theme=theme)) for theme in THEMES
            }
    if finding.view is not None:
        with _noted(failures):
            views, fold = [finding.view], len(finding.steps) > LONG
            found["trace"] = {theme: Markup(trace_svg(views, theme, fold=fold)) for theme in THEMES}
    return found


@contextmanager
def _noted(failures: list[DinerosError]) -> Iterator[None]:
    """Continue without pictures that cannot be drawn."""
    try:
        yield
    except DinerosError as error:
        failures.append(error)


def _part(view: ViewModel, shown: Sequence[str]) -> ViewModel:
    """Return the neighbourhood of some elements, as large as it is readable."""
    for steps in (3, 2, 1):
        part = around(view, shown, steps)
        if len(part.nodes) <= MOST:
            break
    return part
