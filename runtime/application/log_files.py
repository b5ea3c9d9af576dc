"""Log files of processes: what a process prints, in a file of limited size and one older file next to it."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from dineros.metamodel.errors import ModelFileError
from dineros.metamodel.files.reading import open_plain

LOG_BYTES = 16 << 20
"""Bytes of a log file after which it is rotated."""

_PIECE = 1 << 20


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
    ``NAME.1``, which replaces an older copy, and the file is emptied. What is printed just then is lost. If
    there is no room for the copy, the older lines are lost.
    """
    with contextlib.suppress(OSError, ModelFileError):
        file = open_plain(path, os.O_RDWR, follow_links=False)
        try:
            size = os.fstat(file).st_size
            if size <= limit:
                return False
            _copy(file, size - limit, size, path.with_name(f"{path.name}.1"))
            os.ftruncate(file, 0)
            return True
        finally:
            os.close(file)
    return False


def _copy(file: int, start: int, end: int, older: Path) -> None:
    """Copy a part of a file, without the line that its start cuts."""
    with contextlib.suppress(OSError, ModelFileError):
        copy = open_plain(older, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, follow_links=False)
        with os.fdopen(copy, "wb") as made:
            is_cut = start > 0
            while piece := os.pread(file, min(_PIECE, end - start), start):
                start += len(piece)
                if is_cut:
                    _, line_feed, piece = piece.partition(b"\n")
                    is_cut = not line_feed
                made.write(piece)
