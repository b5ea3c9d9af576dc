"""The journal of a sweep: finished points, kept next to the output until the output is written."""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import asdict
from pathlib import Path
from typing import Any, BinaryIO

from dineros.analysis.sweeps.grid import Grid, Point, SweepError
from dineros.analysis.sweeps.point import Figures
from dineros.metamodel.errors import Location
from dineros.metamodel.files.locking import open_locked
from dineros.metamodel.files.reading import SIZE_LIMIT
from dineros.metamodel.json_text import JsonTextError, decode_json

FORMAT = 1


class Journal:
    """Figures of finished points, each synchronised to the disk at once.

    The first line describes the sweep; each other line is a point. An incomplete line after a crash is
    ignored.

    Parameters
    ----------
    path : Path
        The file; created if it does not exist.
    model : str
        The model, as XMI.
    limits : list
        Memory and time for a point. Points that failed because of these limits are repeated with other
        limits.

    Raises
    ------
    SweepError
        The file is the journal of another sweep, or of a running one.
    OSError
        It cannot be read or written.
    """

    def __init__(self, path: Path, model: str, grid: Grid, engine: str, limits: list[float | None]) -> None:
        self.path = path
        self.limits = limits
        self.finished: dict[str, Figures] = {}
        file = open_locked(path, os.O_RDWR | os.O_CREAT | os.O_APPEND)
        if file is None:
            raise SweepError("a sweep that writes it is running", location=Location(path))
        self._file: BinaryIO = os.fdopen(file, "a+b")
        try:
            self._begin({"sweep": FORMAT, "of": _hash(model, grid, engine)})
        except BaseException:
            self._file.close()
            raise

    def _begin(self, header: dict[str, Any]) -> None:
        """Read the points of earlier runs, and remove an incomplete last line."""
        self._file.seek(0)
        text = self._file.read(SIZE_LIMIT + 1)
        if len(text) > SIZE_LIMIT:
            raise SweepError(f"is larger than {SIZE_LIMIT >> 20} MiB", location=Location(self.path))
        whole = text[: text.rfind(b"\n") + 1]
        first, *lines = whole.split(b"\n")
        if not whole and not text.startswith(b'{"sweep"'[: len(text)]):
            raise self._foreign()
        if whole and _read(first) != header:
            raise self._foreign()
        self._file.truncate(len(whole))
        if not whole:
            self._append(header)
        self.finished = self._points(lines)

    def _points(self, lines: list[bytes]) -> dict[str, Figures]:
        """Return the points of lines, without those to be repeated with other limits."""
        points: dict[str, Figures] = {}
        for line in lines:
            entry = _read(line) or {}
            key, figures = entry.get("point"), Figures.of(entry.get("figures"))
            if figures is None or not isinstance(key, str):
                continue
            if figures.complete or entry.get("limits") == self.limits:
                points[key] = figures
        return points

    def _foreign(self) -> SweepError:
        return SweepError(
            "is the journal of another sweep: of another model, grid or engine",
            location=Location(self.path),
            hint="complete that sweep, remove the file, or write to another one",
        )

    def add(self, point: Point, figures: Figures) -> None:
        """Store a finished point permanently."""
        self._append({"point": point.key, "limits": self.limits, "figures": asdict(figures)})
        self.finished[point.key] = figures

    def kept(self) -> dict[str, Figures]:
        """Return the points for a later run: those in the file, even if `add` was interrupted.

        Raises
        ------
        OSError
            The file cannot be read, or pending data cannot be written.
        """
        self._file.flush()
        self._file.seek(0)
        _, *lines = self._file.read().split(b"\n")
        return self._points(lines[:-1])

    def _append(self, entry: dict[str, Any]) -> None:
        self._file.write(json.dumps(entry, ensure_ascii=False).encode() + b"\n")
        self._file.flush()
        os.fsync(self._file.fileno())

    def remove(self) -> None:
        """Remove the file: the output has all the data."""
        self.path.unlink(missing_ok=True)

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *exception: object) -> None:
        try:
            if not self.kept():  # nothing was lost either
                self.remove()
        finally:
            self._file.close()


def _hash(model: str, grid: Grid, engine: str) -> str:
    axes = [[axis.features, axis.values] for axis in grid.axes]
    variants = [grid.signals, grid.overflow, grid.reduced]
    return hashlib.sha256(json.dumps([model, axes, variants, engine]).encode()).hexdigest()


def _read(line: bytes) -> dict[str, Any] | None:
    """Return the content of a line; None: the line is damaged."""
    try:
        entry = decode_json(line)
    except JsonTextError:
        return None
    return entry if isinstance(entry, dict) else None
