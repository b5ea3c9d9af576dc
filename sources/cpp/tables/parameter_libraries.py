"""Parameters that ``generate_parameter_library`` generates code for: their defaults, from YAML files."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import PurePosixPath
from typing import Any

from dineros.sources.folders import SourceFolder
from dineros.sources.launch.yaml_text import UnreadableError, parts_of

_GENERATE = re.compile(r"\bgenerate_parameter_library\s*\(\s*([\w${}.-]+)\s+([^\s)]+\.ya?ml)")
_CASTS = {"double": float, "int": int}
"""Types whose defaults may be written as another kind of number."""


@dataclass(frozen=True)
class Library:
    """The parameters of a namespace."""

    space: str
    """The namespace of the generated classes ``Params`` and ``ParamListener``."""
    package: str
    """The folder of its package."""
    defaults: Mapping[str, Any] = field(default_factory=dict)
    """Values by name (``gains.p``); a parameter without a default has the value None."""


class ParameterLibraries:
    """The parameter libraries of a folder.

    `found`: all of them.
    """

    def __init__(self, found: Sequence[Library] = ()) -> None:
        self._found = found

    def find(self, path: str, space: str, file: str) -> Library | None:
        """Return the library of a generated class; None: it is not there, or not known which one it is.

        Parameters
        ----------
        path : str
            The class as it is written: ``robot::Params``, ``Params::Gains``.
        space : str
            The namespace of the code that names it.
        file : str
            The file of that code.
        """
        scope = [each for each in path.split("::")[:-1] if each not in ("", "Params")]
        around = scope or space.split("::")
        fitting = [each for each in self._found if _ends(around, each.space, is_whole=bool(scope))]
        if len(fitting) > 1 or (not fitting and not scope):
            near = [each for each in fitting or self._found if _is_inside(file, each.package)]
            fitting = near
        return fitting[0] if len(fitting) == 1 else None

    def __repr__(self) -> str:
        """Return all values: they are a part of the key of the cache."""
        return repr([(each.space, each.package, sorted(each.defaults.items())) for each in self._found])


def _ends(around: Sequence[str], space: str, is_whole: bool) -> bool:
    """Return whether a namespace is the one that is written, or encloses the code."""
    parts = space.split("::")
    if is_whole:
        size = min(len(parts), len(around))
        return list(around[-size:]) == parts[-size:]
    return any(list(around[at : at + len(parts)]) == parts for at in range(len(around)))


def _is_inside(file: str, package: str) -> bool:
    return package == "." or file.startswith(f"{package}/")


def read_parameter_libraries(folder: SourceFolder) -> ParameterLibraries:
    """Return the parameter libraries that the ``CMakeLists.txt`` of a folder generate."""
    found = []
    for path in folder.files:
        if PurePosixPath(path).name != "CMakeLists.txt":
            continue
        text, place = folder.read(path) or "", PurePosixPath(path).parent
        for entry in _GENERATE.finditer(text):
            file = (place / entry[2].replace("${CMAKE_CURRENT_SOURCE_DIR}/", "")).as_posix()
            if file in folder.files:
                library = _read(folder, file, place.as_posix())
                found += [] if library is None else [library]
    return ParameterLibraries(found)


def _read(folder: SourceFolder, file: str, package: str) -> Library | None:
    try:
        plain = parts_of(folder.read(file) or "").plain()
    except UnreadableError as error:
        folder.unread.append(f"{file}: {error}")
        return None
    if not isinstance(plain, dict) or len(plain) != 1:
        return None
    space, table = next(iter(plain.items()))
    return Library(space, package, _defaults(table, "")) if isinstance(table, dict) else None


def _defaults(table: Mapping[str, Any], prefix: str) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, each in table.items():
        if not isinstance(each, dict) or key.startswith("__map_"):  # as many as another parameter names
            continue
        kind = each.get("type")
        if not isinstance(kind, str):
            found |= _defaults(each, f"{prefix}{key}.")
            continue
        value = each.get("default_value")
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if kind in _CASTS and is_number:
            value = _CASTS[kind](value)
        found[f"{prefix}{key}"] = value if kind != "none" else None
    return found
