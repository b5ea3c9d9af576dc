"""Files of records: one trace per node, in one file or in parts rotated by size."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from urllib.parse import quote, unquote

from dineros.metamodel.errors import DinerosError, Location, ModelFileError
from dineros.metamodel.files.atomic import write_atomically
from dineros.metamodel.files.reading import read_pieces
from dineros.metamodel.records.base import Header, Record
from dineros.metamodel.records.coding import RecordDecoder, RecordError, encode_record

SUFFIX = ".jsonl"

_PART = re.compile(r"(?P<node>[^.]+)(?:\.(?P<number>[0-9]{4,}))?\.jsonl")


def current_path(folder: Path, node: str) -> Path:
    """Return the file to which a node writes."""
    return folder / f"{file_name(node)}{SUFFIX}"


def part_path(folder: Path, node: str, number: int) -> Path:
    """Return the file of a rotated part, numbered from 1."""
    return folder / f"{file_name(node)}.{number:04}{SUFFIX}"


def number_of_part(path: Path) -> int | None:
    """Return the number of a rotated part; None for the current file."""
    match = _PART.fullmatch(path.name)
    return int(match["number"]) if match and match["number"] else None


def journals_path(folder: Path) -> Path:
    """Return the list of the nodes with a journal in a folder, by which a missing journal is detected."""
    return folder / ".journals"


def data_folder(folder: Path, node: str) -> Path:
    """Return the folder of large values to which a node's trace refers."""
    return folder / f"{file_name(node)}.data"


def parts_of(folder: Path, node: str) -> list[Path]:
    """Return the files of a node's trace, the oldest first; the current file is the last."""
    return node_traces(folder).get(node, [])


def node_traces(folder: Path) -> dict[str, list[Path]]:
    """Return the files of each node's trace in a folder, the oldest first.

    Raises
    ------
    DinerosError
        The folder cannot be read.
    """
    found: dict[str, list[tuple[float, Path]]] = {}
    try:
        paths = sorted(folder.iterdir())
    except OSError as error:
        raise DinerosError(f"cannot be read: {error.strerror}", location=Location(folder)) from None
    for path in paths:
        match = _PART.fullmatch(path.name)
        if match and path.is_file():
            number = number_of_part(path) or float("inf")
            found.setdefault(unquote(match["node"]), []).append((number, path))
    return {node: [path for _, path in sorted(parts)] for node, parts in found.items()}


def read_records(path: Path) -> Iterator[Record]:
    """Yield the records of one file while reading it.

    An incomplete last line after a crash is skipped.

    Raises
    ------
    RecordError
        A line is not a record, or the file cannot be read.
    """
    decoder = RecordDecoder(path)
    for piece in trace_pieces(path):
        yield from decoder.feed(piece)
    last = decoder.close()
    if last is not None:
        yield last


def trace_pieces(path: Path, start: int = 0) -> Iterator[bytes]:
    """Yield the content of a trace from a position on, piece by piece.

    Raises
    ------
    RecordError
        It is not a regular file, or cannot be read.
    """
    try:
        yield from read_pieces(path, start)
    except ModelFileError as error:
        raise RecordError(error.message, location=error.location, hint=error.hint) from None


def read_trace(paths: Path | Iterable[Path]) -> Iterator[Record]:
    """Yield the records of one trace: of its parts in the given order, or of one file.

    Raises
    ------
    RecordError
        A line is not a record, or sequence numbers do not increase by one.
    """
    expected: int | None = None
    for path in [paths] if isinstance(paths, Path) else paths:
        for record in read_records(path):
            if expected is not None and record.sequence != expected:
                raise RecordError(
                    f"sequence {record.sequence} follows {expected - 1}",
                    location=record.location,
                    hint="a part or a line of the trace is missing",
                )
            expected = record.sequence + 1
            yield record


def traces_of_runs(paths: Iterable[Path]) -> dict[str, list[Path]]:
    """Sort the files of a run by node, and the parts of each node in order, regardless of file names.

    Parameters
    ----------
    paths : iterable of Path
        Files, and folders of traces.

    Raises
    ------
    RecordError
        A file cannot be read, is not a trace of a run, or two files are the same part of one trace.
    """
    files: list[Path] = []
    for path in paths:
        found = [part for parts in node_traces(path).values() for part in parts] if path.is_dir() else [path]
        if not found:
            is_recording = (path / "metadata.yaml").is_file()
            hint = "this is a recording of rosbag2: give it with --bag" if is_recording else ""
            raise RecordError("holds no trace", location=Location(path), hint=hint)
        files += found
    starts: dict[str, dict[int, Path]] = {}
    for file in dict.fromkeys(files):
        first = next(read_records(file), None)
        if first is None:
            raise RecordError("is empty", location=Location(file))
        if not isinstance(first, Header) or first.kind != "run" or first.node is None:
            said = (
                "is a witness, not a trace"
                if isinstance(first, Header) and first.kind == "witness"
                else "is not a trace"
            )
            raise RecordError(f"{said} of a node's run", location=first.location)
        other = starts.setdefault(first.node, {}).setdefault(first.sequence, file)
        if other != file:
            said = f"begins at record {first.sequence} of node {first.node!r}, as {other} does"
            raise RecordError(said, location=first.location, hint="give the traces of one run")
    return {node: [parts[start] for start in sorted(parts)] for node, parts in starts.items()}


def write_records(path: Path, records: Iterable[Record]) -> None:
    """Write a trace, completely or not at all.

    Raises
    ------
    ModelFileError
        The file cannot be written.
    """
    write_atomically(path, "".join(f"{encode_record(record)}\n" for record in records).encode())


def file_name(node: str) -> str:
    """Return the id of a node as part of a file name, without dots, which separate the parts."""
    return quote(node, safe=" ").replace(".", "%2E").replace("~", "%7E")
