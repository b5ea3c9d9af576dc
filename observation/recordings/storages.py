"""Reads the message files of a recording, MCAP and SQLite, by the library rosbags within limits.

The library trusts the file. It unpacks a chunk before it compares sizes, queries a database whose table may
be an endless view, and parses descriptions of any length. Here it is limited by the size of the file.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Collection, Generator, Iterator
from contextlib import contextmanager
from functools import cache
from io import BytesIO
from typing import TYPE_CHECKING, Any, cast

import apsw
from rosbags.rosbag2 import storage_mcap, storage_sqlite3
from rosbags.rosbag2.metadata import parse_qos

from dineros.metamodel.errors import Location
from dineros.observation.recordings.errors import RecordingError
from dineros.observation.recordings.files import StoredFile, most_unpacked, too_large
from dineros.observation.recordings.packing import pieces
from dineros.observation.recordings.plain_yaml import loaded

if TYPE_CHECKING:
    from pathlib import Path

    from rosbags.interfaces import Connection, Qos

Storage = storage_mcap.McapReader | storage_sqlite3.Sqlite3Reader
Stored = tuple["Connection", int, bytes]

QUALITIES = 1 << 20
"""Limit of the characters of all different qualities of service in one file."""
CACHED = 32 << 20
"""Limit of the bytes of a database that are kept in memory, as the check and the queries read each page."""
CHECKED_WHOLE = 1 << 30
"""Limit of the bytes of a completely checked database; in a larger one, pages used twice pass."""
_TABLES = ("messages", "topics", "schema", "metadata", "message_definitions")
_CHUNK = 0x06
_RECORD = struct.Struct("<BQ")
_OF_CHUNK = struct.Struct("<QQQ")


def opened(file: StoredFile, kind: str) -> Storage:
    """Open a file that holds messages; the caller closes it.

    `kind`: its format: ``mcap``, ``sqlite3``.

    Raises
    ------
    DinerosError
        It unpacks to more than allowed, or holds structures that recorders do not write. Errors of the
        library pass.
    """
    storage: Storage = _Mcap(file) if kind == "mcap" else Database(file)
    with _bounded_qualities(file), _guarded_databases(file):
        storage.open()
    return storage


class _Mcap(storage_mcap.McapReader):
    """A file of MCAP with a limit on the total unpacked size of its chunks."""

    def __init__(self, file: StoredFile) -> None:
        super().__init__(file)
        self._file = file
        self._is_scanned = False

    def read_index(self) -> None:
        super().read_index()
        places = {chunk.chunk_start_offset for chunk in self.chunks}
        if len(places) < len(self.chunks):
            raise RecordingError("names a chunk twice in its index", location=Location(self._file.path))
        self._check(chunk.uncompressed_size for chunk in self.chunks)

    def meta_scan(self) -> None:
        self._scan()
        super().meta_scan()

    def messages_scan(
        self, connections: Collection[Connection], start: int | None = None, stop: int | None = None
    ) -> Generator[Stored]:
        self._scan()
        return super().messages_scan(connections, start, stop)

    def _check(self, sizes: Iterator[int]) -> None:
        if sum(sizes) > most_unpacked(self._file.size):
            raise too_large(Location(self._file.path))

    def _scan(self) -> None:
        """Check the chunks of a file without an index, before one of them is unpacked."""
        if not self._is_scanned:
            self._check(self._sizes_of_chunks())
            self._is_scanned = True

    def _sizes_of_chunks(self) -> Iterator[int]:
        with self._file.open() as stream:
            at = stream.seek(self.data_start)
            while at < self.data_end:
                head = stream.read(_RECORD.size)
                if len(head) < _RECORD.size:
                    return
                kind, length = _RECORD.unpack(head)
                if kind == _CHUNK and len(times := stream.read(_OF_CHUNK.size)) == _OF_CHUNK.size:
                    yield _OF_CHUNK.unpack(times)[2]
                at = stream.seek(min(at + _RECORD.size + length, self._file.size))


class Database(storage_sqlite3.Sqlite3Reader):
    """A database, whose messages are read without a look at the table of topics for each of them."""

    def rows(self, connections: Collection[Connection]) -> Iterator[tuple[int, int, bytes]]:
        """Return the number of the connection, the time and the data of each message, in order of times."""
        assert self.dbconn is not None
        numbers = {connection.id for connection in connections}
        query = f"SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN ({_marks(numbers)})"
        rows = self.dbconn.execute(f"{query} ORDER BY timestamp", tuple(numbers))
        return cast("Iterator[tuple[int, int, bytes]]", rows)


def _marks(values: Collection[object]) -> str:
    return ", ".join("?" * len(values))


def _unpacked(data: bytes, kind: str, size: int) -> bytes:
    """Return the unpacked data; at most a MiB of it if there is more than expected."""
    made = bytearray()
    for piece in pieces(BytesIO(data), kind, len(data)):
        made += piece
        if len(made) > size:
            break
    return bytes(made)


def unpacked_messages(messages: Iterator[Stored], most: int, path: Path) -> Iterator[Stored]:
    """Yield messages, each of which was packed by zstd.

    Parameters
    ----------
    messages : iterator of Stored
        As they were stored.
    most : int
        Limit of their total unpacked bytes.
    path : Path
        Their file.

    Raises
    ------
    RecordingError
        They unpack to more.
    """
    for connection, time, packed in messages:
        data = _unpacked(packed, "zstd", most)
        most -= len(data)
        if most < 0:
            raise too_large(Location(path))
        yield connection, time, data


# The library unpacks everything before it compares the size with the one in the file.
storage_mcap.DECOMPRESSORS["zstd"] = lambda data, size: _unpacked(data, "zstd", size)
storage_mcap.DECOMPRESSORS["lz4"] = lambda data, size: _unpacked(data, "lz4", size)


_library_vfs = storage_sqlite3.make_vfs


def _vfs_of_pages(file: StoredFile) -> apsw.VFS:
    """Return the library's access to a database, but each page is read alone.

    The library reads pages from a stream, whose buffer is much larger than a page, and pages of a table and
    of its index are read in turn.
    """
    vfs: Any = _library_vfs(file)
    read, descriptor = os.pread, file.descriptor

    class Pages(vfs.VFSFile):  # type: ignore[misc]
        def xRead(self, amount: int, offset: int) -> bytes:  # noqa: N802
            return read(descriptor, amount, offset)

    vfs.VFSFile = Pages
    return cast("apsw.VFS", vfs)


_databases: Any = storage_sqlite3
_databases.make_vfs = _vfs_of_pages


@contextmanager
def _bounded_qualities(file: StoredFile) -> Iterator[None]:
    """Restrict the library to qualities of service that are plain and not too long, each text once."""
    left = QUALITIES

    @cache
    def parsed(text: str) -> list[Qos]:
        nonlocal left
        left -= len(text)
        if left < 0:
            raise RecordingError(
                f"describes qualities of service by more than {QUALITIES:,} characters",
                location=Location(file.path),
            )
        return qualities(text)

    modules: tuple[Any, ...] = (storage_mcap, storage_sqlite3)
    try:
        for module in modules:
            module.parse_qos = parsed
        yield
    finally:
        for module in modules:
            module.parse_qos = parse_qos


def qualities(said: object) -> list[Qos]:
    """Return the qualities of service described by a text or by its parsed form."""
    value = loaded(said) if isinstance(said, str) else said
    return parse_qos(value) if isinstance(value, list) else []


@contextmanager
def _guarded_databases(file: StoredFile) -> Iterator[None]:
    """Restrict databases opened within this context to plain tables without computed columns."""
    guard = _Guard(file)
    apsw.connection_hooks.append(guard)
    try:
        yield
    finally:
        apsw.connection_hooks.remove(guard)


class _Guard:
    """Checks a database before the library queries it; the first of several connections suffices."""

    def __init__(self, file: StoredFile) -> None:
        self._file = file
        self._is_checked = False

    def __call__(self, connection: apsw.Connection) -> None:
        connection.config(apsw.SQLITE_DBCONFIG_ENABLE_VIEW, 0)
        connection.config(apsw.SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0)
        connection.config(apsw.SQLITE_DBCONFIG_DEFENSIVE, 1)
        # The content of a plain table is in the file.
        connection.limit(apsw.SQLITE_LIMIT_LENGTH, min(max(self._file.size, 1 << 16), 1_000_000_000))
        connection.execute(f"PRAGMA cache_size = -{min(self._file.size, CACHED) // 1024 + 1024}")
        if self._is_checked:
            return
        found = connection.execute(
            f"SELECT name, type, rootpage, sql FROM sqlite_schema WHERE lower(name) IN ({_marks(_TABLES)})",
            _TABLES,
        )
        for name, kind, page, made in found:
            if kind != "table" or not page or str(made).split()[:2] != ["CREATE", "TABLE"]:
                raise self._error(f"{name} is not a plain table")
            columns = connection.execute("SELECT hidden FROM pragma_table_xinfo(?)", (name,))
            if any(hidden for (hidden,) in columns):
                raise self._error(f"the table {name} has columns that are computed")
        if self._file.size <= CHECKED_WHOLE:
            connection.execute("PRAGMA ignore_check_constraints = ON")
            ((said,),) = connection.execute("PRAGMA quick_check(1)").fetchall()
            if said != "ok":
                raise self._error(f"is damaged: {' '.join(str(said).split())}")
        self._is_checked = True

    def _error(self, message: str) -> RecordingError:
        return RecordingError(message, location=Location(self._file.path))
