"""Draws pictures of models: into a file, for paper, or opened in the browser."""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.console import note, summarise, warn
from dineros.cli.models import load

if TYPE_CHECKING:
    from dineros.views.nets import ViewModel
    from dineros.views.nets.drawing.svg import Theme


def picture_of(
    model: Path,
    compare: Path | None,
    settings: Sequence[str],
    around: Sequence[str],
    steps: int,
    collapse: Sequence[str],
    expand: Sequence[str],
    badges: Mapping[str, str],
    *,
    on_page: bool,
) -> ViewModel:
    """Return the picture of a model, by the options of ``dineros view``."""
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
        shown = nets.with_badges(shown, badges)
    return shown


def draw_for_paper(
    shown: ViewModel, model: Path, output: Path, width: float, ratio: float | None, theme: Theme
) -> None:
    """Draw for paper, and report parts that are too large for it."""
    from dineros.views.nets import Paper, save_for_paper

    written, too_large = save_for_paper(shown, output, Paper(width, ratio), theme=theme)
    if len(written) > 1 or too_large:
        what = "its pages" if too_large and too_large[0].page is None else "an overview and its pages"
        warn(f"{model} is too large for {width:g} mm: {what} are drawn separately")
    for sheet in too_large:
        if sheet.page is not None:
            warn(f"page {sheet.page} is omitted: it needs {math.ceil(sheet.needed)} mm")
    summarise(f"{model} -> {', '.join(map(str, written))}")


def draw(shown: ViewModel, model: Path, output: Path | None, theme: Theme) -> None:
    """Draw into a file; without one, into a temporary file that is opened in the browser and kept for it."""
    from dineros.views.nets import save_picture

    page = output or _page_for_browser(model)
    try:
        save_picture(shown, page, theme=theme)
    except BaseException:
        if output is None:
            page.unlink(missing_ok=True)
        raise
    note(f"wrote {page}")
    unseen = ""
    if output is None:
        import webbrowser

        unseen = "" if webbrowser.open(page.as_uri()) else ": no browser found; open the file in a browser"
    summarise(f"{model} -> {page}{unseen}")


def _page_for_browser(model: Path) -> Path:
    """Create an empty file."""
    name = model.name.partition(".")[0][:40]
    descriptor, path = tempfile.mkstemp(prefix=f"dineros-{name}-", suffix=".html")
    os.close(descriptor)
    return Path(path)
