"""``dineros view``: a picture of a model, in the browser or in a file."""

from __future__ import annotations

import math
import os
import re
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dineros.cli.console import note, summarise, warn, working
from dineros.cli.models import load
from dineros.cli.options import ModelPath, command, model_argument, settings_option
from dineros.cli.outputs import PICTURES, refuse_output

if TYPE_CHECKING:
    from dineros.views.nets import ViewModel
    from dineros.views.nets.drawing.svg import Theme


@command(
    "dineros view sorting.sym.xmi -o sorting.html",
    "dineros view sorting.sym.xmi --around TStop --steps 2 -o stop.svg",
    "dineros view sorting.sym.xmi --set RedObjects.tokens=2 --compare sorting.sym.xmi -o changed.html",
    "dineros view sorting.sym.xmi --collapse all --width 250 --aspect 3:2 -o figure.svg",
    "dineros view sorting.sym.xmi --collapse all --badge executor=6 -o overview.png",
)
@model_argument()
@click.option(
    "-o",
    "--output",
    type=ModelPath(),
    metavar="OUT",
    help="A file to write instead of opening a browser: .html, .svg or .png.",
)
@click.option(
    "--compare",
    type=ModelPath(),
    metavar="OTHER",
    help="Show what MODEL has, lacks and changes against OTHER.",
)
@click.option(
    "--around", multiple=True, metavar="ELEMENT", help="Show only what is near this element; repeatable."
)
@click.option(
    "--steps", type=click.IntRange(min=0), default=2, show_default=True, help="How near, for --around."
)
@click.option(
    "--collapse",
    multiple=True,
    metavar="PAGE",
    help="Show this page or ROS node without its content, or 'all'; repeatable.",
)
@click.option(
    "--expand",
    multiple=True,
    metavar="PAGE",
    help="Show the content of this page of a large model, or of 'all'; repeatable.",
)
@click.option(
    "--badge",
    "badges",
    multiple=True,
    metavar="ELEMENT=TEXT",
    help="Put a short text beside an element; repeatable.",
)
@click.option(
    "--theme",
    type=click.Choice(["light", "dark"]),
    default="light",
    show_default=True,
    help="Colours of .svg and .png.",
)
@click.option(
    "--width",
    type=click.FloatRange(min=20, max=2000),
    metavar="MM",
    help="For paper (.svg, .png): so many millimetres wide, with all text of 6 points or more.",
)
@click.option(
    "--aspect",
    metavar="W:H",
    help="For paper: width by height, such as 3:2 or 1.5.",
)
@settings_option
def view(
    model: Path,
    output: Path | None,
    compare: Path | None,
    around: tuple[str, ...],
    steps: int,
    collapse: tuple[str, ...],
    expand: tuple[str, ...],
    badges: tuple[str, ...],
    theme: str,
    width: float | None,
    aspect: str | None,
    settings: tuple[str, ...],
) -> int:
    """Show a model as a picture: a system model, a runtime model, a flattened or a plain net.

    Pages are collapsed where names would be too small to read at first sight, and in .svg and .png those of
    models of more than 150 nodes, unless --expand says otherwise. Of a model that is too large for --width,
    the pages are drawn one by one, into files with their ids.

    Without -o, a page is opened in the browser. It needs no network: click to learn more, collapse and expand
    pages, search with '/', '?' lists the keys.
    """
    from dineros.views.nets import save_picture

    if output is not None:
        refuse_output(output, PICTURES)
    ratio = _ratio(aspect)
    if width is None and ratio is not None:
        raise click.UsageError("--aspect goes with --width")
    if width is not None and (output is None or output.suffix.lower() not in (".svg", ".png")):
        raise click.UsageError("--width goes with -o and .svg or .png")
    with working("Drawing"):
        on_page = output is None or output.suffix.lower() == ".html"
        shown = _shown(model, compare, settings, around, steps, collapse, expand, badges, on_page=on_page)
        if output is not None and width is not None:
            return _for_paper(shown, model, output, width, ratio, "dark" if theme == "dark" else "light")
        page = output or _page_for_browser(model)
        chosen: Theme = "dark" if theme == "dark" else "light"
        try:
            save_picture(shown, page, theme=chosen)
        except BaseException:
            if output is None:
                page.unlink(missing_ok=True)
            raise
    note(f"wrote {page}")
    if output is None:
        import webbrowser

        opened = webbrowser.open(page.as_uri())
        summarise(
            f"{model} -> {page}" if opened else f"{model} -> {page}: no browser found, open the file in one"
        )
    else:
        summarise(f"{model} -> {output}")
    return 0


def _shown(
    model: Path,
    compare: Path | None,
    settings: Sequence[str],
    around: Sequence[str],
    steps: int,
    collapse: Sequence[str],
    expand: Sequence[str],
    badges: Sequence[str],
    *,
    on_page: bool,
) -> ViewModel:
    from dineros.views import nets

    shown = nets.view_of(load(model, settings))
    if compare is not None:
        shown = nets.compare(nets.view_of(load(compare)), shown)
    if around:
        shown = nets.around(shown, around, steps)
    elif on_page and not (expand or collapse or compare):
        shown = nets.collapse_to_read(shown)
    else:
        shown = nets.collapse_if_large(shown)
    if expand:
        shown = nets.expand(shown, None if "all" in expand else expand)
    if collapse:
        shown = nets.collapse(shown, None if "all" in collapse else collapse)
    if badges:
        shown = nets.with_badges(shown, dict(_badge(text) for text in badges))
    return shown


def _for_paper(
    shown: ViewModel, model: Path, output: Path, width: float, ratio: float | None, theme: Theme
) -> int:
    """Draw for paper, and say what was too large for it."""
    from dineros.views.nets import Paper, save_for_paper

    written, too_large = save_for_paper(shown, output, Paper(width, ratio), theme=theme)
    if len(written) > 1 or too_large:
        what = "its pages" if too_large and too_large[0].page is None else "an overview and its pages"
        warn(f"{model} is too large for {width:g} mm: {what} are drawn one by one")
    for sheet in too_large:
        if sheet.page is not None:
            warn(f"page {sheet.page} is left out: it needs {math.ceil(sheet.needed)} mm")
    summarise(f"{model} -> {', '.join(map(str, written))}")
    return 0


def _ratio(text: str | None) -> float | None:
    if text is None:
        return None
    found = re.fullmatch(r"(\d+(?:\.\d+)?)(?:[:/x](\d+(?:\.\d+)?))?", text)
    ratio = float(found[1]) / (float(found[2] or 1) or math.inf) if found else 0.0
    if not 0.1 <= ratio <= 10:
        raise click.BadParameter(f"{text!r} is not W:H, from 1:10 to 10:1", param_hint="--aspect")
    return ratio


def _badge(text: str) -> tuple[str, str]:
    element, sign, badge = text.rpartition("=")
    if not sign or not element or not badge:
        raise click.BadParameter(f"{text!r} is not ELEMENT=TEXT", param_hint="--badge")
    return element, badge


def _page_for_browser(model: Path) -> Path:
    """Make an empty file, which stays there for the browser."""
    name = model.name.partition(".")[0][:40]
    descriptor, path = tempfile.mkstemp(prefix=f"dineros-{name}-", suffix=".html")
    os.close(descriptor)
    return Path(path)
