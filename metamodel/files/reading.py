"""Reading the bytes of a file that a user named: only plain files, of bounded size."""

from __future__ import annotations

import contextlib
import gc
import os
import stat
from collections.abc import Iterator
from pathlib import Path

from dineros.metamodel.errors import Location, ModelFileError

SIZE_LIMIT = 64 * 1024 * 1024


def read_bytes(path: Path | str, limit: int = SIZE_LIMIT) -> bytes:
    """Return the content of a plain file of at most `limit` bytes.

    Raises
    ------
    ModelFileError
        There is no such file, it is a directory, a pipe or a device, it may not be read, or it is too large.
    """
    location = Location(path)
    try:
        # Without O_NONBLOCK, opening a pipe that nobody writes to waits for ever.
        descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        raise _cannot_read(location, error) from error
    try:
        status = os.fstat(descriptor)
        if stat.S_ISDIR(status.st_mode):
            raise ModelFileError("is a directory, not a model file", location=location)
        if not stat.S_ISREG(status.st_mode):
            raise ModelFileError(
                "is not a plain file", location=location, hint="copy its content into a file first"
            )
        with open(descriptor, "rb", closefd=False) as file:
            content = file.read(limit + 1)
    except OSError as error:
        raise _cannot_read(location, error) from error
    finally:
        os.close(descriptor)
    if len(content) > limit:
        raise ModelFileError(f"is larger than {limit // 1024 // 1024} MiB", location=location)
    return content


@contextlib.contextmanager
def collector_paused() -> Iterator[None]:
    """Pause the garbage collector: a growing model is no garbage, and looking costs half the time."""
    running = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if running:
            gc.enable()


def _cannot_read(location: Location, error: OSError | ValueError) -> ModelFileError:
    reason = getattr(error, "strerror", None) or str(error)
    hint = "check the name" if isinstance(error, FileNotFoundError) else None
    if isinstance(error, PermissionError):
        hint = "check who may read it"
    return ModelFileError(f"cannot be read: {reason}", location=location, hint=hint)
