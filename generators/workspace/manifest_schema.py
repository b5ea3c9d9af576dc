"""The schema of a manifest: it comes with a workspace and is untrusted, so each value is checked.

A check gets a value and its position, such as ``nodes[2].package``, and returns the value or raises
`ManifestError`. A new field of the manifest is one line of `MANIFEST`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from dineros.metamodel.errors import DinerosError, near_matches
from dineros.metamodel.files.confined import is_confined

SIZE_LIMIT = 16 << 20
"""Maximum size of a manifest, in bytes."""

TEXT_LIMIT = 4096
"""Maximum length of a text in it, in characters."""

Check = Callable[[Any, str], Any]


class ManifestError(DinerosError):
    """The manifest of a workspace cannot be read."""


def _text(value: Any, where: str) -> str:
    if not isinstance(value, str):
        raise ManifestError(f"{where} is not text")
    if len(value) > TEXT_LIMIT:
        raise ManifestError(f"{where} has more than {TEXT_LIMIT} characters")
    return value


def _matching(pattern: str, what: str) -> Check:
    compiled = re.compile(pattern)

    def check(value: Any, where: str) -> str:
        if compiled.fullmatch(_text(value, where)) is None:
            raise ManifestError(f"{where} is not a {what}: {value!r:.60}")
        return str(value)

    return check


def _truth(value: Any, where: str) -> bool:
    if not isinstance(value, bool):
        raise ManifestError(f"{where} is neither true nor false")
    return value


def _optional(check: Check) -> Check:
    return lambda value, where: None if value is None else check(value, where)


def _tuple_of(check: Check) -> Check:
    def check_all(value: Any, where: str) -> tuple[Any, ...]:
        if not isinstance(value, list):
            raise ManifestError(f"{where} is not a list")
        return tuple(check(element, f"{where}[{number}]") for number, element in enumerate(value))

    return check_all


def _map_of(check_name: Check, check: Check) -> Check:
    def check_all(value: Any, where: str) -> dict[str, Any]:
        return {
            check_name(name, f"{where}: a name"): check(element, f"{where}.{name:.60}")
            for name, element in _object(value, where).items()
        }

    return check_all


def record_of(checks: Mapping[str, Check], optional: frozenset[str] = frozenset()) -> Check:
    """Return the check of an object with these fields; fields are required unless they are `optional`."""

    def check_all(value: Any, where: str) -> dict[str, Any]:
        found = _object(value, where)
        dot = f"{where}." if where else ""
        for name in found:
            if name not in checks:
                hint = near_matches(name[:TEXT_LIMIT], checks)
                raise ManifestError(f"unknown field {dot + name:.80}", hint=hint)
        for name in checks:
            if name not in found and name not in optional:
                raise ManifestError(f"has no field {dot}{name}")
        return {name: check(found[name], f"{dot}{name}") for name, check in checks.items() if name in found}

    return check_all


def _object(value: Any, where: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ManifestError(f"{where or 'it'} is not an object")
    return value


def _path(value: Any, where: str) -> str:
    path = _text(value, where)
    if not is_confined(path) or any(part.startswith(".") for part in path.split("/")):
        raise ManifestError(f"{where} is outside of the workspace or a hidden file: {path!r:.60}")
    return path


_package = _matching(r"[a-z][a-z0-9_]*", "name of a package")
_name = _matching(r"[A-Za-z_][A-Za-z0-9_]*", "name in ROS")
_hash = _matching(r"[0-9a-f]{64}", "SHA-256")

_OPTIONS = {
    "container": _truth,
    "lifecycle": _truth,
    "license": _text,
    "maintainer": _text,
    "systemd": _truth,
    "templates": _optional(_text),
}
_NODE = {
    "node": _text,
    "package": _package,
    "executable": _name,
    "module": _package,
    "name": _name,
    "namespace": _matching(r"|/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*", "namespace in ROS"),
}
_STUB = {"inputs": _tuple_of(_text), "outputs": _tuple_of(_text)}
_DEVELOPER = {
    "node": _optional(_text),
    "written": _matching(r"|[0-9a-f]{64}", "SHA-256"),
    "stubs": _map_of(_text, record_of(_STUB)),
}

MANIFEST: dict[str, Check] = {
    "generator": _text,
    "model": _text,
    "source": _text,
    "settings": _tuple_of(_text),
    "options": record_of(_OPTIONS, optional=frozenset(_OPTIONS)),
    "interfaces": _package,
    "bringup": _package,
    "token": _map_of(_text, _text),
    "nodes": _tuple_of(record_of(_NODE)),
    "generated": _map_of(_path, _hash),
    "pending": _map_of(_path, _hash),
    "developer": _map_of(_path, record_of(_DEVELOPER)),
}
OPTIONAL = frozenset({"pending"})
