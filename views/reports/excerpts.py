"""The lines of source code around those that a finding is about."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from dineros.metamodel.errors import Location, ModelFileError
from dineros.metamodel.files.reading import read_bytes

AROUND = 3
"""Lines that are shown before and after a line."""
MOST = 6
"""Lines of a finding that are shown with what is around them."""
MOST_BYTES = 2 << 20
"""Bytes of a file that is shown."""
LONGEST = 200
"""Characters of a line."""
SUFFIXES = {".py", ".xml", ".yaml", ".yml", ""}
"""Endings of files that are source code."""


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
    """Reads lines around lines.

    The names of files come from a model, so that only files of source code within the roots are read.

    Parameters
    ----------
    roots : iterable of Path
        Folders.
    """

    def __init__(self, roots: Iterable[Path]) -> None:
        self._roots = [root.resolve() for root in roots]
        self._texts: dict[str, list[str]] = {}

    def of(self, places: Iterable[Location]) -> list[Excerpt]:
        """Return what is around some lines; without those that cannot be read."""
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
