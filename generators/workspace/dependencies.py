"""Additional dependencies of a node's handlers, declared in ``dependencies.toml``.

The file belongs to the developers; its entries are copied to the generated ``package.xml`` and ``setup.py``.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, fields
from pathlib import Path

from dineros.metamodel.errors import DinerosError, Location, near_matches
from dineros.metamodel.files.confined import ConfinedFolder
from dineros.metamodel.files.toml import decode_toml

FILE = "dependencies.toml"
SIZE_LIMIT = 1024 * 1024

# Names of ROS packages (REP 144) and keys of rosdep, such as libstdc++-dev.
_KEY = re.compile(r"[A-Za-z0-9][A-Za-z0-9+._-]*")


class DependenciesError(DinerosError):
    """A dependencies file has an invalid entry."""


@dataclass(frozen=True)
class Dependencies:
    """Dependencies of handlers; the names are those of ``package.xml`` (REP 149) and setuptools."""

    exec_depend: tuple[str, ...] = ()
    test_depend: tuple[str, ...] = ()
    """`exec_depend`, `test_depend`: ROS packages or keys of rosdep: imports of the handlers, and imports only
    of their tests.
    """
    install_requires: tuple[str, ...] = ()
    """Distributions of the Python package index, in the notation of pip (PEP 508)."""

    def without(self, exec_depend: tuple[str, ...]) -> Dependencies:
        """Return the dependencies that a package does not have anyway; tests have its runtime ones, too."""
        own = tuple(name for name in dict.fromkeys(self.exec_depend) if name not in exec_depend)
        known = {*exec_depend, *own, "python3-pytest"}
        tests = tuple(name for name in dict.fromkeys(self.test_depend) if name not in known)
        return Dependencies(own, tests, tuple(dict.fromkeys(self.install_requires)))


def read_dependencies(workspace: Path, package: str) -> Dependencies:
    """Read the dependencies of a package's handlers; empty if there is no such file.

    Raises
    ------
    DependenciesError
        It is not TOML, has an unknown key, or an invalid name; with the line, if known.
    ModelFileError
        It cannot be read.
    """
    relative = f"src/{package}/{FILE}"
    path = workspace / relative
    content = ConfinedFolder(workspace).read(relative, SIZE_LIMIT)
    if content is None:
        return Dependencies()
    try:
        values = decode_toml(content, path)
    except DinerosError as error:
        raise DependenciesError(error.message, location=error.location, hint=error.hint) from error
    known = [field.name for field in fields(Dependencies)]
    for key, names in values.items():
        if key not in known:
            hint = near_matches(key, known) or f"there are {', '.join(known)}"
            raise DependenciesError(f"has an unknown key {key!r:.100}", location=Location(path), hint=hint)
        if not isinstance(names, list):
            raise DependenciesError(f"{key} is not a list", location=Location(path), hint=f'{key} = ["NAME"]')
        for name in names:
            problem = _problem(key, name, package)
            if problem:
                raise DependenciesError(f"{key} has {name!r:.100}, {problem}", location=Location(path))
    return Dependencies(**{key: tuple(names) for key, names in values.items()})


def _problem(key: str, name: object, package: str) -> str | None:
    if not isinstance(name, str) or not name.strip() or not name.isprintable():
        return "which is not a name"
    if key != "install_requires" and not _KEY.fullmatch(name):
        return "which is not a name of a ROS package or key of rosdep"
    return "the package itself" if name == package else None
