"""``dineros view``: a picture of a model, in the browser or in a file."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dineros.cli.console import working
from dineros.cli.options import (
    model_argument,
    model_path_option,
    output_option,
    settings_option,
    theme_option,
    value_option,
    values_option,
)
from dineros.cli.outputs import PICTURES, refuse_output
from dineros.cli.presentation.pictures import draw, draw_for_paper, picture_of
from dineros.cli.supervising import serving_command, within_limits

if TYPE_CHECKING:
    from dineros.views.nets.drawing.svg import Theme


@serving_command(
    "dineros view sorting.sym.xmi -o sorting.html",
    "dineros view sorting.sym.xmi --around TStop --steps 2 -o stop.svg",
    "dineros view sorting.sym.xmi --set RedObjects.tokens=2 --compare sorting.sym.xmi -o changed.html",
    "dineros view sorting.sym.xmi --collapse all --width 250 --aspect 3:2 -o figure.svg",
    "dineros view sorting.sym.xmi --collapse all --badge executor=6 -o overview.png",
)
@model_argument()
@output_option("A file to write instead of opening a browser: .html, .svg or .png.")
@model_path_option("--compare OTHER", "Show what MODEL adds, removes and changes compared with OTHER.")
@values_option("--around ELEMENT", "Show only the elements near this one; repeatable.")
@click.option(
    "--steps",
    type=click.IntRange(min=0),
    default=2,
    show_default=True,
    help="With --around: the largest distance, in arcs.",
)
@values_option("--collapse PAGE", "Show this page or ROS node without its content, or 'all'; repeatable.")
@values_option("--expand PAGE", "Show the content of this page of a large model, or of 'all'; repeatable.")
@values_option("--badge ELEMENT=TEXT", "Put a short text next to an element; repeatable.", into="badges")
@theme_option
@value_option(
    "--width MM",
    "For paper (.svg, .png): the width in millimetres; all text has 6 points or more.",
    type=click.FloatRange(min=20, max=2000),
)
@value_option("--aspect W:H", "For paper: width by height, such as 3:2 or 1.5.")
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
    theme: Theme,
    width: float | None,
    aspect: str | None,
    settings: tuple[str, ...],
) -> int:
    """Show a model as a picture: a system model, a runtime model, a flattened or a plain net.

    Pages are collapsed if names would initially be too small to read, and in .svg and .png if the model
    has more than 150 nodes, unless --expand is given. If a model is too large for --width, its pages are
    drawn one by one, into files named after their ids.

    Without -o, a page is opened in the browser. It needs no network. Click elements for details, collapse and
    expand pages, search with '/'; '?' lists the keys.
    """
    if output is not None:
        refuse_output(output, PICTURES)
    ratio = _ratio(aspect)
    if width is None and ratio is not None:
        raise click.UsageError("--aspect requires --width")
    if width is not None and (output is None or output.suffix.lower() not in (".svg", ".png")):
        raise click.UsageError("--width requires -o with .svg or .png")
    put = dict(_badge(text) for text in badges)
    with working("Drawing"):
        on_page = output is None or output.suffix.lower() == ".html"
        with within_limits():
            shown = picture_of(
                model, compare, settings, around, steps, collapse, expand, put, on_page=on_page
            )
        if output is not None and width is not None:
            draw_for_paper(shown, model, output, width, ratio, theme)
        else:
            draw(shown, model, output, theme)
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
