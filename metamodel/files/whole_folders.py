"""New folders that are complete or not there: written next to their place, and renamed at the end."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import itertools
import os
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from dineros.metamodel.errors import DinerosError, Location, ModelFileError


@contextlib.contextmanager
def whole_folder(folder: Path) -> Iterator[Path]:
    """Yield the folder to write to. If an error is raised, the new folder and all its files are removed.

    A new folder is first a temporary one next to it, `.NAME.N.dineros-tmp`, which its writer locks until it
    is renamed. One without a lock was left by a writer that was killed; the next writer removes it. A folder
    that exists is yielded as it is.

    Parameters
    ----------
    folder : Path
        The folder; folders on the way are made.

    Raises
    ------
    ModelFileError
        It cannot be made. Errors of the caller pass; they name the folder, not the temporary one.
    """
    if os.path.lexists(folder) or folder.name in ("", ".."):
        yield folder
        return
    made = [each for each in folder.parents if not os.path.lexists(each)]
    try:
        try:
            folder.parent.mkdir(parents=True, exist_ok=True)
            temporary, lock = _create(folder)
        except OSError as error:
            raise ModelFileError(f"cannot be made: {error.strerror}", location=Location(folder)) from error
        try:
            yield temporary
            temporary.rename(folder)
        except BaseException as error:
            shutil.rmtree(temporary, ignore_errors=True)
            if isinstance(error, OSError):
                message = f"cannot be made: {error.strerror or error}"
                raise ModelFileError(message, location=Location(folder)) from error
            if isinstance(error, DinerosError):
                error.location = _renamed(error.location, temporary, folder)
            raise
        finally:
            os.close(lock)
    except BaseException:
        for each in made:
            with contextlib.suppress(OSError):  # another program may use it
                each.rmdir()
        raise


def _create(folder: Path) -> tuple[Path, int]:
    """Make and lock the temporary folder; remove one that a killed writer left."""
    stem = os.fsdecode(os.fsencode(folder.name)[:100])
    for number in itertools.count():  # another number only while another process writes the same folder
        temporary = folder.with_name(f".{stem}.{number}.dineros-tmp")
        while True:
            try:
                temporary.mkdir()
                is_new = True
            except FileExistsError:
                is_new = False
            try:
                lock = os.open(temporary, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
            except OSError:
                if is_new:
                    continue  # was taken for left behind before it was locked
                break
            is_locked = True
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError as error:
                # A file system without locks: a new folder is used, and others are left alone.
                is_locked = is_new and error.errno not in (errno.EWOULDBLOCK, errno.EACCES)
            if not is_locked:
                os.close(lock)
                break
            if is_new and os.fstat(lock).st_nlink:
                return temporary, lock
            os.close(lock)
            shutil.rmtree(temporary, ignore_errors=True)
            if os.path.lexists(temporary):
                break
    raise AssertionError("numbers do not end")


def _renamed(location: Location | None, temporary: Path, folder: Path) -> Location | None:
    """Return a location with the name that a file would have had."""
    if location is None or location.file is None or not Path(location.file).is_relative_to(temporary):
        return location
    return replace(location, file=folder / Path(location.file).relative_to(temporary))
