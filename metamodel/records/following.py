"""Reads the traces of a run while its nodes still write them."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from dineros.metamodel.errors import ModelFileError
from dineros.metamodel.files.reading import open_plain
from dineros.metamodel.records.base import Record
from dineros.metamodel.records.coding import RecordDecoder
from dineros.metamodel.records.files import node_traces, trace_pieces

_HEAD = 64
"""Number of bytes that contain the sequence number of the first record."""


class _File(NamedTuple):
    """A file, independent of its name: its inode number, which may be reused, and its first bytes."""

    inode: int
    head: bytes


@dataclass
class _Place:
    """The position up to which a node's trace was read: a file, lines in it, the last sequence number."""

    file: _File
    last: int = -1
    decoder: RecordDecoder = field(default_factory=RecordDecoder)


class Follower:
    """Reads the new records in the traces of a folder, at each call.

    A rotated file is read to its end before the next one; an incomplete last line, also one that a restarted
    node has removed, is read again.

    Parameters
    ----------
    folder : Path
        The traces of a run; nodes and files may come later.
    batch : int, optional
        Pieces of each node's trace (see `read_pieces`) that are read at a time; all if not given. A long line
        is read whole.

    Attributes
    ----------
    is_behind : bool
        Whether there is more than was read the last time.
    """

    def __init__(self, folder: Path, batch: int | None = None) -> None:
        self.is_behind = False
        self._folder = folder
        self._batch = batch
        self._places: dict[str, _Place] = {}

    def new(self) -> list[Record]:
        """Return the records written since the last call, or a batch, node by node, each node's in order.

        Raises
        ------
        RecordError
            A complete line is not a record.
        DinerosError
            The folder cannot be read.
        """
        self.is_behind = False
        if not self._folder.is_dir():
            return []
        records: list[Record] = []
        for node, paths in node_traces(self._folder).items():
            records += self._new_of(node, paths)
        return records

    def _new_of(self, node: str, paths: list[Path]) -> list[Record]:
        place = self._places.get(node)
        known = [path for path in paths if place is not None and _is_at(path, place.file)]
        records: list[Record] = []
        for path in paths[paths.index(known[0]) :] if known else paths:
            file = _file_at(path)
            if file is None:
                continue
            if place is None or place.file != file:
                last = -1 if place is None else place.last
                place = self._places[node] = _Place(file, last, RecordDecoder(path))
            place.decoder.source = path
            found, is_more = _read(path, place.decoder, file, self._batch)
            for record in found:
                if record.sequence > place.last:  # a part that was read before may be the oldest that is kept
                    place.last = record.sequence
                    records.append(record)
            if is_more:
                self.is_behind = True
                break
        return records


def _file_at(path: Path) -> _File | None:
    """Return the file at a path; None: there is none, or its first record is incomplete."""
    try:
        file = open_plain(path)
    except (OSError, ModelFileError):
        return None
    try:
        head, comma, _ = os.pread(file, _HEAD, 0).partition(b",")
        return _File(os.fstat(file).st_ino, head) if comma else None
    finally:
        os.close(file)


def _is_at(path: Path, file: _File) -> bool:
    try:
        return path.stat().st_ino == file.inode and _file_at(path) == file
    except OSError:
        return False


def new_records(path: Path, decoder: RecordDecoder) -> list[Record]:
    """Return the records of the lines of a growing file that a decoder has not read yet.

    Parameters
    ----------
    path : Path
        The file.
    decoder : RecordDecoder
        Knows up to where it was read.

    Raises
    ------
    RecordError
        A complete line is not a record, or the file cannot be read.
    """
    return _read(path, decoder, None, None)[0]


def _read(
    path: Path, decoder: RecordDecoder, file: _File | None, most: int | None
) -> tuple[list[Record], bool]:
    """Return new records, and whether there may be more of them.

    Nothing is read if the path has become that of another file meanwhile.
    """
    pieces: list[bytes] = []
    has_line = is_more = False
    try:
        if file is None or _is_at(path, file):
            for piece in trace_pieces(path, decoder.position):
                pieces.append(piece)
                has_line = has_line or b"\n" in piece
                if most is not None and len(pieces) >= most and has_line:
                    is_more = True
                    break
        if file is not None and not _is_at(path, file):  # rotated away, or removed, meanwhile or before
            return [], False
        return [record for piece in pieces for record in decoder.feed(piece)], is_more
    finally:
        decoder.forget()
