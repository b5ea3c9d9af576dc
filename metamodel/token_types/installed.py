"""Messages of installed ROS interfaces, read from their type descriptions (REP 2011); no code of them runs.

Packages put ``share/PACKAGE/msg/NAME.json`` next to ``NAME.msg`` into folders of ``AMENT_PREFIX_PATH``;
the wheels of ROS 2 put them into the folder of this Python.
"""

from __future__ import annotations

import ast
import os
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from dineros.metamodel.errors import DinerosError, FeatureValueError, ModelFileError, near_matches
from dineros.metamodel.files.reading import read_text
from dineros.metamodel.json_text import decode_json
from dineros.metamodel.token_data import EMPTY, FieldType, Value, field_value
from dineros.metamodel.token_types.constants import Constant, with_named_values

SIZE_LIMIT = 16 * 1024 * 1024
DEPTH_LIMIT = 32

MESSAGE = re.compile(r"[a-z][a-z0-9_]{0,99}/msg/[A-Z][A-Za-z0-9]{0,99}")
"""Names of messages, as ``std_msgs/msg/String``."""

# Numbers of type_description_interfaces/msg/FieldType; long doubles and wide characters are in no .msg file.
_SCALARS = {2: "int8", 3: "uint8", 4: "int16", 5: "uint16", 6: "int32", 7: "uint32", 8: "int64", 9: "uint64"}
_SCALARS |= {10: "float32", 11: "float64", 13: "char", 15: "bool", 16: "byte"}
_SCALARS |= {17: "string", 18: "wstring", 21: "string", 22: "wstring"}
_PART = re.compile(
    r"(([a-z][a-z0-9_]{0,99})/(?:srv|action)/[A-Z][A-Za-z0-9]{0,99})_(?:Request|Response|Goal|Result|Feedback)"
)
_PACKAGE = re.compile(r"[a-z][a-z0-9_]*", re.ASCII)
_NESTED = 1
_FORMS = ((144, "sequence"), (96, "bounded"), (48, "array"), (0, "single"))
_CONSTANT = re.compile(r"\s*([a-z]\w*(?:<=\d+)?)\s+([A-Z][A-Z0-9_]*)\s*=\s*(.*?)\s*", re.ASCII)
# What is in messages without fields, as C has no empty structures.
_FILLER = "structure_needs_at_least_one_member"


class UnknownInterfaceError(DinerosError):
    """A ROS message is not installed, or has fields that tokens cannot have.

    Attributes
    ----------
    is_missing : bool
        Whether only its package is not installed, so that its fields are unknown here.
    """

    is_missing = False


def installed_fields(name: str) -> tuple[FieldType, ...]:
    """Return the fields of an installed message, nested ones as records.

    Its constants are names of values: see `with_named_values`.

    Parameters
    ----------
    name : str
        Such as ``geometry_msgs/msg/PoseStamped``.

    Raises
    ------
    UnknownInterfaceError
        It is not installed, cannot be read, or has fields that tokens cannot have.
    """
    return _fields_of(name, os.environ.get("AMENT_PREFIX_PATH", ""))


COMMON = (
    *("actionlib_msgs", "geometry_msgs", "nav_msgs", "sensor_msgs", "shape_msgs"),
    *("stereo_msgs", "trajectory_msgs", "visualization_msgs"),
)
"""Packages that come with the extra ``interfaces``."""


def how_to_install(package: str) -> str:
    """Return how a package of ROS interfaces is installed, for hints.

    Examples
    --------
    >>> how_to_install("sensor_msgs")
    "pip install 'dineros[interfaces]', or source the workspace that has it"
    >>> how_to_install("nav2_msgs")
    'install the package nav2_msgs, or source the workspace that has it'
    """
    what = "pip install 'dineros[interfaces]'" if package in COMMON else f"install the package {package}"
    return f"{what}, or source the workspace that has it"


