"""Writing a file so that a crash at any moment leaves the old one or the new one, never a half.

The new content is first written to a temporary file next to the target, `.NAME.N.dineros-tmp`, which its
writer locks (flock(2)) until it is renamed. A file without a lock was left by a writer that was killed; the
next writer of the same target removes it.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import itertools
import os
import re
import stat
from pathlib import Path

from dineros.metamodel.errors import Location, ModelFileError
from dineros.metamodel.files.reading import linked

_TEMPORARY = re.compile(r"\..+\.[0-9]+\.dineros-tmp", re.DOTALL)


def write_atomically(
    path: Path | str, content: bytes, *, follow_links: bool = True, synchronise: bool = True
) -> None:
    """Write a file by renaming a complete, synchronised temporary file of the same folder over it.

    An existing file keeps its access mode.

    Parameters
    ----------
    path : Path or str
        The file.
    content : bytes
        What it will hold.
    follow_links : bool
        Whether a symbolic link stays one and its target is written; else it is refused.
    synchronise : bool
        Whether to wait for the disk, so that the file survives a power cut too.

    Raises
    ------
    ModelFileError
        The file cannot be written; nothing changed and nothing is left behind.
    """
    try:
        target = Path(os.path.realpath(path) if follow_links else path)
        folder = os.open(target.parent, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    except (OSError, ValueError) as error:
        raise _cannot_write(path, error) from error
    try:
        replace_in(folder, target.name, content, shown=path, synchronise=synchronise)
    finally:
        os.close(folder)


def replace_in(
    folder: int, name: str, content: bytes, *, shown: Path | str, synchronise: bool = True
) -> None:
    """Do as `write_atomically`, in an open folder; a symbolic link is refused.

    Parameters
    ----------
    folder : int
        Descriptor of the folder.
    name : str
        Name of the file in it.
    content : bytes
        What it will hold.
    shown : Path or str
        What errors call the file.
    synchronise : bool
        Whether to wait for the disk.

    Raises
    ------
    ModelFileError
        The file cannot be written; nothing changed and nothing is left behind.
    """
    try:
        mode = _mode_for(folder, name, shown)
        temporary, descriptor = _create(folder, name)
    except (OSError, ValueError) as error:
        raise _cannot_write(shown, error) from error
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
            file.flush()
            os.fchmod(file.fileno(), mode)
            if synchronise:
                os.fsync(file.fileno())
            # Still open, so still locked: no other writer removes it.
            os.replace(temporary, name, src_dir_fd=folder, dst_dir_fd=folder)
    except BaseException as error:  # an interrupted run leaves nothing behind either
        with contextlib.suppress(OSError):
            os.unlink(temporary, dir_fd=folder)
        if isinstance(error, OSError):
            raise _cannot_write(shown, error) from error
        raise
    if synchronise:
        with contextlib.suppress(OSError):  # where the file system can, the renaming survives a power cut
            os.fsync(folder)


def take_away_leftovers(folder: int) -> None:
    """Remove the temporary files in an open folder, given by its descriptor, whose writers were killed."""
    with contextlib.suppress(OSError), os.scandir(folder) as entries:
        for name in [entry.name for entry in entries]:
            if _TEMPORARY.fullmatch(name):
                _is_taken_away(folder, name)


def _create(folder: int, name: str) -> tuple[str, int]:
    """Make and lock a temporary file; take away what a killed writer of the same file left."""
    stem = os.fsdecode(os.fsencode(name)[:100])
    for number in itertools.count():  # another number only while another process writes the same file
        temporary = f".{stem}.{number}.dineros-tmp"
        while True:
            try:
                flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC  # O_EXCL follows no link
                descriptor = os.open(temporary, flags, 0o600, dir_fd=folder)
            except FileExistsError:
                if _is_taken_away(folder, temporary):
                    continue
                break
            with contextlib.suppress(OSError):  # a file system without locks: nothing is ever taken away
                fcntl.flock(descriptor, fcntl.LOCK_EX)
            if os.fstat(descriptor).st_nlink:
                return temporary, descriptor
            os.close(descriptor)  # was taken for left behind before it was locked
    raise AssertionError("numbers do not end")


def _is_taken_away(folder: int, temporary: str) -> bool:
    """Remove a temporary file that no living process writes; return whether it was removed."""
    try:
        found = os.stat(temporary, dir_fd=folder, follow_symlinks=False)
        if not stat.S_ISREG(found.st_mode):
            return False
        flags = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
        descriptor = os.open(temporary, flags, dir_fd=folder)
    except FileNotFoundError:
        return True
    except OSError:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        now = os.stat(temporary, dir_fd=folder, follow_symlinks=False)
        if os.path.samestat(now, os.fstat(descriptor)):
            os.unlink(temporary, dir_fd=folder)
    except FileNotFoundError:
        return True
    except OSError:
        return False
    finally:
        os.close(descriptor)
    return True


def _mode_for(folder: int, name: str, shown: Path | str) -> int:
    """Return the mode of the existing file, or what a newly made file would get."""
    try:
        mode = os.stat(name, dir_fd=folder, follow_symlinks=False).st_mode
    except FileNotFoundError:
        mask = os.umask(0)
        os.umask(mask)
        return 0o666 & ~mask
    if stat.S_ISLNK(mode):
        raise linked(Location(shown))
    if not stat.S_ISREG(mode):
        kind = "a directory" if stat.S_ISDIR(mode) else "not a plain file"
        raise OSError(errno.EINVAL, f"it is {kind}")
    return stat.S_IMODE(mode)


def _cannot_write(path: Path | str, error: OSError | ValueError) -> ModelFileError:
    reason = getattr(error, "strerror", None) or str(error)
    hint = "create the folder first" if isinstance(error, FileNotFoundError) else None
    return ModelFileError(f"cannot be written: {reason}", location=Location(path), hint=hint)
