"""Positioned nets as SVG, drawn by the pages' own code in V8."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import cache
from typing import TYPE_CHECKING, Literal, TypeAlias, get_args

from dineros.metamodel.clauses import SignalSetting
from dineros.views.javascript.client import evaluate
from dineros.views.nets.placement.placing import SCRIPTS
from dineros.views.pages import own_text

if TYPE_CHECKING:
    from dineros.views.nets.drawing.paper import Paper
    from dineros.views.nets.placement.picture import Picture

Theme: TypeAlias = Literal["light", "dark"]
THEMES: tuple[Theme, ...] = get_args(Theme)

_STILL = ".net .fold{display:none}.net .collapsed .fold{display:inline}"  # nothing collapses on a click here


def to_svg(
    positioned: Picture,
    *,
    marking: Mapping[str, int] | None = None,
    signals: Mapping[str, SignalSetting] | None = None,
    highlights: Iterable[str] = (),
    theme: Theme = "light",
    paper: Paper | None = None,
) -> str:
    """Return the picture of a positioned net as a complete SVG file.

    Parameters
    ----------
    positioned : Picture
        What `dineros.views.nets.layout` returns.
    marking : mapping of str to int, optional
        Tokens by id of place; other places show their initial ones.
    signals : mapping of str to bool or str, optional
        Values by id of signal; the others show their initial ones.
    highlights : iterable of str
        Ids of elements to point out.
    theme : {"light", "dark"}
        Dark lines on white, or light ones on black.
    paper : Paper, optional
        The size it has in print; pixels otherwise.

    Raises
    ------
    DinerosError
        V8, which draws, is not installed or gives no answer.
    """
    sheet = None if paper is None else {"area": paper.area(positioned), "width": paper.width}
    overlay = {"marking": dict(marking or {}), "signals": dict(signals or {}), "highlights": list(highlights)}
    svg: str = evaluate(SCRIPTS, "netFigure", positioned, stylesheet(theme), theme, sheet, overlay)
    return svg


@cache
def stylesheet(theme: Theme) -> str:
    """Return the style of a theme, without variables, which not all programs that show SVG support."""
    text = re.sub(r"/\*.*?\*/", "", own_text("static/net/net.css"), flags=re.DOTALL)
    themes = re.findall(r"[^{}]*\{\s*--net-[^}]*\}", text)  # light, then what differs in dark
    values: dict[str, str] = {}
    for block in themes[: 2 if theme == "dark" else 1]:
        values |= dict(re.findall(r"(--net-[\w-]+):\s*([^;]+);", block))
    for block in themes:
        text = text.replace(block, "")
    text = re.sub(r"var\((--net-[\w-]+)\)", lambda found: values[found[1]], text)
    # In a page with both, each style is for its own picture.
    return re.sub(r"\s*\n\s*", "", f"{text}{_STILL}".replace(".net ", f".net-{theme} "))
