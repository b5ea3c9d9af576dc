"""Source code around the lines of a finding."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from dineros.metamodel.errors import Location, ModelFileError
from dineros.metamodel.files.reading import read_bytes

AROUND = 3
"""Number of lines that are shown before and after a line."""
MOST = 6
"""Limit of the lines of a finding that are shown with their context."""
MOST_BYTES = 2 << 20
"""Limit of the bytes of a file that is shown."""
LONGEST = 200
"""Limit of the characters of a line."""
SUFFIXES = {".py", ".xml", ".yaml", ".yml", ""}
"""Suffixes of source code."""


@dataclass(frozen=True)
class Excerpt:
    """Some lines of a file.

    Attributes
    ----------
    place : str
        File and line, as ``file:line``.
    lines : sequence of (int, str, bool)
        Number and text of each line, and whether it is the one in question.
    """

    place: str
    lines: Sequence[tuple[int, str, bool]]


class Excerpts:
    """Reads the context of lines.

    File names come from a model, so only source files within the roots are read.

    Parameters
    ----------
    roots : iterable of Path
        Folders.
    """

    def __init__(self, roots: Iterable[Path]) -> None:
        self._roots = [root.resolve() for root in roots]
        self._texts: dict[str, list[str]] = {}

    def of(self, places: Iterable[Location]) -> list[Excerpt]:
        """Return the context of some lines, without those that cannot be read."""
        found = []
        for place in list(places)[:MOST]:
            if place.file is None or place.line is None:
                continue
            lines = self._lines(str(place.file))
            if not 1 <= place.line <= len(lines):
                continue
            first, last = max(1, place.line - AROUND), min(len(lines), place.line + AROUND)
            shown = [
                (number, lines[number - 1][:LONGEST], number == place.line)
                for number in range(first, last + 1)
            ]
            found.append(Excerpt(str(place), shown))
        return found

    def _lines(self, name: str) -> list[str]:
        if name not in self._texts:
            self._texts[name] = self._read(name)
        return self._texts[name]

    def _read(self, name: str) -> list[str]:
        try:
            path = Path(name).resolve()
            is_inside = any(path.is_relative_to(root) for root in self._roots)
            if not is_inside or path.suffix.lower() not in SUFFIXES:
                return []
            return read_bytes(path, MOST_BYTES).decode(errors="replace").expandtabs(4).split("\n")
        except (ModelFileError, OSError, RuntimeError, ValueError):
            return []
