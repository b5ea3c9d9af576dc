"""Writing a file so that a crash at any moment leaves the old one or the new one, never a half."""

from __future__ import annotations

import contextlib
import os
import stat
import tempfile
from pathlib import Path

from dineros.metamodel.errors import Location, ModelFileError


def write_atomically(path: Path | str, content: bytes) -> None:
    """Write a file by renaming a complete, synchronised temporary file of the same folder over it.

    An existing file keeps its access mode; a symbolic link stays one and its target is written.

    Raises
    ------
    ModelFileError
        The file cannot be written; nothing changed and nothing is left behind.
    """
    try:
        target = Path(os.path.realpath(path))
        mode = _mode_for(target)
        descriptor, name = tempfile.mkstemp(prefix=f".{target.name[:100]}.", suffix=".tmp", dir=target.parent)
    except (OSError, ValueError) as error:
        raise _cannot_write(path, error) from error
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
            file.flush()
            os.fchmod(file.fileno(), mode)
            os.fsync(file.fileno())
        os.replace(name, target)  # noqa: PTH105 - the pair to mkstemp and fsync
    except BaseException as error:  # an interrupted run leaves nothing behind either
        with contextlib.suppress(OSError):
            os.unlink(name)  # noqa: PTH108
        if isinstance(error, OSError):
            raise _cannot_write(path, error) from error
        raise
    _synchronise_folder(target.parent)


def _mode_for(target: Path) -> int:
    """Return the mode of the existing file, or what a newly made file would get."""
    try:
        status = target.stat()
    except FileNotFoundError:
        mask = os.umask(0)
        os.umask(mask)
        return 0o666 & ~mask
    if not stat.S_ISREG(status.st_mode):
        kind = "a directory" if stat.S_ISDIR(status.st_mode) else "not a plain file"
        raise OSError(0, f"it is {kind}")
    return stat.S_IMODE(status.st_mode)


def _synchronise_folder(folder: Path) -> None:
    """Make the renaming itself survive a power cut, where the file system can."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _cannot_write(path: Path | str, error: OSError | ValueError) -> ModelFileError:
    reason = getattr(error, "strerror", None) or str(error)
    hint = "make the folder first" if isinstance(error, FileNotFoundError) else None
    return ModelFileError(f"cannot be written: {reason}", location=Location(path), hint=hint)