def installed_messages(package: str) -> list[str]:
    """Return the messages of an installed package, in order of their names.

    Raises
    ------
    UnknownInterfaceError
        It is not installed.
    """
    if not _PACKAGE.fullmatch(package):
        raise UnknownInterfaceError(f"{package!r:.100} names no ROS package", hint="write it like std_msgs")
    folders = _folders(package)
    if not folders:
        raise UnknownInterfaceError(f"the package {package} is not installed", hint=how_to_install(package))
    names = {file.stem for folder in folders for file in (folder / "msg").glob("*.json")}
    return [f"{package}/msg/{name}" for name in sorted(names)]


def installed_interfaces(package: str) -> frozenset[str] | None:
    """Return the messages, services and actions of an installed package; None: it is not installed.

    Examples
    --------
    >>> "std_srvs/srv/Trigger" in installed_interfaces("std_srvs")
    True
    """
    return _interfaces_of(package, os.environ.get("AMENT_PREFIX_PATH", ""))


@lru_cache(maxsize=256)
def _interfaces_of(package: str, prefixes: str) -> frozenset[str] | None:
    """Return the interfaces of a package; `prefixes` is only used in messages about where it was searched."""
    if not _PACKAGE.fullmatch(package):
        return None
    folders = _folders(package)
    names = {
        f"{package}/{kind}/{file.stem}"
        for folder in folders
        for kind in ("msg", "srv", "action")
        for file in (folder / kind).glob("*.json")
    }
    return frozenset(names) or None


def installed_part(name: str) -> tuple[FieldType, ...]:
    """Return the fields of an installed message, or of a part of a service or action.

    Parameters
    ----------
    name : str
        Such as ``std_msgs/msg/String``, ``std_srvs/srv/Trigger_Response``, ``nav2_msgs/action/Wait_Goal``.

    Raises
    ------
    UnknownInterfaceError
        It is not installed, cannot be read, or has fields that tokens cannot have.
    """
    return _part_of(name, os.environ.get("AMENT_PREFIX_PATH", ""))


@lru_cache(maxsize=256)
def _part_of(name: str, prefixes: str) -> tuple[FieldType, ...]:
    """Return the fields of a part; `prefixes` is only used in messages about where it was searched."""
    match = _PART.fullmatch(name)
    if match is None:
        return _fields_of(name, prefixes)
    found = _interfaces_of(match[2], prefixes)
    if found is None or match[1] not in found:
        raise UnknownInterfaceError(
            f"the ROS interface {match[1]} is not installed", hint=how_to_install(match[2])
        )
    files = [prefix / "share" / f"{match[1]}.json" for prefix in _prefixes()]
    return _read_fields(name, _text(match[1], next(each for each in files if each.is_file())), is_part=True)


def installed_constants(name: str) -> dict[str, Value]:
    """Return the constants of an installed message, in the order of its definition.

    Raises
    ------
    UnknownInterfaceError
        It is not installed, or cannot be read.
    """
    return {constant.name: constant.value for constant in _constants(name)}


def _constants(name: str) -> Iterator[Constant]:
    for line in _text(name, _file(name, ".msg")).splitlines():
        is_text = line.split()[:1] in (["string"], ["wstring"])  # it may have the sign for comments
        match = _CONSTANT.fullmatch(line if is_text else line.partition("#")[0])
        if match is not None:
            yield Constant(match[1], match[2], _literal(match[3]))


def _constants_if_there(name: str) -> Iterator[Constant]:
    try:
        yield from _constants(name)
    except UnknownInterfaceError:
        return  # a package may bring the description alone


@lru_cache(maxsize=256)
def _fields_of(name: str, prefixes: str) -> tuple[FieldType, ...]:
    """Return the fields of a message; `prefixes` is only used in messages about where it was searched."""
    fields = _read_fields(name, _text(name, _file(name, ".json")))
    return with_named_values(fields, _constants_if_there(name))


def _read_fields(name: str, text: str, *, is_part: bool = False) -> tuple[FieldType, ...]:
    try:
        message = decode_json(text)["type_description_msg"]
        referenced = {each["type_name"]: each for each in message["referenced_type_descriptions"]}
        return _described(referenced[name] if is_part else message["type_description"], referenced, 0)
    except (KeyError, TypeError, ValueError, RecursionError) as error:
        raise UnknownInterfaceError(f"the type description of {name} cannot be read: {error}") from error


