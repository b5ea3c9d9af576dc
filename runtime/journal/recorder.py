"""The recorder of a journal: one write per line, appended to a file that is rotated by size."""

from __future__ import annotations

import contextlib
import fcntl
import logging
import os
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.files.locking import open_locked
from dineros.metamodel.files.reading import open_plain, read_bytes
from dineros.metamodel.records import (
    SCHEMA,
    Header,
    RecordDecoder,
    current_path,
    encode_fields,
    part_path,
    parts_of,
    read_records,
    with_checksum,
)
from dineros.metamodel.records.coding import LINE_LIMIT
from dineros.metamodel.records.files import file_name, journals_path, number_of_part
from dineros.runtime.journal.outlined import Outlined
from dineros.runtime.journal.rebuilding import rebuild_at
from dineros.runtime.journal.saved import SavedState
from dineros.runtime.nets.ports import Ports

LOG = logging.getLogger("dineros.runtime")
PART_BYTES = 16 << 20
KEPT_PARTS = 8
DATA_BYTES = 4096
LARGE_CHECKPOINT = 1 << 20
"""Size in bytes from which the token data of large places is stored outside of a checkpoint's line."""


class JournalError(DinerosError):
    """A journal cannot be written, or belongs to another run."""


class _TooLongError(JournalError):
    """A line would exceed the length that is read back."""


