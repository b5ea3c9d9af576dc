"""Packages of ROS 2: names, and the functions and scripts that they install as programs."""

from __future__ import annotations

import ast
import configparser
import re
from dataclasses import dataclass, field
from pathlib import PurePosixPath

from dineros.metamodel.errors import ModelFileError
from dineros.metamodel.files.xml import parse_bytes
from dineros.sources.cmake import Built, Component, read_cmake
from dineros.sources.folders import SourceFolder


@dataclass(eq=False)
class Package:
    """A package."""

    name: str
    """Of ``package.xml``."""
    path: str
    """Its folder, relative to the folder that was read; ``.`` for that folder itself."""
    programs: dict[str, str] = field(default_factory=dict)
    """Executables: ``module:function`` of an entry point, or the path of a script."""
    sources: dict[str, list[str]] = field(default_factory=dict)
    """Executables in C++, with the paths of their sources."""
    components: list[Component] = field(default_factory=list)
    """Components in C++."""


def packages_of(folder: SourceFolder) -> list[Package]:
    """Return the packages of a folder, in the order of their paths."""
    found = []
    for path in folder.files:
        if PurePosixPath(path).name != "package.xml":
            continue
        place = PurePosixPath(path).parent.as_posix()
        package = Package(_name(folder, path) or PurePosixPath(place).name, place)
        for name, read in (("setup.py", _of_setup), ("setup.cfg", _of_settings)):
            text = _text_of(folder, _inside(name, place))
            package.programs |= read(text) if text else {}
        text = _text_of(folder, _inside("CMakeLists.txt", place))
        if text:
            built = read_cmake(text)
            package.programs |= _of_cmake(built, place)
            package.components = built.components
            package.sources = {
                name: [_inside(path, place) for path in paths] for name, paths in built.sources.items()
            }
        found.append(package)
    return found


def _text_of(folder: SourceFolder, path: str) -> str | None:
    return folder.read(path) if path in folder.files else None


def _name(folder: SourceFolder, path: str) -> str | None:
    text = folder.read(path)
    if text is None:
        return None
    try:
        name = parse_bytes(text.encode(), folder.root / path).getroot().findtext("name")
    except ModelFileError as error:
        folder.unread.append(f"{path}: {error.message}")
        return None
    return name.strip() if name else None


_ENTRY = re.compile(r"\s*([\w.-]+)\s*=\s*([\w.]+):([\w.]+)\s*")


def _of_setup(text: str) -> dict[str, str]:
    """Return the entry points of a ``setup.py``: strings of this form in a list."""
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return {}
    found = {}
    for node in ast.walk(tree):
        if isinstance(node, (ast.List, ast.Tuple)):
            for each in node.elts:
                entry = _ENTRY.fullmatch(each.value) if _is_text(each) else None  # type: ignore[attr-defined]
                if entry:
                    found[entry[1]] = f"{entry[2]}:{entry[3]}"
    return found


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def _of_settings(text: str) -> dict[str, str]:
    parser = configparser.ConfigParser(interpolation=None, strict=False)
    try:
        parser.read_string(text)
        lines = parser.get("options.entry_points", "console_scripts", fallback="").splitlines()
    except configparser.Error:
        return {}
    entries = [_ENTRY.fullmatch(line) for line in lines]
    return {entry[1]: f"{entry[2]}:{entry[3]}" for entry in entries if entry}


def _of_cmake(built: Built, place: str) -> dict[str, str]:
    """Return the scripts that are installed as programs."""
    return {PurePosixPath(path).name: _inside(path, place) for path in built.scripts}


def _inside(path: str, place: str) -> str:
    return path if place == "." else f"{place}/{path}"
