"""Log files of processes: what a process prints, in a file of limited size and one older file next to it."""

from __future__ import annotations

import contextlib
import ctypes
import errno
import os
from pathlib import Path

from dineros.metamodel.errors import ModelFileError
from dineros.metamodel.files.reading import open_plain

LOG_BYTES = 16 << 20
"""Bytes of a log file after which it is rotated."""

_PIECE = 1 << 20
_COLLAPSE_RANGE = 8
"""Mode of `fallocate` (Linux) that removes a part of a file, so that what follows it moves to its place."""

_CANNOT = (errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL, errno.EPERM)
"""Errors of a file system that cannot cut off a head; after others, such as ENOMEM, the log stays as it is
until the next look, because emptying it could lose a line."""
_LAST_BYTES = 4096
"""Bytes in which the last line of a process is searched."""

_fallocate = getattr(ctypes.CDLL(None, use_errno=True), "fallocate", None)
if _fallocate is not None:
    _fallocate.argtypes = (ctypes.c_int, ctypes.c_int, ctypes.c_long, ctypes.c_long)


def open_log(path: Path) -> int:
    """Open a log file to append to it, and return its descriptor.

    Raises
    ------
    OSError
        The system refuses.
    ModelFileError
        It is a symbolic link, or no plain file.
    """
    return open_plain(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, follow_links=False)


def rotate(path: Path, limit: int = LOG_BYTES) -> bool:
    """Let a log file begin again if it is larger than a limit; return whether it does.

    The process that writes it has the file open, so the file stays: its last `limit` bytes are copied to
    ``NAME.1``, which replaces an older copy, and cut off. On file systems that can cut off the head of a file
    (ext4, XFS), what is printed meanwhile stays in the log, which may then begin within a line. On others the
    file is emptied once all of it is copied, and a line that is printed in the instant between may be lost.
    If there is no room for the copy, the older lines are lost.
    """
    with contextlib.suppress(OSError, ModelFileError):
        file = open_plain(path, os.O_RDWR, follow_links=False)
        try:
            size = os.fstat(file).st_size
            if size <= limit:
                return False
            block = os.fstatvfs(file).f_bsize
            head = (size - 1) // block * block
            older = older_log(path)
            if head > 0 and _copy(file, max(0, head - limit), head, older) and _cut(file, head):
                return True
            _copy(file, size - limit, None, older)
            os.ftruncate(file, 0)
            return True
        finally:
            os.close(file)
    return False


def last_line(path: Path, start: int | None) -> str:
    """Return the last line that a process printed: of a traceback, what was raised.

    Parameters
    ----------
    path : Path
        The log file.
    start : int or None
        Where the process began to print; None: the log was rotated since, and the line may begin, or be, in
        the older file.
    """
    text = _end_of(path, start or 0)
    if start is None and len(text) < _LAST_BYTES:
        text = _end_of(older_log(path), 0) + text
    lines = text.decode(errors="replace").split("\n")
    return next((" ".join(line.split())[:500] for line in reversed(lines) if line.strip()), "")


def older_log(path: Path) -> Path:
    """Return the file for the older part of a log."""
    return path.with_name(f"{path.name}.1")


def _end_of(path: Path, start: int) -> bytes:
    with (
        contextlib.suppress(OSError, ModelFileError),
        os.fdopen(open_plain(path, follow_links=False), "rb") as log,
    ):
        size = log.seek(0, os.SEEK_END)
        log.seek(max(start, size - _LAST_BYTES))
        return log.read()
    return b""


def _cut(file: int, size: int) -> bool:
    """Cut off so many bytes, whole blocks, at the start of a file; return whether the file system can.

    Raises
    ------
    OSError
        It can, but not now.
    """
    if _fallocate is None:
        return False
    if _fallocate(file, _COLLAPSE_RANGE, 0, size) == 0:
        return True
    number = ctypes.get_errno()
    if number not in _CANNOT:
        raise OSError(number, os.strerror(number))
    return False


def _copy(file: int, start: int, end: int | None, older: Path) -> bool:
    """Copy a part of a file, without the line that its start cuts; return whether there is room.

    Without an `end`, what is appended meanwhile is copied, too.
    """
    with contextlib.suppress(OSError, ModelFileError):
        copy = open_plain(older, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, follow_links=False)
        with os.fdopen(copy, "wb") as made:
            is_cut = start > 0
            while piece := os.pread(file, _PIECE if end is None else min(_PIECE, end - start), start):
                start += len(piece)
                if is_cut:
                    _, line_feed, piece = piece.partition(b"\n")
                    is_cut = not line_feed
                made.write(piece)
        return True
    return False
