"""Following the traces of a run while its nodes still write them."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from dineros.metamodel.records.coding import RecordDecoder
from dineros.metamodel.records.files import node_traces, trace_pieces
from dineros.metamodel.records.schema import Record


@dataclass
class _Place:
    """Up to where a node's trace is read: a file, by its number in the file system, and lines in it."""

    inode: int
    decoder: RecordDecoder = field(default_factory=RecordDecoder)


class Follower:
    """Reads what is new in the traces of a folder, each time it is asked.

    A file that was rotated away is read to its end before the next; a last line that is not complete, or
    that a crash has cut and the resumed node cut off, is read again.

    Parameters
    ----------
    folder : Path
        The traces of a run; nodes and files may come later.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._places: dict[str, _Place] = {}

    def new(self) -> list[Record]:
        """Return the records written since the last call, node by node, each node's in order.

        Raises
        ------
        RecordError
            A complete line is no record.
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
        files = [(path, path.stat().st_ino) for path in paths if path.exists()]
        place = self._places.get(node)
        if place is not None:
            known = [number for number, (_, inode) in enumerate(files) if inode == place.inode]
            files = files[known[0] :] if known else files
        records: list[Record] = []
        for path, inode in files:
            if place is None or place.inode != inode:
                place = self._places[node] = _Place(inode, RecordDecoder(path))
            place.decoder.source = path
            records += new_records(path, place.decoder)
        return records


def new_records(path: Path, decoder: RecordDecoder) -> list[Record]:
    """Return the records of the lines of a growing file that a decoder has not read yet.

    Raises
    ------
    RecordError
        A complete line is no record, or the file cannot be read.
    """
    try:
        return [record for piece in trace_pieces(path, decoder.position) for record in decoder.feed(piece)]
    finally:
        decoder.forget()
