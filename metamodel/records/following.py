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
        The traces of a run; nodes and files may be added later.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._places: dict[str, _Place] = {}

    def new(self) -> list[Record]:
        """Return the records written since the last call, node by node, each node's in order.

        Raises
        ------
        RecordError
            A complete line is not a record.
        DinerosError
            The folder cannot be read.
        """
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
            for record in new_records(path, place.decoder, file):
                if record.sequence > place.last:  # it may have been read before a rotation
                    place.last = record.sequence
                    records.append(record)
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


def new_records(path: Path, decoder: RecordDecoder, file: _File | None = None) -> list[Record]:
    """Return the records of new lines in a growing file.

    Parameters
    ----------
    path : Path
        The file.
    decoder : RecordDecoder
        Knows the position up to which it was read.
    file : _File, optional
        The expected file: nothing is read if another file has this path meanwhile.

    Raises
    ------
    RecordError
        A complete line is not a record, or the file cannot be read.
    """
    try:
        if file is None:
            return [
                record for piece in trace_pieces(path, decoder.position) for record in decoder.feed(piece)
            ]
        pieces = list(trace_pieces(path, decoder.position)) if _is_at(path, file) else []
        if not _is_at(path, file):  # rotated or removed while it was read, or before
            return []
        return [record for piece in pieces for record in decoder.feed(piece)]
    finally:
        decoder.forget()
