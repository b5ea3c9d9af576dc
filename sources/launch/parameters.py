"""Reads the parameters of a node from parameter files."""

from __future__ import annotations

import re
from typing import Any

from dineros.sources.launch.yaml_text import UnreadableError, parts_of


def parameters_for(text: str, node: str) -> dict[str, Any]:
    r"""Return the parameters that a file gives to a node, by its full name; later entries come last.

    Raises
    ------
    UnreadableError
        The text is not YAML.

    Examples
    --------
    >>> parameters_for("/**:\n  ros__parameters: {rate: 3}\narm:\n  ros__parameters: {a: {b: 1}}", "/arm")
    {'rate': 3, 'a.b': 1}
    """
    found: dict[str, Any] = {}
    plain = parts_of(text).plain()
    if isinstance(plain, dict):
        _collect(plain, "", node, found)
    return found


def _collect(table: dict[str, Any], path: str, node: str, found: dict[str, Any]) -> None:
    for key, value in table.items():
        if not isinstance(value, dict):
            continue
        if key == "ros__parameters":
            if _fits(path, node):
                found |= _flat(value, "")
        else:
            _collect(value, f"{path}/{key.strip('/')}" if key.strip("/") else path, node, found)


def _fits(pattern: str, node: str) -> bool:
    """Return whether a key of the file matches a node: ``/**`` matches any namespaces, ``*`` one name."""
    parts = [
        ".*" if each == "**" else "[^/]*".join(map(re.escape, each.split("*"))) for each in pattern.split("/")
    ]
    text = "/".join(parts).replace("/.*", "(?:/[^/]+)*")
    return re.fullmatch(text or "/", node) is not None


def _flat(table: dict[str, Any], prefix: str) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in table.items():
        found |= _flat(value, f"{prefix}{key}.") if isinstance(value, dict) else {f"{prefix}{key}": value}
    return found


__all__ = ["UnreadableError", "parameters_for"]
