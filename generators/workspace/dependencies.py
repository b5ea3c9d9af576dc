"""What a node's handlers need beside what is generated, declared in ``dependencies.toml``.

The file is the developers'; what stands in it goes into the package's ``package.xml`` and ``setup.py``, which
are generated.
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
    """A file of dependencies says something that packages cannot depend on."""


@dataclass(frozen=True)
class Dependencies:
    """What handlers need; the names are those of ``package.xml`` (REP 149) and setuptools.

    Attributes
    ----------
    exec_depend, test_depend : tuple of str
        ROS packages, or keys of rosdep: what handlers import, and what only their tests do.
    install_requires : tuple of str
        Distributions of the Python package index, as pip takes them (PEP 508).
    """

    exec_depend: tuple[str, ...] = ()
    test_depend: tuple[str, ...] = ()
    install_requires: tuple[str, ...] = ()

    def without(self, exec_depend: tuple[str, ...]) -> Dependencies:
        """Return those that a package does not have anyway; what it runs with, its tests have as well."""
        own = tuple(name for name in dict.fromkeys(self.exec_depend) if name not in exec_depend)
        known = {*exec_depend, *own, "python3-pytest"}
        tests = tuple(name for name in dict.fromkeys(self.test_depend) if name not in known)
        return Dependencies(own, tests, tuple(dict.fromkeys(self.install_requires)))


def read_dependencies(workspace: Path, package: str) -> Dependencies:
    """Read what the handlers of a package need; nothing where there is no such file.

    Raises
    ------
    DependenciesError
        It is not TOML, has another key, or names what cannot be depended on; with its line where it has one.
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
