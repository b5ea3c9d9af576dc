"""Writing a picture of a net into a file; its suffix tells the format."""

from __future__ import annotations

from pathlib import Path

from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.files.atomic import write_atomically
from dineros.views.nets.contents.model import ViewModel
from dineros.views.nets.drawing.page import to_html
from dineros.views.nets.drawing.png import to_png
from dineros.views.nets.drawing.svg import Theme, to_svg
from dineros.views.nets.placement.placing import layout

FORMATS = (".svg", ".png", ".html")
"""Suffixes of pictures."""


def save_picture(view: ViewModel, path: Path | str, *, theme: Theme = "light") -> None:
    """Draw a view into a file, as a whole or not at all.

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
            f"{suffix!r} is no format of pictures" if suffix else "has no suffix",
            location=Location(path),
            hint=f"known are {', '.join(FORMATS)}",
        )
    write_atomically(path, content)
