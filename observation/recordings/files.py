"""The files of a recording, opened once and read by position: plain files, whatever their names.

The library that reads recordings opens files by name repeatedly. A database may interpret a name differently
than a file system (``%2e%2e`` in an address), and a file can be replaced by a pipe in between. So each file
is opened and checked here, and the library gets an object from which it reads.
"""

from __future__ import annotations

import io
import os
import shlex
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.files.reading import LFS_HINT, LFS_POINTER, open_plain
from dineros.metamodel.limits import hint, most
from dineros.observation.recordings.errors import RecordingError
from dineros.observation.recordings.packing import pieces

UNPACKED = 64 << 20
"""Unpacked bytes that every recording may have; a large one may have its size times the limit `unpacking`."""
FREE_SHARE = 0.5
"""Share of the free space in the folder for temporary files that an unpacked file may use."""

_SMALL = 1 << 16


def most_unpacked(packed: int) -> int:
    """Return the allowed unpacked bytes of a packed file or message, by its size in bytes."""
    return max(UNPACKED, most("unpacking") * packed)


def too_large(location: Location) -> RecordingError:
    """Return the error for unpacking more than allowed."""
    times = most("unpacking")
    return RecordingError(
        f"unpacks to more than {UNPACKED >> 20} MiB and {times} times its size",
        location=location,
        hint=hint("unpacking"),
    )


class StoredFile:
    """A file of a recording, with the interface of the library (its protocol ``RPath``).

    Parameters
    ----------
    descriptor : int
        Of a plain file, open for reading; `close` closes it.
    path : Path
        Its name in errors.
    """

    def __init__(self, descriptor: int, path: Path) -> None:
        self.descriptor, self.path = descriptor, path
        self.size = os.fstat(descriptor).st_size

    def __str__(self) -> str:
        return "it"  # part of the address of a database, and of the library's messages

    def close(self) -> None:
        """Close it."""
        os.close(self.descriptor)

    def open(self, *_: Any, **__: Any) -> BinaryIO:
        """Return a stream of its content."""
        return _Stream(_Positional(self.descriptor, self.size))

    # the rest of the protocol

    def exists(self) -> bool:
        """Return whether it exists."""
        return True

    def is_dir(self) -> bool:
        """Return whether it is a folder."""
        return False

    def read_text(self, encoding: str | None = None) -> str:
        """Return its text."""
        with self.open() as stream:
            return stream.read().decode(encoding or "utf-8")

    def stat(self, *, follow_symlinks: bool = True) -> os.stat_result:
        """Return its status."""
        return os.fstat(self.descriptor)

    def __truediv__(self, _: object) -> StoredFile:
        return self

    @property
    def stem(self) -> str:
        """Its name without the suffix."""
        return self.path.stem

    @property
    def suffix(self) -> str:
        """The suffix of its name."""
        return self.path.suffix


@contextmanager
def stored(path: Path, *, follow_links: bool) -> Iterator[StoredFile]:
    """Open a plain file of a recording.

    Raises
    ------
    DinerosError
        It does not exist, or is not a plain file, a link that is not followed, empty, or not the recording
        itself.
    """
    try:
        file = StoredFile(open_plain(path, follow_links=follow_links), path)
    except FileNotFoundError:
        raise RecordingError("is missing", location=Location(path)) from None
    try:
        _look_at(file)
        yield file
    finally:
        file.close()


def _look_at(file: StoredFile) -> None:
    location = Location(file.path)
    if not file.size:
        raise RecordingError("is empty", location=location)
    with file.open() as stream:
        if stream.read(len(LFS_POINTER)) == LFS_POINTER:
            raise RecordingError(
                "is a pointer of Git LFS, not the recording", location=location, hint=LFS_HINT
            )
    if file.path.suffix == ".db3":
        left = file.path.with_name(f"{file.path.name}-wal")
        if left.exists() and left.stat().st_size:
            raise RecordingError(
                f"is not complete: {left.name} holds messages that are not yet in it",
                location=location,
                hint=f'`sqlite3 {shlex.quote(file.path.name)} "PRAGMA wal_checkpoint(TRUNCATE)"` does',
            )


@contextmanager
def unpacked(file: StoredFile, bytes_left: int) -> Iterator[StoredFile]:
    """Unpack a file that was packed by zstd into a temporary file without a name, which never remains.

    Parameters
    ----------
    file : StoredFile
        The packed file.
    bytes_left : int
        The largest allowed size.

    Raises
    ------
    DinerosError
        It would become larger, or there is not enough space.
    """
    location = Location(file.path)
    folder = tempfile.gettempdir()
    status = os.statvfs(folder)
    room = int(status.f_bavail * status.f_frsize * FREE_SHARE)
    with tempfile.TemporaryFile(dir=folder) as made:
        size = 0
        with file.open() as packed:
            for piece in pieces(packed, "zstd", file.size):
                size += len(piece)
                if size > bytes_left:
                    raise too_large(location)
                if size > room:
                    raise DinerosError(
                        f"unpacks to more than half of what is free in {folder}",
                        location=location,
                        hint="set TMPDIR to a folder with more space, or unpack it: "
                        f"`zstd -d {shlex.quote(file.path.name)}`",
                    )
                made.write(piece)
        made.flush()
        yield StoredFile(made.fileno(), file.path.with_suffix(""))


class _Positional(io.RawIOBase):
    """A stream of a file that others may read at the same time: each has its own position."""

    def __init__(self, descriptor: int, size: int) -> None:
        self._descriptor, self.size, self._at = descriptor, size, 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        count = os.preadv(self._descriptor, [buffer], self._at)
        self._at += count
        return count

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        base = {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self.size}[whence]
        if base + offset < 0:
            raise ValueError("a position before the start")
        self._at = base + offset
        return self._at

    def tell(self) -> int:
        return self._at


class _Stream(io.BufferedReader):
    """Limits reads to the size of the file: a record of four bytes may declare a length of 2^62."""

    def __init__(self, raw: _Positional) -> None:
        super().__init__(raw, _SMALL)
        self._size = raw.size

    def read(self, size: int | None = -1, /) -> bytes:
        if size is not None and 0 <= size <= _SMALL:
            return super().read(size)
        left = max(0, self._size - self.tell())
        return super().read(left if size is None or size < 0 else min(size, left))
