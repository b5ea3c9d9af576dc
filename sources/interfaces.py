"""Interfaces that a folder defines in ``.msg``, ``.srv`` and ``.action`` files (design of ROS 2, Interfaces).

The parts of a service or an action are named as ROS 2 names their messages: ``arm_msgs/srv/Grip_Request``,
``arm_msgs/srv/Grip_Response``, ``arm_msgs/action/Move_Goal``, ``..._Result`` and ``..._Feedback``. Types
that are not in the folder are looked up in the installed packages.
"""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass, field, replace
from pathlib import PurePosixPath
from typing import NamedTuple

from dineros.metamodel.errors import DinerosError, FeatureValueError, near_matches
from dineros.metamodel.token_data import EMPTY, FieldType, Value, field_value, ros_scalar
from dineros.metamodel.token_types.installed import (
    installed_interfaces,
    installed_part,
)
from dineros.sources.folders import INTERFACES, SourceFolder
from dineros.sources.packages import Package

_PARTS = {".msg": ("",), ".srv": ("_Request", "_Response"), ".action": ("_Goal", "_Result", "_Feedback")}
"""Suffixes of the names of the parts, by the suffix of the file."""
_DEEP = 32
"""Limit of the nesting of messages."""
_MOST_LISTED = 1 << 12
"""Limit of the elements of a fixed-length list with a known default."""
_WIDE = 1 << 10
"""Limit of the fields of a message, including nested ones."""
_LINE = re.compile(
    r"(?P<type>[A-Za-z]\w*(?:/\w+){0,2}(?:<=\d{1,9})?)(?P<list>\[(?:<=)?\d{0,9}\])?\s+(?P<name>[A-Za-z]\w*)"
    r"\s*(?:(?P<constant>=)\s*)?(?P<value>.*)",
    re.ASCII,
)
_NAME = re.compile(r"(?P<package>[a-z]\w*)/(?P<kind>msg|srv|action)/(?P<name>[A-Z]\w*)", re.ASCII)


class _Written(NamedTuple):
    """A field as written in its file."""

    type: str
    list: str | None
    name: str
    default: str


@dataclass(eq=False)
class Interfaces:
    """The interfaces of a folder."""

    types: dict[str, str] = field(default_factory=dict)
    """Messages, services and actions, by name (``arm_msgs/srv/Grip``), with the paths of their files."""
    _fields: dict[str, tuple[_Written, ...]] = field(default_factory=dict)
    _constants: dict[str, dict[str, Value]] = field(default_factory=dict)
    _packages: dict[str, set[str]] = field(default_factory=dict)
    _partial: set[str] = field(default_factory=set)

    def add(self, other: Interfaces) -> None:
        """Add the interfaces of another folder; existing ones are not replaced."""
        for name, path in other.types.items():
            self.types.setdefault(name, path)
        for part, fields in other._fields.items():
            self._fields.setdefault(part, fields)
        for part, constants in other._constants.items():
            self._constants.setdefault(part, constants)
        for package, names in other._packages.items():
            self._packages.setdefault(package, set()).update(names)
        self._partial |= other._partial

    def fields(self, part: str) -> tuple[FieldType, ...] | None:
        r"""Return the fields of a message, or of a part of a service or action, nested ones as records.

        Parameters
        ----------
        part : str
            Such as ``arm_msgs/msg/Pose`` or ``arm_msgs/srv/Grip_Request``.

        Returns
        -------
        tuple of FieldType or None
            None: they are not known.

        Examples
        --------
        >>> folder = Interfaces()
        >>> folder.define("arm_msgs/srv/Grip", ".srv", "bool close\n---\nbool success\nfloat64[2] ends",
        ...     "arm_msgs/srv/Grip.srv")
        >>> [(each.name, each.kind, each.length) for each in folder.fields("arm_msgs/srv/Grip_Response")]
        [('success', 'boolean', None), ('ends', 'list', 2)]
        """
        try:
            return self._known(part, 0)
        except _UnknownError:
            return None

    def constants(self, part: str) -> dict[str, Value]:
        """Return the constants of the folder's definition of a part; none if it has no such part."""
        return self._constants.get(part, {})

    def doubt(self, type: str) -> str | None:
        """Return the reason why a type may be missing; None: it exists.

        `type`: as ROS 2 writes it: ``arm_msgs/srv/Grip``.
        """
        if type in self.types:
            return None
        package, _, rest = type.partition("/")
        kind, _, name = rest.partition("/")
        here = self._packages.get(package)
        there = installed_interfaces(package)
        if here is None and there is None:
            return f"no file in the folder defines {type}, and the package {package} is not installed"
        if (there is not None and type in there) or package in self._partial:
            return None
        known = sorted({*(here or ()), *(there or ())})
        near = near_matches(type, known)
        words = {"msg": "message", "srv": "service", "action": "action"}.get(kind, "interface")
        return f"the package {package} has no {words} {name}{f' ({near})' if near else ''}"

    def is_missing(self, type: str) -> bool:
        """Return whether the package of a type is in the folder, but does not have the type."""
        return type.partition("/")[0] in self._packages and self.doubt(type) is not None

    def define(self, type: str, ending: str, text: str, path: str) -> None:
        """Add an interface by the text of its file.

        Raises
        ------
        ValueError
            The text is not a definition; the message has the fault and its line.
        """
        parts: list[list[_Written]] = [[]]
        constants: list[dict[str, Value]] = [{}]
        for number, line in enumerate(text.splitlines(), start=1):
            bare = line.strip()
            if bare == "---":
                parts.append([])
                constants.append({})
            elif bare and not bare.startswith("#"):
                found = _LINE.fullmatch(_without_comment(bare))
                if found is None:
                    raise ValueError(f"line {number} is neither a field nor a constant")
                if found["constant"]:
                    constants[-1][found["name"]] = _literal(found["value"].strip())
                else:
                    name = _full(found["type"], type.partition("/")[0])
                    parts[-1].append(_Written(name, found["list"], found["name"], found["value"].strip()))
        ends = _PARTS[ending]
        if len(parts) != len(ends):
            raise ValueError(f"it has {len(parts)} parts, not {len(ends)}")
        self.types[type] = path
        self._packages.setdefault(type.partition("/")[0], set()).add(type)
        for end, fields, named in zip(ends, parts, constants, strict=True):
            self._fields[type + end] = tuple(fields)
            self._constants[type + end] = named

    def leave_open(self, package: str) -> None:
        """Note that a package has interfaces that could not be read."""
        self._packages.setdefault(package, set())
        self._partial.add(package)

    def _known(self, part: str, depth: int) -> tuple[FieldType, ...]:
        if depth > _DEEP:
            raise _UnknownError
        written = self._fields.get(part)
        if written is None:
            try:
                return installed_part(part)
            except DinerosError:
                raise _UnknownError from None
        found: list[FieldType] = []
        for each in written:
            found.append(self._field(each, depth))
            if _size(found) > _WIDE:
                raise _UnknownError
        return tuple(found)

    def _field(self, written: _Written, depth: int) -> FieldType:
        scalar = ros_scalar(written.type)
        inner: tuple[FieldType, ...] = ()
        if scalar is None:
            kind, inner = "record", self._known(written.type, depth + 1)
        else:
            kind = scalar.kind
        empty: Value = {part.name: part.default for part in inner} if scalar is None else EMPTY[kind]
        if written.list is None:
            made = FieldType(written.name, kind, "text", None, empty, written.type, None, inner)
        else:
            size = int(written.list.strip("[<=]") or -1)
            is_fixed = size >= 0 and "<=" not in written.list
            if is_fixed and size > _MOST_LISTED:
                raise _UnknownError
            default: Value = [empty] * size if is_fixed else []
            length, bound = size if is_fixed else None, size if "<=" in written.list else None
            made = FieldType(written.name, "list", kind, length, default, written.type, bound, inner)
        if not written.default or kind == "record":
            return made
        value = written.default if made.kind == "text" else _literal(written.default)
        if made.kind == "text":
            value = _literal(written.default) if written.default[:1] in "\"'" else written.default
        try:
            return replace(made, default=field_value(made, value))
        except FeatureValueError:
            raise _UnknownError from None


