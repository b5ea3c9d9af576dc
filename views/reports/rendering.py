"""Common parts of report pages: rendering of templates, and drawing of runs on a time axis."""

from __future__ import annotations

from typing import Any

from jinja2 import Environment, PackageLoader, select_autoescape
from markupsafe import Markup

from dineros.metamodel.errors import DinerosError
from dineros.views.nets.drawing.svg import THEMES
from dineros.views.pages import own_markup
from dineros.views.traces.figures import trace_svg


def rendered(template: str, **content: object) -> str:
    """Return the page of a template in `static`, in the style of reports."""
    environment = Environment(
        loader=PackageLoader("dineros.views", "static"),
        autoescape=select_autoescape(default=True, default_for_string=True),
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template).render(style=own_markup("static/report.css"), **content)


def drawn_in_time(view: dict[str, Any] | None, fold: bool) -> tuple[dict[str, Markup], DinerosError | None]:
    """Draw a run on a time axis.

    Parameters
    ----------
    view : dict or None
        The run: the result of `TraceCoder.snapshot`. None gives no picture.
    fold : bool
        Whether irrelevant lanes and steps are folded.

    Returns
    -------
    pictures : dict of str to Markup
        By theme.
    failure : DinerosError or None
        Why there are none.
    """
    if view is None:
        return {}, None
    try:
        return {theme: Markup(trace_svg([view], theme, fold=fold, time=True)) for theme in THEMES}, None
    except DinerosError as error:
        return {}, error
