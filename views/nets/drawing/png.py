"""Pictures as PNG, drawn by resvg with a font of our own, so that they look the same everywhere."""

from __future__ import annotations

from importlib.resources import as_file, files

from dineros.metamodel.errors import DinerosError

MOST_PIXELS = 80_000_000
"""Limit of the pixels of a picture, which bounds the memory; larger pictures are scaled down."""


def to_png(svg: str, *, scale: float = 2.0) -> bytes:
    """Return a picture as PNG.

    Parameters
    ----------
    svg : str
        A complete SVG file, as `dineros.views.nets.to_svg` returns it.
    scale : float
        Pixels per unit; 2 is sharp on paper and on dense screens. Very large pictures get fewer.

    Raises
    ------
    DinerosError
        The package that draws is not installed, or the picture is not SVG.
    """
    try:
        import resvg_py
    except ImportError as error:
        raise DinerosError("PNG needs the package resvg-py", hint="pip install 'dineros[view]'") from error
    width, height = size_of(svg)
    scale = min(scale, (MOST_PIXELS / max(width * height, 1)) ** 0.5)
    fonts = files("dineros.views") / "vendor" / "fonts"
    with as_file(fonts) as folder:
        try:
            return resvg_py.svg_to_bytes(
                svg_string=svg,
                zoom=scale,
                dpi=96,  # of CSS: what millimetres are
                font_dirs=[str(folder)],
                font_family="Liberation Sans",
                sans_serif_family="Liberation Sans",
            )
        except ValueError as error:
            raise DinerosError(f"the picture cannot be drawn: {error}") from error


def size_of(svg: str) -> tuple[float, float]:
    """Return width and height of an SVG file in pixels of CSS, of which 96 are an inch."""
    import re

    found = re.search(r'<svg[^>]*?\swidth="([\d.]+)(mm)?[^"]*"[^>]*?\sheight="([\d.]+)', svg)
    if not found:
        return 1000.0, 1000.0
    unit = 96 / 25.4 if found[2] else 1.0
    return float(found[1]) * unit, float(found[3]) * unit
