"""Writes a picture of a net to a file; the suffix selects the format."""

from __future__ import annotations

import math
from pathlib import Path

from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.files.atomic import write_atomically
from dineros.views.nets.contents.model import ViewModel
from dineros.views.nets.drawing.page import to_html
from dineros.views.nets.drawing.paper import Paper, Sheet, file_name, sheets_for
from dineros.views.nets.drawing.png import to_png
from dineros.views.nets.drawing.svg import Theme, to_svg
from dineros.views.nets.placement.placing import layout

FORMATS = (".svg", ".png", ".html")
"""Suffixes of pictures."""


PRINT_SCALE = 600 / 96
"""Scale of PNG files for paper: 600 dots per inch, as journals require for line drawings."""


def save_for_paper(
    view: ViewModel, path: Path | str, paper: Paper, *, theme: Theme = "light"
) -> tuple[list[Path], list[Sheet]]:
    """Draw a view for paper into a file, or, if it is too large, its overview and pages into several.

    Parameters
    ----------
    view : ViewModel
        The view.
    path : path
        A file ending in ``.svg`` or ``.png``; those of pages have their ids appended to its name.
    paper : Paper
        The room.
    theme : {"light", "dark"}
        Colours.

    Returns
    -------
    written : list of Path
        The files.
    too_large : list of Sheet
        What was not drawn, since its text would be too small.

    Raises
    ------
    DinerosError
        Nothing fits, or something cannot be drawn or written.
    """
    path = Path(path)
    sheets = sheets_for(view, paper)
    fitting = [sheet for sheet in sheets if sheet.needed <= paper.width]
    too_large = [sheet for sheet in sheets if sheet.needed > paper.width]
    if not fitting:
        raise DinerosError(
            f"{view.title} is too large for {paper.width:g} mm: some text would have less than 6 points",
            location=Location(path),
            hint=f"it needs {math.ceil(min(sheet.needed for sheet in sheets))} mm; or draw only a part",
        )
    contents: dict[Path, bytes] = {}
    for sheet in fitting:
        name = path if sheet.page is None else path.with_stem(f"{path.stem}-{file_name(sheet.page)}")
        while name in contents:
            name = name.with_stem(f"{name.stem}_")
        svg = to_svg(sheet.positioned, theme=theme, paper=paper)
        contents[name] = svg.encode() if path.suffix.lower() == ".svg" else to_png(svg, scale=PRINT_SCALE)
    for name, content in contents.items():
        write_atomically(name, content)
    return list(contents), too_large


def save_picture(view: ViewModel, path: Path | str, *, theme: Theme = "light") -> None:
    """Draw a view into a file atomically.

    Parameters
    ----------
    view : ViewModel
        The view, drawn as it is; `collapse_if_large` makes a picture of a large one readable.
    path : path
        A file ending in ``.svg``, ``.png`` or ``.html``.
    theme : {"light", "dark"}
        Colours of SVG and PNG; a page follows its reader's.

    Raises
    ------
    DinerosError
        The format is unknown, a package that draws is missing, or the file cannot be written.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix == ".html":
        content = to_html(view).encode()
    elif suffix in FORMATS:
        svg = to_svg(layout(view), theme=theme)
        content = svg.encode() if suffix == ".svg" else to_png(svg)
    else:
        raise DinerosError(
            f"{suffix!r} is not a format of pictures" if suffix else "has no suffix",
            location=Location(path),
            hint=f"known are {', '.join(FORMATS)}",
        )
    write_atomically(path, content)