class JournalRecorder:
    """Writes the records of one node to ``FOLDER/NODE.jsonl``.

    Each record is one line, written by a single `write`. So if the process dies, the operating system has all
    lines written so far; only the last line may be incomplete, and `resume_journal` removes it. A part that
    has reached `part_bytes` is renamed to ``NODE.0001.jsonl`` and so on; only the last `kept_parts` of these
    are kept. Each file begins with a header and a checkpoint, and each line ends with a checksum. If a
    checkpoint is larger than `part_bytes`, the part may grow by the size of the checkpoint, so that at most
    half of the written data is checkpoints.

    Parameters
    ----------
    folder : Path
        Created if it does not exist.
    node : str
        Id of the node net.
    source : str
        The file the node was loaded from.
    settings : sequence of str
        Settings that changed the model for this run, as for `--set`.
    simulated : bool
        Whether the run uses simulated time, which the times of its records are not.
    part_bytes : int
        Size of a part; a line is never split.
    kept_parts : int or None
        Number of full parts that are kept; None: all.
    data_bytes : int
        Size of a token field above which its value is stored separately, once (see `Outlined`).
    synchronise : bool
        Whether each line waits for the disk, so that the journal survives a power failure.
    resumed : tuple of int, str and int, optional
        The open file to append to, its model and its next sequence number, from `resume_journal`.

    Raises
    ------
    JournalError
        The folder contains a trace of the node already, or cannot be written.
    """

    def __init__(
        self,
        folder: Path,
        node: str,
        *,
        source: str = "",
        settings: Sequence[str] = (),
        simulated: bool = False,
        part_bytes: int = PART_BYTES,
        kept_parts: int | None = KEPT_PARTS,
        data_bytes: int = DATA_BYTES,
        synchronise: bool = False,
        resumed: tuple[int, str, int] | None = None,
    ) -> None:
        self._folder = folder
        self._node = node
        self._source = source
        self._settings = list(settings)
        self._simulated = simulated
        self._header: dict[str, object] = {}
        self._part_bytes = part_bytes
        self._kept_parts = kept_parts
        self._outlined = Outlined(folder, node, data_bytes, synchronise)
        self._long_line = min(data_bytes, DATA_BYTES)
        self._synchronise = synchronise
        self._path = current_path(folder, node)
        self._sequence = 0
        self._part = 0
        self._size = 0
        self._full = part_bytes
        """Size at which the part is rotated."""
        self._file = -1
        self._checkpoint: Callable[[], SavedState] | None = None
        self._model: str | None = None
        if resumed is not None:
            self._file, self._model, self._sequence = resumed
            self._size = os.fstat(self._file).st_size
            self._part = max((number_of_part(path) or 0 for path in parts_of(folder, node)), default=0)
            return
        with self._writing():
            folder.mkdir(parents=True, exist_ok=True)
        if parts_of(folder, node):
            raise JournalError(
                f"has a trace of node {node!r} already",
                location=Location(folder),
                hint="resume it, or record in another folder",
            )

    def open(self, ports: Ports, checkpoint: Callable[[], SavedState]) -> None:
        """Begin the file with a header and a checkpoint; append only a checkpoint to a resumed journal.

        Raises
        ------
        JournalError
            The file cannot be written, another process writes it, or it belongs to another model.
        """
        if self._model not in (None, ports.model):
            raise JournalError(
                f"is of model {self._model!r}, not of {ports.model!r}", location=Location(self._path)
            )
        self._header = {
            "schema": SCHEMA,
            "kind": "run",
            "model": ports.model,
            "source": self._source,
            "settings": self._settings,
            **({"simulated": True} if self._simulated else {}),
        }
        self._checkpoint = checkpoint
        if self._file < 0:
            self._begin_part()
            self._list()
        else:
            self.record("checkpoint", **checkpoint())

    def record(self, event: str, **fields: object) -> None:
        """Write one record.

        Raises
        ------
        JournalError
            It cannot be written.
        """
        self._write(self._file, event, fields)
        if self._size >= self._full:
            self._rotate()

    def close(self) -> None:
        """Wait until the whole journal is on disk, and close it."""
        if self._file >= 0:
            with contextlib.suppress(OSError):
                os.fsync(self._file)
            os.close(self._file)
            self._file = -1

    def _write(self, file: int, event: str, fields: dict[str, object]) -> None:
        values = {"time": time.time(), "node": self._node, **fields}
        line = encode_fields(event, self._sequence, values)
        if len(line) > self._long_line:
            with self._writing():
                values = self._outlined.outline(values)
                if event == "checkpoint" and len(line) > LARGE_CHECKPOINT:
                    values = self._outlined.outline_places(values)
                line = encode_fields(event, self._sequence, values)
        content = with_checksum(line) + b"\n"
        if len(content) > LINE_LIMIT:
            raise _TooLongError(
                f"cannot have a line of {len(content):,} bytes", location=Location(self._path)
            )
        with self._writing():
            try:
                written = os.write(file, content)
                while written < len(content):
                    written += os.write(file, content[written:])
                if self._synchronise:
                    os.fdatasync(file)
            except BaseException:  # also on an interrupt: no line may follow half a line
                os.ftruncate(file, self._size)
                raise
        self._sequence += 1
        self._size += len(content)

    def _rotate(self) -> None:
        old = self._file
        # The new file is complete before it gets its name, so that every file begins with a checkpoint; after
        # a
        # crash in between, the last full part is the journal.
        try:
            self._begin_part(part_path(self._folder, self._node, self._part + 1))
        except _TooLongError:
            self._full = 2 * self._size
            LOG.warning("%s: the state of the node is too large for a checkpoint: the file grows", self._path)
            return
        self._part += 1
        os.close(old)
        self._prune()

    def _prune(self) -> None:
        """Remove the oldest parts, and the large values to which only they refer."""
        if self._kept_parts is None:
            return
        rotated = [path for path in parts_of(self._folder, self._node) if number_of_part(path)]
        for path in rotated[: len(rotated) - self._kept_parts]:
            with self._writing():
                path.unlink(missing_ok=True)
        oldest = next(iter(rotated[len(rotated) - self._kept_parts :]), self._path)
        first = next(read_records(oldest), None)
        if first is not None and first.time is not None:
            self._outlined.prune(first.time)

    def _list(self) -> None:
        """Register the journal of the node in the folder, so that its loss is detected."""
        with self._writing():
            flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND
            file = open_plain(journals_path(self._folder), flags, follow_links=False)
            try:
                os.write(file, f"{file_name(self._node)}\n".encode())
            finally:
                os.close(file)

    def _begin_part(self, rotated: Path | None = None) -> None:
        """Begin a new file; an old one, if given, becomes a rotated part."""
        assert self._checkpoint is not None, "open() comes first"
        fresh = self._path.with_name(f".{self._path.name}.tmp")
        former = self._size, self._sequence
        self._size, stored = 0, self._outlined.written
        with self._writing():
            file = open_plain(fresh, os.O_WRONLY | os.O_CREAT | os.O_APPEND, follow_links=False)
        try:
            _lock(file, self._path)
            os.ftruncate(file, 0)  # a killed node may have left an incomplete file
            self._write(file, "header", {**self._header})
            self._write(file, "checkpoint", {**self._checkpoint()})
            with self._writing():
                if self._synchronise:
                    os.fsync(file)
                if rotated is not None:
                    self._path.rename(rotated)
                fresh.rename(self._path)
        except BaseException:
            os.close(file)
            fresh.unlink(missing_ok=True)
            self._size, self._sequence = former
            raise
        self._file = file
        self._full = self._size + max(self._part_bytes, self._size + self._outlined.written - stored)

    @contextlib.contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            reason = error.strerror or str(error)
            raise JournalError(f"cannot be written: {reason}", location=Location(self._path)) from error


