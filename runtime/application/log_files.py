"""Log files of processes: the output of a process, in a file of limited size and one older file."""

from __future__ import annotations

import contextlib
import ctypes
import errno
import os
from pathlib import Path

from dineros.metamodel.errors import ModelFileError
from dineros.metamodel.files.reading import open_plain

LOG_BYTES = 16 << 20
"""Size in bytes above which a log file is rotated."""

_PIECE = 1 << 20
_COLLAPSE_RANGE = 8
"""Mode of `fallocate` (Linux) that removes a part of a file and shifts the rest forward."""

_CANNOT = (errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL, errno.EPERM)
"""Errors of a file system that cannot remove the start of a file; after other errors, such as ENOMEM, the log
is kept until the next check, because emptying it could lose a line."""
_LAST_BYTES = 4096
"""Bytes at the end of a log in which the last line of a process is searched."""

_fallocate = getattr(ctypes.CDLL(None, use_errno=True), "fallocate", None)
if _fallocate is not None:
    _fallocate.argtypes = (ctypes.c_int, ctypes.c_int, ctypes.c_long, ctypes.c_long)


def open_log(path: Path) -> int:
    """Open a log file to append to it, and return its descriptor.

    Raises
    ------
    OSError
        The system refuses to open it.
    ModelFileError
        It is a symbolic link, or not a regular file.
    """
    return open_plain(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, follow_links=False)


def rotate(path: Path, limit: int = LOG_BYTES) -> bool:
    """Rotate a log file if it is larger than a limit; return whether it was rotated.

    The process that writes the log has the file open, so the file stays: its last `limit` bytes are copied to
    ``NAME.1``, which replaces an older copy, and are then removed. On file systems that can remove the start
    of a file (ext4, XFS), output during the copy stays in the log, which may then begin within a line. On
    other file systems the file is emptied after the copy; a line printed in the instant between may be lost.
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
    """Return the last line that a process printed: after a traceback, the exception.

    Parameters
    ----------
    path : Path
        The log file.
    start : int or None
        Size of the log when the process started; None: the log was rotated since, and the line may be or
        begin in the older file.
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
    """Remove this number of bytes, whole blocks, at the start of a file; return whether that is possible.

    Raises
    ------
    OSError
        The file system supports it, but the call failed.
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
    """Copy a part of a file, without the incomplete first line; return whether there was room.

    Without an `end`, data that is appended meanwhile is copied, too.
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
