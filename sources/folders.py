"""The files of a folder of source code: limited in size and number, without links out of the folder."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from dineros.metamodel.errors import DinerosError, Location, ModelFileError, counted
from dineros.metamodel.files.reading import read_bytes, read_pieces, resolved

MOST_FILES = 20_000
"""Limit of the files of a folder, of the kinds that are read."""
MOST_BYTES = 2 << 20
"""Limit of the bytes of a file; source code written by hand is far smaller."""

_LEFT_OUT = {"build", "install", "log", "node_modules", "__pycache__", "venv", "site-packages"}
CPP = (".cpp", ".cc", ".cxx", ".hpp", ".hh", ".hxx", ".h", ".ipp", ".tpp")
"""Suffixes of C++ files."""

INTERFACES = (".msg", ".srv", ".action", ".idl")
"""Suffixes of files that define interfaces."""

_KINDS = (".py", ".xml", ".yaml", ".yml", ".cfg", *CPP, *INTERFACES)
_NAMES = {"CMakeLists.txt"}
_TESTS = {"test", "tests", "benchmark", "mock"}
_TEST_FILE = re.compile(r"(?:^|/)(?:test_[^/]*|[^/]*_test|conftest)\.\w+$")
_OF_ROS1 = re.compile(r"^\s*(?:import rospy|from rospy|#\s*include\s*[<\"]ros/ros\.h[>\"])", re.MULTILINE)


@dataclass(eq=False)
class SourceFolder:
    """A folder of source code, and the relevant files in it."""

    root: Path
    """The folder; paths are relative to it."""
    files: list[str] = field(default_factory=list)
    """Paths of files, in order; scripts in Python with another suffix are in `scripts`."""
    scripts: list[str] = field(default_factory=list)
    """Paths of files in Python, with and without ``.py``."""
    unread: list[str] = field(default_factory=list)
    """Files that were ignored, a line each."""

    def read(self, path: str) -> str | None:
        """Return the text of a file; None, and a line in `unread`, if it cannot be read."""
        content = self.content(path)
        try:
            return None if content is None else content.decode()
        except UnicodeDecodeError:
            self.unread.append(f"{path}: it is not text in UTF-8")
        return None

    def content(self, path: str) -> bytes | None:
        """Return the content of a file; None, and a line in `unread`, if it cannot be read."""
        try:
            return read_bytes(self.root / path, MOST_BYTES)
        except ModelFileError as error:
            self.unread.append(f"{path}: {error.message}")
        return None


def open_folder(root: Path) -> SourceFolder:
    """Return the files of a folder.

    Raises
    ------
    DinerosError
        The folder does not exist, or it has too many files.
    """
    if not root.is_dir():
        raise DinerosError("this folder of source code does not exist", location=Location(root))
    found = SourceFolder(root)
    for path in _paths(root, found.unread):
        found.files.append(path)
        if path.endswith(".py") or (not Path(path).suffix and _is_python(root / path)):
            found.scripts.append(path)
        if len(found.files) > MOST_FILES:
            hint = "name the folders of the packages"
            raise DinerosError(
                f"the folder has more than {counted(MOST_FILES, 'file')}", location=Location(root), hint=hint
            )
    return found


def is_test(path: str) -> bool:
    """Return whether a file belongs to tests, by its name or an enclosing folder."""
    return bool(_TESTS & set(PurePosixPath(path).parts[:-1])) or bool(_TEST_FILE.search(path))


def file_of_ros1(root: Path) -> str | None:
    """Return the first file of a folder that uses rospy or roscpp; None if none does."""
    folder = open_folder(root)
    for path in folder.files:
        if path in folder.scripts or path.endswith(CPP):
            text = folder.read(path)
            if text is not None and _OF_ROS1.search(text):
                return path
    return None


def _paths(root: Path, unread: list[str]) -> Iterator[str]:
    """Yield the paths of files that may be relevant, in order; links out of the folder are ignored."""
    real = resolved(root)
    for folder, inner, names in os.walk(root):
        here = Path(folder)
        if "COLCON_IGNORE" in names or "AMENT_IGNORE" in names:
            inner.clear()
            continue
        inner[:] = sorted(
            name
            for name in inner
            if name not in _LEFT_OUT
            and not name.startswith(".")
            and not ((here / name).is_symlink())
            and not (here / name / "pyvenv.cfg").exists()
        )
        for name in sorted(names):
            if not (name.endswith(_KINDS) or name in _NAMES or "." not in name):
                continue
            path = here / name
            shown = path.relative_to(root).as_posix()
            if path.is_symlink() and not resolved(path).is_relative_to(real):
                unread.append(f"{shown}: it is a symbolic link to a path outside of the folder")
            elif path.is_file():
                yield shown


def _is_python(path: Path) -> bool:
    """Return whether a file without a suffix is a script in Python, by its first line."""
    try:
        first = next(read_pieces(path, size=200), b"").partition(b"\n")[0]
    except DinerosError:
        return False
    return first.startswith(b"#!") and b"python" in first