def _file(name: str, suffix: str) -> Path:
    if not MESSAGE.fullmatch(name):
        raise UnknownInterfaceError(
            f"{name!r:.100} names no ROS message", hint="write it like std_msgs/msg/String"
        )
    package, _, message = name.split("/")
    folders = _folders(package)
    for folder in folders:
        file = folder / "msg" / f"{message}{suffix}"
        if file.is_file():
            return file
    if not folders:
        missing = UnknownInterfaceError(
            f"the ROS interface {name} is not installed",
            hint=how_to_install(package),
        )
        missing.is_missing = True
        raise missing
    known = {file.stem for folder in folders for file in (folder / "msg").glob("*.json")}
    raise UnknownInterfaceError(
        f"the package {package} has no message {message}",
        hint=near_matches(message, sorted(known)) or f"its messages are in {folders[0] / 'msg'}",
    )


def _folders(package: str) -> list[Path]:
    return [folder for folder in (prefix / "share" / package for prefix in _prefixes()) if folder.is_dir()]


def _prefixes() -> Iterator[Path]:
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if prefix:
            yield Path(prefix)
    yield Path(sys.prefix)


def _text(name: str, file: Path) -> str:
    try:
        return read_text(file, SIZE_LIMIT)
    except ModelFileError as error:
        raise UnknownInterfaceError(f"{name} cannot be read: {error}") from error


def _described(message: Mapping[str, Any], known: Mapping[str, Any], depth: int) -> tuple[FieldType, ...]:
    if depth > DEPTH_LIMIT:
        raise ValueError("nested too deep")
    return tuple(_field(field, known, depth) for field in message["fields"] if field["name"] != _FILLER)


def _field(field: Mapping[str, Any], known: Mapping[str, Any], depth: int) -> FieldType:
    name, type_ = str(field["name"]), field["type"]
    number, capacity = int(type_["type_id"]), int(type_["capacity"])
    base, form = next((number - offset, form) for offset, form in _FORMS if number > offset)
    inner: tuple[FieldType, ...] = ()
    if base == _NESTED:
        ros, kind = str(type_["nested_type_name"]), "record"
        inner = _described(known[ros], known, depth + 1)
    elif base in _SCALARS:
        ros = _SCALARS[base]
        kind = {"bool": "boolean", "float32": "number", "float64": "number"}.get(ros, "integer")
        if ros in ("string", "wstring"):
            kind, limit = "text", int(type_["string_capacity"])
            ros = f"{ros}<={limit}" if limit else ros
    else:
        raise ValueError(f"the field {name} has the type {number}, which tokens cannot have")
    empty: Value = {part.name: part.default for part in inner} if kind == "record" else EMPTY[kind]
    if form == "single":
        made = FieldType(name, kind, "text", None, empty, ros, None, inner)
    else:
        length = capacity if form == "array" else None
        bound = capacity if form == "bounded" else None
        made = FieldType(name, "list", kind, length, [empty] * (length or 0), ros, bound, inner)
    return _with_default(made, str(field["default_value"]))


def _with_default(field: FieldType, text: str) -> FieldType:
    """Return a field with the default of a type description, if it has one."""
    if not text:
        return field
    value = text if field.kind == "text" else _literal(text)
    try:
        default = field_value(field, value)
    except FeatureValueError as error:
        raise ValueError(f"the field {field.name} has a default that does not fit: {error}") from error
    return replace(field, default=default)


def _literal(text: str) -> Any:
    """Return a value as interface definitions write it: numbers and lists as Python does, texts also bare."""
    if text in ("true", "false", "True", "False"):
        return text in ("true", "True")
    if re.fullmatch(r"[+-]?[0-9]{1,20}", text):  # leading zeros are decimal there
        return int(text)
    try:
        return ast.literal_eval(text)
    except (ValueError, SyntaxError, MemoryError, RecursionError):
        return text
