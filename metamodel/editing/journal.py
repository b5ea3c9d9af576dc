"""The journal beside a model that is edited: what was confirmed survives the process that confirmed it.

A file ``.NAME.dineros-journal`` of lines of JSON: first what the model's file held, then what was done,
undone, done again and saved. A line is on the disk before anybody is told that it was done. Whoever edits
the model holds a lock on it (flock(2)), which ends with the process.
"""

from __future__ import annotations

import base64
import contextlib
import hashlib
import json
import os
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.files.locking import open_locked
from dineros.metamodel.files.reading import SIZE_LIMIT
from dineros.metamodel.json_text import decode_json

VERSION = 1
MOST_BYTES = 4 * SIZE_LIMIT
"""Of a journal."""

PRIVATE = 0o600
"""Mode of a journal. It holds the whole model, which only its owner may be allowed to read."""


class JournalError(DinerosError):
    """A journal that cannot be written, or read again."""


def journal_of(path: Path) -> Path:
    """Return where the journal of a model's file stands."""
    return path.with_name(f".{path.name}.dineros-journal")


def digest(content: bytes | None) -> str | None:
    """Return by what the content of a file is known again."""
    return None if content is None else hashlib.sha256(content).hexdigest()


class Journal:
    """An open journal, which nobody else has open.

    Parameters
    ----------
    path : Path
        The journal; it is made if it is not there.

    Attributes
    ----------
    entries : list of dict
        What stood in it, the first line included; empty for a new one.

    Raises
    ------
    JournalError
        Another process edits the model, or the journal cannot be read or written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            file = open_locked(path, os.O_RDWR | os.O_CREAT, PRIVATE)
        except OSError as error:
            raise self._error(f"cannot be made: {error.strerror}") from error
        if file is None:
            raise JournalError(
                "is being edited by another process", location=Location(path), hint="end that one first"
            )
        self._file = file
        try:
            os.fchmod(self._file, PRIVATE)
            self.entries = self._read()
        except OSError as error:
            os.close(self._file)
            raise self._error(f"cannot be kept private: {error.strerror}") from error
        except BaseException:
            os.close(self._file)
            raise

    def _read(self) -> list[dict[str, Any]]:
        size = os.fstat(self._file).st_size
        if size > MOST_BYTES:
            raise self._error(f"is larger than {MOST_BYTES >> 20} MiB")
        content = bytearray()
        while piece := os.read(self._file, 1 << 20):
            content += piece
        # A last line without its end was never confirmed.
        self._size = content.rfind(b"\n") + 1
        entries: list[dict[str, Any]] = []
        for number, line in enumerate(bytes(content[: self._size]).splitlines(), 1):
            entry = decode_json(line, location=Location(self.path, number))
            if not isinstance(entry, dict):
                raise self._error("holds a line that is not an entry", number)
            entries.append(entry)
        if entries and entries[0].get("version") != VERSION:
            raise self._error("is of another version", 1)
        return entries

    @property
    def size(self) -> int:
        """How many bytes are in it."""
        return self._size

    def begin(self, content: bytes | None) -> None:
        """Forget everything, and begin with what the model's file holds.

        Raises
        ------
        JournalError
            It cannot be written.
        """
        with self._said():
            os.ftruncate(self._file, 0)
        self._size = 0
        base = None if content is None else base64.b64encode(zlib.compress(content)).decode()
        self.append({"version": VERSION, "base": base, "digest": digest(content)})
        with contextlib.suppress(OSError):  # where the file system can, its name survives a power cut
            folder = os.open(self.path.parent, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
            try:
                os.fsync(folder)
            finally:
                os.close(folder)

    def base(self) -> bytes | None:
        """Return what the model's file held at the beginning.

        Raises
        ------
        JournalError
            The first line does not say it.
        """
        said = self.entries[0].get("base")
        if said is None:
            return None
        try:
            unpacking = zlib.decompressobj()
            content = unpacking.decompress(base64.b64decode(str(said), validate=True), SIZE_LIMIT)
        except (ValueError, zlib.error) as error:
            raise self._error("does not hold the model it began with", 1) from error
        if not unpacking.eof or digest(content) != self.entries[0].get("digest"):
            raise self._error("does not hold the model it began with", 1)
        return content

    def append(self, entry: Mapping[str, Any]) -> None:
        """Write a line, and wait until it is on the disk.

        Raises
        ------
        JournalError
            It cannot be written; the journal is as it was.
        """
        line = json.dumps(entry, ensure_ascii=False, separators=(",", ":")).encode() + b"\n"
        if self._size + len(line) > MOST_BYTES:
            raise self._error("is full", hint="save the model")
        try:
            with self._said():
                written = 0
                while written < len(line):
                    written += os.pwrite(self._file, line[written:], self._size + written)
                os.fdatasync(self._file)
        except JournalError:
            with contextlib.suppress(OSError):
                os.ftruncate(self._file, self._size)
            raise
        self._size += len(line)

    def close(self, *, remove: bool) -> None:
        """Let others edit the model; take the file away where nothing in it is needed any more."""
        if self._file < 0:
            return
        if remove:
            with contextlib.suppress(OSError):
                self.path.unlink()
        os.close(self._file)
        self._file = -1

    @contextlib.contextmanager
    def _said(self) -> Any:
        try:
            yield
        except OSError as error:
            raise self._error(f"cannot be written: {error.strerror}") from error

    def _error(self, message: str, line: int | None = None, hint: str | None = None) -> JournalError:
        hint = hint or "move it away to continue without what it holds"
        return JournalError(message, location=Location(self.path, line), hint=hint)
