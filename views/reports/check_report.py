"""What a check of a model found, as one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, select_autoescape
from markupsafe import Markup

from dineros.metamodel import pn
from dineros.views.reports.net_parts import NetParts
from dineros.views.traces.figures import trace_svg

LONG = 60
"""Steps beyond which the picture of a trace folds what does not matter."""

SIGNS = {"error": "✗", "warning": "▲", "note": "ℹ"}


@dataclass(frozen=True)
class FindingEntry:
    """One finding.

    Attributes
    ----------
    severity, rule, message : str
        What is wrong.
    elements : sequence of str
        Ids of the elements concerned.
    view : dict or None
        How it comes about: what `TraceCoder.snapshot` returns.
    steps : sequence of str
        The steps in words.
    loop : int or None
        Index of the first step that repeats for ever.
    """

    severity: str
    rule: str
    message: str
    elements: Sequence[str] = ()
    view: dict[str, Any] | None = None
    steps: Sequence[str] = ()
    loop: int | None = None


@dataclass(frozen=True)
class CheckContent:
    """All that a report shows.

    Attributes
    ----------
    title, source : str
        The model and its file.
    findings : sequence of FindingEntry
        What is wrong.
    proved, unknown : sequence of str
        What holds, and what is not known.
    spaces : sequence of dict
        Rows of a sweep over the signal variants: the state spaces.
    settings : sequence of str
        How the model was changed.
    """

    title: str
    source: str
    findings: Sequence[FindingEntry]
    proved: Sequence[str]
    unknown: Sequence[str]
    spaces: Sequence[dict[str, Any]] = ()
    settings: Sequence[str] = field(default_factory=tuple)


def check_page(content: CheckContent, model: pn.Net | None = None) -> str:
    """Return the report as HTML.

    Parameters
    ----------
    content : CheckContent
        What it says.
    model : pn.Net, optional
        The model, for pictures of the parts concerned.

    Raises
    ------
    DinerosError
        What draws the pictures is not installed.
    """
    environment = Environment(
        loader=PackageLoader("dineros.views", "static"),
        autoescape=select_autoescape(default=True, default_for_string=True),
        trim_blocks=True,
        lstrip_blocks=True,
    )
    style = (files("dineros.views") / "static" / "report.css").read_text(encoding="utf-8")
    parts = NetParts(model) if model is not None else None
    most = max((row["states"] or 1 for row in content.spaces), default=1)
    return environment.get_template("report.html.j2").render(
        content=content,
        style=Markup(style),
        signs=SIGNS,
        figures=[_figures(finding, parts) for finding in content.findings],
        counts={name: sum(one.severity == name for one in content.findings) for name in SIGNS},
        width=lambda states: 100 * len(str(states or 1)) / max(len(str(most)), 1),
    )


def _figures(finding: FindingEntry, parts: NetParts | None) -> dict[str, dict[str, Markup]]:
    """Return the pictures of a finding: part of the net, and trace, each in light and dark."""
    found: dict[str, dict[str, Markup]] = {}
    drawn = parts.draw(finding.elements) if parts is not None else {}
    if drawn:
        found["net"] = {theme: Markup(picture) for theme, picture in drawn.items()}
    if finding.view is not None:
        fold = len(finding.steps) > LONG
        views = [finding.view]
        found["trace"] = {
            "light": Markup(trace_svg(views, "light", fold=fold)),
            "dark": Markup(trace_svg(views, "dark", fold=fold)),
        }
    return found