def _lock(file: int, path: Path) -> None:
    """Prevent other processes from writing the same journal while this process lives."""
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        raise _is_written(path) from None


def _is_written(path: Path) -> JournalError:
    return JournalError(
        "is being written by another process", location=Location(path), hint="stop that process first"
    )


def resume_journal(
    folder: Path, node: str, *, source: str = "", **options: Any
) -> tuple[JournalRecorder, SavedState | None]:
    """Continue the journal of a node that has ended normally or crashed.

    An incomplete last line is removed: it was never recorded, and nothing depends on it.

    Parameters
    ----------
    folder, node, source, **options
        As for `JournalRecorder`.

    Returns
    -------
    recorder : JournalRecorder
        Appends to the journal.
    checkpoint : SavedState or None
        The saved state of the node; None if it has no journal yet.

    Raises
    ------
    JournalError
        Another process writes the journal, or it cannot be written.
    RecordError
        A line is not a record.
    """
    path = current_path(folder, node)
    parts = parts_of(folder, node) if folder.is_dir() else []
    if not parts:
        return _new_journal(folder, node, source, options), None
    try:
        if not path.exists():  # a crash between the two renames of a rotation
            parts[-1].rename(path)
        # Its writer may rename the file, as a full part, before it is locked here.
        file = open_locked(path, os.O_RDWR | os.O_APPEND)
    except OSError as error:
        raise JournalError(f"cannot be written: {error.strerror}", location=Location(path)) from error
    if file is None:
        raise _is_written(path)
    try:
        path.with_name(f".{path.name}.tmp").unlink(missing_ok=True)
        _complete_last_line(file, path)
        header = next(read_records(path), None)
        if not isinstance(header, Header):
            raise JournalError("does not begin with a header", location=Location(path))
        state = rebuild_at(folder, node)
        if not state.has_begun:
            raise JournalError(
                "holds no state of its node: the checkpoint after the header is missing",
                location=Location(path),
            )
    except DinerosError as error:
        os.close(file)
        error.hint = error.hint or _what_to_do(path)
        raise
    except BaseException:
        os.close(file)
        raise
    at = (file, header.model, state.next_sequence)
    recorder = JournalRecorder(folder, node, source=source, resumed=at, **options)
    return recorder, state.checkpoint()


def _what_to_do(path: Path) -> str:
    return f"restore it from a copy, or start all nodes again in another folder; {path.parent} stays as it is"


def _new_journal(folder: Path, node: str, source: str, options: dict[str, Any]) -> JournalRecorder:
    """Begin a journal; an error if the node had one that is missing."""
    path = current_path(folder, node)
    if journals_path(folder).exists():
        had = read_bytes(journals_path(folder), follow_links=False).decode(errors="replace").split("\n")
        if file_name(node) in had:
            raise JournalError("is missing", location=Location(path), hint=_what_to_do(path))
        LOG.warning("%s has no journal of node %s: it begins with its initial marking", folder, node)
    return JournalRecorder(folder, node, source=source, **options)


def _complete_last_line(file: int, path: Path) -> None:
    """Remove an incomplete last line; if only its line feed is missing, add it."""
    size = os.fstat(file).st_size
    start, pieces = size, [b""]  # in reverse order
    while start > 0 and b"\n" not in pieces[-1]:
        step = min(1 << 16, start)
        start -= step
        pieces.append(os.pread(file, step, start))
    pieces[-1] = pieces[-1].rpartition(b"\n")[2]
    last = b"".join(reversed(pieces))
    if not last:
        return
    decoder = RecordDecoder(path)
    list(decoder.feed(last))
    if decoder.close() is not None:
        os.write(file, b"\n")
    else:
        os.ftruncate(file, size - len(last))
        LOG.warning("%s: a crash has cut the last line after %d bytes, which are removed", path, len(last))
