"""The journal of a model being edited: confirmed steps survive the process.

It is a file ``.NAME.dineros-journal`` with lines of JSON: first the content of the model's file, then the
steps executed, undone, redone and saved. A line is on disk before its step is confirmed. The process that
edits the model holds a lock on the file (flock(2)), which ends with the process.
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
"""Maximum size of a journal, in bytes."""

PRIVATE = 0o600
"""Permissions of a journal: it contains the whole model, which may be readable only for its owner."""


class JournalError(DinerosError):
    """A journal cannot be written, or read."""


def journal_of(path: Path) -> Path:
    """Return the path of the journal of a model's file."""
    return path.with_name(f".{path.name}.dineros-journal")


def digest(content: bytes | None) -> str | None:
    """Return a digest that identifies the content of a file."""
    return None if content is None else hashlib.sha256(content).hexdigest()


class Journal:
    """An open journal, locked for other processes.

    Parameters
    ----------
    path : Path
        The journal; it is created if it does not exist.

    Attributes
    ----------
    entries : list of dict
        Its entries when it was opened, including the first line; empty for a new one.

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
        # An incomplete last line was never confirmed.
        self._size = content.rfind(b"\n") + 1
        entries: list[dict[str, Any]] = []
        for number, line in enumerate(bytes(content[: self._size]).splitlines(), 1):
            entry = decode_json(line, location=Location(self.path, number))
            if not isinstance(entry, dict):
                raise self._error("holds a line that is not an entry", number)
            entries.append(entry)
        if entries and entries[0].get("version") != VERSION:
            raise self._error("has another version", 1)
        return entries

    @property
    def size(self) -> int:
        """Size in bytes."""
        return self._size

    def begin(self, content: bytes | None) -> None:
        """Remove all entries, and begin with the content of the model's file.

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
        with contextlib.suppress(OSError):  # if possible, the name survives a power failure
            folder = os.open(self.path.parent, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
            try:
                os.fsync(folder)
            finally:
                os.close(folder)

    def base(self) -> bytes | None:
        """Return the initial content of the model's file.

        Raises
        ------
        JournalError
            The first line does not contain it.
        """
        said = self.entries[0].get("base")
        if said is None:
            return None
        try:
            unpacking = zlib.decompressobj()
            content = unpacking.decompress(base64.b64decode(str(said), validate=True), SIZE_LIMIT)
        except (ValueError, zlib.error) as error:
            raise self._error("does not hold the model with which it began", 1) from error
        if not unpacking.eof or digest(content) != self.entries[0].get("digest"):
            raise self._error("does not hold the model with which it began", 1)
        return content

    def append(self, entry: Mapping[str, Any]) -> None:
        """Write a line, and wait until it is on disk.

        Raises
        ------
        JournalError
            It cannot be written; the journal is unchanged.
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
        """Release the lock; remove the file if nothing in it is needed any more."""
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
        hint = hint or "move it away to continue without its changes"
        return JournalError(message, location=Location(self.path, line), hint=hint)
