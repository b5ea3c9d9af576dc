"""Widths of text in the font of pictures, for the layout of labels.

The font is Liberation Sans, whose widths are those of Arial and Helvetica: a picture looks the same with any
of the three.
"""

from __future__ import annotations

import textwrap
import unicodedata

_FIRST = 32
# Advance widths of the characters from the space to the tilde, in thousandths of the font size.
_REGULAR = (
    "278 278 355 556 556 889 667 191 333 333 389 584 278 333 278 278 556 556 556 556 556 556 556 556 556 "
    "556 278 278 584 584 584 556 1015 667 667 722 722 667 611 778 722 278 500 667 556 833 722 778 667 778 "
    "722 667 611 722 667 944 667 667 611 278 278 278 469 556 333 556 556 500 556 556 278 556 556 222 222 "
    "500 222 833 556 556 556 556 333 500 278 556 500 722 500 500 500 334 260 334 584"
)
_BOLD = (
    "278 333 474 556 556 889 722 238 333 333 389 584 278 333 278 278 556 556 556 556 556 556 556 556 556 "
    "556 333 333 584 584 584 611 975 722 722 722 722 667 611 778 722 278 556 722 611 833 722 778 667 778 "
    "722 667 611 722 667 944 667 667 611 333 278 333 584 556 333 556 611 556 611 556 333 611 611 278 278 "
    "556 278 889 611 611 611 611 389 556 333 611 556 778 556 556 500 389 280 389 584"
)
_WIDTHS = {bold: [int(width) for width in text.split()] for bold, text in ((False, _REGULAR), (True, _BOLD))}
_OTHER, _WIDE = 0.7, 1.05  # a letter beyond ASCII, a full-width one; both generous


def text_width(text: str, size: float, *, bold: bool = False) -> float:
    """Return the width of a line of text in pixels.

    Parameters
    ----------
    text : str
        The line.
    size : float
        Size of the font in pixels.
    bold : bool
        Whether it is bold.
    """
    widths = _WIDTHS[bold]
    total = 0.0
    for character in text:
        place = ord(character) - _FIRST
        if 0 <= place < len(widths):
            total += widths[place] / 1000
        elif unicodedata.east_asian_width(character) in "WF":
            total += _WIDE
        elif not unicodedata.combining(character):
            total += _OTHER
    return total * size


def wrap(text: str, characters: int) -> list[str]:
    """Break a text into lines of about as many characters; long words break after a dot or underscore."""
    lines: list[str] = []
    for line in textwrap.wrap(text, characters, break_long_words=False) or [""]:
        rest = line
        while len(rest) > characters * 1.3:
            cut = max(rest.rfind(mark, 4, characters) for mark in "._-/@") + 1
            cut = cut if cut > 4 else characters
            lines.append(rest[:cut])
            rest = rest[cut:]
        lines.append(rest)
    return lines
