"""Lines of source code."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Place:
    """A line of a file."""

    file: str
    """Path, relative to the folder that was read."""
    line: int
    """Counted from 1."""

    def __str__(self) -> str:
        return f"{self.file}:{self.line}"


def located(place: Place, folder: str) -> str:
    """Return a line of code as ``file:line``, with the folder of the file.

    Examples
    --------
    >>> located(Place("arm/mover.py", 7), "src"), located(Place("mover.py", 7), ".")
    ('src/arm/mover.py:7', 'mover.py:7')
    """
    return str(place) if folder in ("", ".") else f"{folder.rstrip('/')}/{place}"