class _UnknownError(Exception):
    """The fields of a part are unknown."""


def read_interfaces(folder: SourceFolder, packages: list[Package]) -> Interfaces:
    """Return the interfaces that the files of a folder define; unread parts are listed in `unread`.

    `packages`: its packages: the name of an interface consists of its package, its kind and its file name.
    """
    found = Interfaces()
    for path in folder.files:
        if not path.endswith(INTERFACES):
            continue
        pure = PurePosixPath(path)
        inside = [each for each in packages if each.path == "." or path.startswith(f"{each.path}/")]
        above = pure.parent.parent.name if pure.parent.name in ("msg", "srv", "action") else pure.parent.name
        package = max(inside, key=lambda each: len(each.path)).name if inside else above
        name = f"{package}/{pure.suffix[1:]}/{pure.stem}"
        if pure.suffix == ".idl":
            found.leave_open(package)
            continue
        if not _NAME.fullmatch(name):
            continue  # ROS 2 ignores it
        text = folder.read(path)
        try:
            if text is not None:
                found.define(name, pure.suffix, text, path)
                continue
        except ValueError as error:
            folder.unread.append(f"{path}: it is not an interface definition: {error}")
        found.leave_open(package)
    return found


def _full(type: str, package: str) -> str:
    """Return the type of a field in the notation of ROS 2: ``std_msgs/Header`` is ``std_msgs/msg/Header``."""
    parts = type.split("/")
    if ros_scalar(type) is not None or len(parts) == 3:
        return type
    return "/".join([package, "msg", type] if len(parts) == 1 else [parts[0], "msg", parts[1]])


def _without_comment(line: str) -> str:
    """Return a line without its comment after ``#``, unless that is in a string."""
    quote = ""
    for at, each in enumerate(line):
        if quote:
            quote = "" if each == quote else quote
        elif each in "\"'":
            quote = each
        elif each == "#":
            return line[:at].strip()
    return line


def _literal(text: str) -> Value:
    if text in ("true", "false", "True", "False"):
        return text in ("true", "True")
    try:
        found = ast.literal_eval(text)
    except (ValueError, SyntaxError, MemoryError, RecursionError):
        return text
    return found if isinstance(found, (str, int, float, list)) else text


def _size(fields: list[FieldType] | tuple[FieldType, ...]) -> int:
    return sum(1 + _size(each.fields) for each in fields)
