"""Files in an untrusted folder: no path leads out of it.

Paths in it are relative, with ``/``, and are walked folder by folder from an open descriptor without
following a symbolic link (`openat(2)` with ``O_NOFOLLOW``), so that neither ``..`` nor a link, nor one that
is put there meanwhile, reaches a file outside. The folder itself is what a user named, and may be a link.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import stat
from collections.abc import Iterator
from pathlib import Path

from dineros.metamodel.errors import Location, ModelFileError
from dineros.metamodel.files.atomic import replace_in, take_away_leftovers
from dineros.metamodel.files.reading import SIZE_LIMIT, linked, open_plain, read_bytes

_FOLDER = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC
_PART_BYTES, _PATH_BYTES, _DEPTH = 255, 2048, 64


def is_confined(path: str) -> bool:
    """Return whether a path is plainly one below the folder that it is relative to.

    Examples
    --------
    >>> [is_confined(path) for path in ("src/a.py", "../a", "/a", "src//a", "")]
    [True, False, False, False, False]
    """
    parts = path.split("/")
    try:
        sizes = [len(os.fsencode(part)) for part in parts]
    except UnicodeEncodeError:
        return False
    return (
        all(part not in ("", ".", "..") and "\0" not in part for part in parts)
        and max(sizes) <= _PART_BYTES
        and sum(sizes) <= _PATH_BYTES
        and len(parts) <= _DEPTH
    )


class ConfinedFolder:
    """A folder whose files are read, written and removed without ever leaving it.

    All methods raise `ModelFileError` for a path that would leave it, a symbolic link on the way, something
    that is not a plain file, and for what the system refuses.

    Parameters
    ----------
    root : Path
        The folder; it need not be there yet.
    """

    def __init__(self, root: Path) -> None:
        self.root = root

    def read(self, path: str, limit: int = SIZE_LIMIT) -> bytes | None:
        """Return the content of a file of at most `limit` bytes; None if there is none."""
        with self._parent_of(path) as (folder, name):
            if folder is None:
                return None
            if not self._is_there(folder, name):
                return None
            return read_bytes(name, limit, follow_links=False, folder=folder, shown=self.root / path)

    def write(self, path: str, content: bytes) -> None:
        """Write a file as `write_atomically` does; folders on the way are made."""
        with self._parent_of(path, make=True) as (folder, name):
            assert folder is not None
            replace_in(folder, name, content, shown=self.root / path)

    def start(self, path: str) -> int:
        """Make an empty file, or empty the one there is; return its descriptor, which the caller closes.

        For what grows while it is written, such as logs.
        """
        with self._parent_of(path, make=True) as (folder, name):
            assert folder is not None
            flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC
            return open_plain(name, flags, follow_links=False, folder=folder, shown=self.root / path)

    def remove(self, path: str) -> None:
        """Remove a file, and the folders that then hold nothing but what Python compiled."""
        with self._parent_of(path) as (folder, name):
            if folder is None:
                return
            with contextlib.suppress(FileNotFoundError):
                os.unlink(name, dir_fd=folder)
        while "/" in path:
            path = path.rpartition("/")[0]
            if not self._is_removed_where_empty(path):
                return

    def remove_tree(self, path: str) -> None:
        """Remove a folder and all that is in it; links in it go, and what they lead to stays."""
        with self._parent_of(path) as (folder, name):
            if folder is None or not self._is_there(folder, name):
                return
            if stat.S_ISLNK(os.stat(name, dir_fd=folder, follow_symlinks=False).st_mode):
                raise linked(Location(self.root / path))
            shutil.rmtree(name, dir_fd=folder)

    def files(self, path: str) -> list[str]:
        """Return the paths of all plain files below a folder, sorted, but for links and hidden folders."""
        found: list[str] = []
        for name, mode in self._entries(path):
            below = f"{path}/{name}" if path else name
            if stat.S_ISREG(mode):
                found.append(below)
            elif stat.S_ISDIR(mode) and not name.startswith("."):
                found += self.files(below)
        return sorted(found)

    def take_away_leftovers(self, path: str) -> None:
        """Remove what killed writers left in a folder, which need not be there."""
        with contextlib.suppress(ModelFileError), self._folder(path.split("/")) as folder:
            if folder is not None:
                take_away_leftovers(folder)

    def _entries(self, path: str) -> list[tuple[str, int]]:
        """Return names and modes of what is in a folder."""
        with self._folder(path.split("/") if path else []) as folder:
            if folder is None:
                return []
            with os.scandir(folder) as entries:
                return [(entry.name, entry.stat(follow_symlinks=False).st_mode) for entry in entries]

    def _is_removed_where_empty(self, path: str) -> bool:
        with self._parent_of(path) as (parent, name), self._folder(path.split("/")) as folder:
            if parent is None or folder is None:
                return False
            children = self._entries(path)
            if any(child != "__pycache__" or not stat.S_ISDIR(mode) for child, mode in children):
                return False
            for child, _ in children:
                shutil.rmtree(child, dir_fd=folder)
            os.rmdir(name, dir_fd=parent)
        return True

    @contextlib.contextmanager
    def _parent_of(self, path: str, *, make: bool = False) -> Iterator[tuple[int | None, str]]:
        """Open the folder that a path's last part is in; None if the file does not exist."""
        if not is_confined(path):
            raise ModelFileError(
                f"holds no file {path!r}: the path leads out of it", location=Location(self.root)
            )
        *parts, name = path.split("/")
        with self._folder(parts, make=make) as folder:
            try:
                yield folder, name
            except OSError as error:
                said = f"cannot be used: {error.strerror or error}"
                raise ModelFileError(said, location=Location(self.root / path)) from error

    @contextlib.contextmanager
    def _folder(self, parts: list[str], *, make: bool = False) -> Iterator[int | None]:
        walked = self.root
        folder: int | None = None
        try:
            if make:
                self.root.mkdir(parents=True, exist_ok=True)
            try:
                folder = os.open(self.root, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
                for part in parts:
                    walked = walked / part
                    inner = self._inner(folder, part, walked, make=make)
                    os.close(folder)
                    folder = inner
            except FileNotFoundError:
                if make:
                    raise
                if folder is not None:
                    os.close(folder)
                    folder = None
            yield folder
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise ModelFileError(f"cannot be used: {reason}", location=Location(walked)) from error
        finally:
            if folder is not None:
                os.close(folder)

    @staticmethod
    def _inner(folder: int, name: str, shown: Path, *, make: bool) -> int:
        if make:
            with contextlib.suppress(FileExistsError):
                os.mkdir(name, dir_fd=folder)
        try:
            return os.open(name, _FOLDER, dir_fd=folder)
        except NotADirectoryError:
            if stat.S_ISLNK(os.stat(name, dir_fd=folder, follow_symlinks=False).st_mode):
                raise linked(Location(shown)) from None
            raise

    @staticmethod
    def _is_there(folder: int, name: str) -> bool:
        try:
            os.stat(name, dir_fd=folder, follow_symlinks=False)
        except FileNotFoundError:
            return False
        return True
