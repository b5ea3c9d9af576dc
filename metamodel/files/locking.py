"""Files and folders that one process at a time works on: locked, a file still known by its name."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from dineros.metamodel.files.reading import open_plain

_TRIES = 100
"""How often a file is opened that is removed before it is locked."""


def open_locked(path: Path, flags: int, mode: int = 0o666) -> int | None:
    """Open and lock a plain file (flock(2)) that its last user may remove; a symbolic link is not followed.

    A process that ends may remove its file after another one has opened it and before that one has locked it.
    The locked file then has no name: it would neither survive its process nor keep a third one out. So it is
    opened again until the locked file is the one that has the name.

    Parameters
    ----------
    path : Path
        The file.
    flags : int
        As for `os.open`.
    mode : int
        The mode of a file that is created, before the umask.

    Returns
    -------
    int or None
        The descriptor, which the caller closes; None: another process has the lock.

    Raises
    ------
    OSError
        The file cannot be opened.
    ModelFileError
        It is not a plain file.
    """
    for _ in range(_TRIES):
        file = open_plain(path, flags, mode, follow_links=False)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if os.path.samestat(os.fstat(file), path.lstat()):
                return file
        except BlockingIOError:
            os.close(file)
            return None
        except FileNotFoundError:
            pass
        except BaseException:
            os.close(file)
            raise
        os.close(file)
    return None


@contextmanager
def held(folder: Path) -> Iterator[None]:
    """Keep other processes that hold the same folder out of this block: they wait for its end (flock(2)).

    Parameters
    ----------
    folder : Path
        The folder, which is not removed meanwhile.

    Raises
    ------
    OSError
        The folder cannot be opened.
    """
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)
