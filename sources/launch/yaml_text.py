"""YAML with the lines of its parts: launch files and files of parameters."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

MOST_CHARACTERS = 1 << 18
"""Of a file: parsing takes seconds for more."""
MOST_PARTS = 50_000
"""Limit of the values of a file; values that are used repeatedly count each time."""
DEEPEST = 30
"""Limit of the nesting of lists and mappings."""


class UnreadableError(ValueError):
    """A text is not supported YAML; the message has the reason."""


@dataclass(eq=False)
class Part:
    """A value and its line."""

    value: Any
    """A scalar, a list of `Part`, or a dict of str to `Part`."""
    line: int
    """Counted from 1."""

    def plain(self) -> Any:
        """Return the value without lines."""
        if isinstance(self.value, list):
            return [each.plain() for each in self.value]
        if isinstance(self.value, dict):
            return {key: each.plain() for key, each in self.value.items()}
        return self.value


def parts_of(text: str) -> Part:
    """Return the value of a text.

    Raises
    ------
    UnreadableError
        It is not YAML, too large, too deep, or the package that reads it is not installed.
    """
    if len(text) > MOST_CHARACTERS:
        raise UnreadableError(f"has more than {MOST_CHARACTERS:,} characters")
    try:
        from ruamel.yaml import YAML
        from ruamel.yaml.error import YAMLError
    except ImportError as error:
        raise UnreadableError("YAML is read only with `pip install 'dineros[sources]'`") from error
    try:
        yaml = YAML(typ="safe", pure=True)
        with warnings.catch_warnings():  # a name of a value may be given again
            warnings.simplefilter("ignore")
            root = yaml.compose(text)
        return Part(None, 1) if root is None else _Reader(yaml).part(root, 0)
    except (YAMLError, ValueError, RecursionError) as error:
        if isinstance(error, UnreadableError):
            raise
        raise UnreadableError(f"is not YAML: {str(error).splitlines()[0] if str(error) else ''}") from error


class _Reader:
    """Turns nodes of the parser into parts."""

    def __init__(self, yaml: Any) -> None:
        self._yaml = yaml
        self._count = 0

    def part(self, node: Any, depth: int) -> Part:
        self._count += 1
        if self._count > MOST_PARTS:
            raise UnreadableError(f"has more than {MOST_PARTS:,} values")
        if depth > DEEPEST:
            raise UnreadableError(f"is nested deeper than {DEEPEST} lists and mappings")
        line = node.start_mark.line + 1
        if node.id == "sequence":
            return Part([self.part(each, depth + 1) for each in node.value], line)
        if node.id == "mapping":
            found: dict[str, Part] = {}
            for key, value in node.value:
                part = self.part(value, depth + 1)
                if str(key.value) == "<<" and isinstance(part.value, dict):
                    found = {**part.value, **found}
                else:
                    found[str(key.value)] = part
            return Part(found, line)
        return Part(_scalar(node), line)


def _scalar(node: Any) -> Any:
    """Return the value of a scalar, by its tag."""
    text, tag = str(node.value), str(node.tag).rpartition(":")[2]
    try:
        if tag == "int":
            return int(text.replace("_", ""), 0) if len(text) < 40 else text
        if tag == "float":
            return float(text.replace("_", ""))
    except ValueError:
        return text
    if tag == "bool":
        return text.lower() in ("true", "yes", "on")
    return None if tag == "null" else text
