"""The one way to open and read files that users or strangers named: only plain files, of bounded size.

Everything else of that kind is built on it: folders of others in `confined`, traces in `metamodel.records`.
"""

from __future__ import annotations

import contextlib
import errno
import gc
import os
import stat
from collections.abc import Iterator
from pathlib import Path

from dineros.metamodel.errors import Location, ModelFileError

SIZE_LIMIT = 64 * 1024 * 1024
LFS_POINTER = b"version https://git-lfs.github.com/spec/"
"""Start of what Git leaves in place of a large file that was not fetched."""
LFS_HINT = "`git lfs pull` gets it"
_PACKED = {
    b"\x1f\x8b": "gzip",
    b"PK\x03\x04": "zip",
    b"BZh": "bzip2",
    b"\xfd7zXZ\0": "xz",
    b"\x28\xb5\x2f\xfd": "zstd",
    b"7z\xbc\xaf\x27\x1c": "7-Zip",
}
"""Programs that pack files, by the first bytes of what they write."""
FEW_OBJECTS = 100_000
"""New objects that the garbage collector looks through in about 10 ms."""


def open_plain(
    path: Path | str,
    flags: int = os.O_RDONLY,
    mode: int = 0o666,
    *,
    follow_links: bool = True,
    folder: int | None = None,
    shown: Path | str | None = None,
) -> int:
    """Open a plain file; return its descriptor, which the caller closes.

    Parameters
    ----------
    path : Path or str
        The file.
    flags : int
        As for `os.open`.
    mode : int
        The mode of a file that is created, before the umask.
    follow_links : bool
        Whether a symbolic link at the path's end is followed.
    folder : int, optional
        Descriptor of the folder that the path begins in.
    shown : Path or str, optional
        What errors call the file.

    Raises
    ------
    FileNotFoundError
        The file does not exist.
    ModelFileError
        It is a directory, a pipe, a device or a link that is not followed, or may not be opened.
    """
    location = Location(path if shown is None else shown)
    # Without O_NONBLOCK, opening a pipe without a writer waits forever; plain files are not changed.
    # O_TRUNC stays: it empties plain files only (open(2)), and O_NOFOLLOW holds before it.
    guarded = flags | os.O_CLOEXEC | os.O_NONBLOCK | os.O_NOCTTY | (0 if follow_links else os.O_NOFOLLOW)
    try:
        beside = {} if folder is None else {"dir_fd": folder}
        descriptor = os.open(path, guarded, mode, **beside)
    except FileNotFoundError:
        raise
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        if isinstance(error, OSError) and error.errno == errno.ELOOP and not follow_links:
            raise linked(location) from error
        if isinstance(error, OSError) and error.errno == errno.ENXIO:  # a pipe for writing without a reader
            raise ModelFileError("is not a plain file", location=location) from error
        raise _cannot(flags, location, error) from error
    try:
        mode = os.fstat(descriptor).st_mode
        if stat.S_ISDIR(mode):
            raise ModelFileError("is a directory, not a file", location=location)
        if not stat.S_ISREG(mode):
            hint = "copy its content into a file first"
            raise ModelFileError("is not a plain file", location=location, hint=hint)
    except OSError as error:
        os.close(descriptor)
        raise _cannot(flags, location, error) from error
    except ModelFileError:
        os.close(descriptor)
        raise
    return descriptor


def resolved(path: Path) -> Path:
    """Return a path without links, and without an error for links that lead to themselves.

    `Path.resolve` raises a RuntimeError for these (Python 3.11 and 3.12). Here reading or writing the file
    reports them.
    """
    return Path(os.path.realpath(path))


def read_bytes(
    path: Path | str,
    limit: int = SIZE_LIMIT,
    *,
    follow_links: bool = True,
    folder: int | None = None,
    shown: Path | str | None = None,
) -> bytes:
    """Return the content of a plain file of at most `limit` bytes; parameters as for `open_plain`.

    Raises
    ------
    ModelFileError
        The file does not exist, is a directory, a pipe or a device, it may not be read, it is too large or
        packed, or a pointer of Git LFS is in its place.
    """
    location = Location(path if shown is None else shown)
    try:
        descriptor = open_plain(path, follow_links=follow_links, folder=folder, shown=shown)
        with os.fdopen(descriptor, "rb") as file:
            content = file.read(limit + 1)
    except OSError as error:
        raise _cannot(os.O_RDONLY, location, error) from error
    if len(content) > limit:
        size = f"{limit >> 20} MiB" if limit >> 20 else f"{limit} bytes"
        raise ModelFileError(f"is larger than {size}", location=location)
    _refuse_stand_in(content, location)
    return content


def read_text(path: Path | str, limit: int = SIZE_LIMIT, *, follow_links: bool = True) -> str:
    """Return the text of a plain UTF-8 file of at most `limit` bytes.

    Raises
    ------
    ModelFileError
        As `read_bytes`, or it is not UTF-8.
    """
    try:
        return read_bytes(path, limit, follow_links=follow_links).decode("utf-8")
    except UnicodeDecodeError as error:
        raise ModelFileError(f"is not UTF-8: {error.reason}", location=Location(path)) from None


def read_pieces(path: Path | str, start: int = 0, *, size: int = 1 << 18) -> Iterator[bytes]:
    """Yield the content of a plain file from a position on, piece by piece: for files of any size.

    Raises
    ------
    ModelFileError
        As `read_bytes`, whatever its size.
    """
    try:
        with os.fdopen(open_plain(path), "rb", buffering=0) as file:
            file.seek(start)
            is_first = start == 0
            while piece := file.read(size):
                if is_first:
                    _refuse_stand_in(piece, Location(path))
                    is_first = False
                yield piece
    except OSError as error:
        raise cannot_read(Location(path), error) from error


@contextlib.contextmanager
def collector_paused() -> Iterator[None]:
    """Pause the garbage collector: a growing model is not garbage, and looking costs half the time."""
    running = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if running:
            # Old from now on: the next look at young objects would go through all that was made. For few
            # objects, counting what the caller has frozen takes longer than that: it walks through all of it.
            if gc.get_count()[0] > FEW_OBJECTS and not gc.get_freeze_count():
                gc.freeze()
                gc.unfreeze()
            gc.enable()


def _refuse_stand_in(start: bytes, location: Location) -> None:
    """Refuse what is in a file's place: a pointer of Git LFS, or the file packed."""
    if start.startswith(LFS_POINTER):
        raise ModelFileError("is a pointer of Git LFS, not the file itself", location=location, hint=LFS_HINT)
    for magic, packer in _PACKED.items():
        if start.startswith(magic):
            raise ModelFileError(f"is packed by {packer}", location=location, hint="unpack it first")


def linked(location: Location) -> ModelFileError:
    """Return the error for a symbolic link where none is followed."""
    hint = "put the file or folder itself there"
    return ModelFileError("is a symbolic link, which is not followed here", location=location, hint=hint)


def cannot_read(location: Location, error: OSError | ValueError) -> ModelFileError:
    """Return the error for a file that cannot be read."""
    return _cannot(os.O_RDONLY, location, error)


def _cannot(flags: int, location: Location, error: OSError | ValueError) -> ModelFileError:
    verb = "read" if flags & os.O_ACCMODE == os.O_RDONLY else "written"
    reason = getattr(error, "strerror", None) or str(error)
    hint = "check the name" if isinstance(error, FileNotFoundError) else None
    if isinstance(error, PermissionError):
        hint = f"check who may {'read' if verb == 'read' else 'write'} it"
    return ModelFileError(f"cannot be {verb}: {reason}", location=location, hint=hint)
