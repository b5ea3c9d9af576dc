"""Converts facts to plain JSON and back: nodes with all objects to which they refer, each object once.

An object is a row: the name of its class and the values of its fields. A value is a number, a text, a truth
value or None as JSON has them, or a list that begins with what it is::

    ["list", value, ..]  ["tuple", value, ..]  ["set", value, ..]  ["dict", [key, value], ..]
    ["float", text]      ["object", number of the row]

JSON from a cache may be damaged, so each value must fit the annotation of its field.
"""

from __future__ import annotations

import dataclasses
import math
import types
from collections.abc import Callable
from functools import cache
from typing import Any, Union, get_args, get_origin, get_type_hints

from dineros.sources import branches, facts, places, variables
from dineros.sources.facts import NodeFact

_CLASSES: dict[str, Any] = {
    each.__name__: each
    for module in (facts, branches, variables, places)
    for each in vars(module).values()
    if dataclasses.is_dataclass(each) and isinstance(each, type)
}
"""By name the classes of objects in facts."""
_VALUES = tuple(each for each in _CLASSES.values() if each.__dataclass_params__.frozen)
"""Those of which two equal objects are the same."""


def to_plain(nodes: list[NodeFact]) -> list[Any]:
    """Return nodes as JSON: a row for each object; the nodes are the first rows.

    Raises
    ------
    ValueError
        They refer to an object that is not part of facts, such as bytes.
    """
    numbers: dict[object, int] = {}
    objects: list[Any] = []

    def number(found: Any) -> int:
        key = found if isinstance(found, _VALUES) else id(found)
        if key not in numbers:
            numbers[key] = len(objects)
            objects.append(found)
        return numbers[key]

    for node in nodes:
        number(node)
    rows: list[Any] = [len(objects)]
    for found in objects:  # it grows meanwhile
        name = type(found).__name__
        if _CLASSES.get(name) is not type(found):
            raise ValueError(f"a fact has a value of type {name}")
        rows.append([name, *(_plain(getattr(found, key), number) for key in _fields(name))])
    return rows


def _plain(value: Any, number: Callable[[Any], int]) -> Any:
    if value is None or isinstance(value, (str, bool, int)):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else ["float", repr(value)]
    if isinstance(value, (list, tuple)):
        return [type(value).__name__, *(_plain(each, number) for each in value)]
    if isinstance(value, frozenset):
        return ["set", *sorted((_plain(each, number) for each in value), key=repr)]
    if isinstance(value, dict):
        return ["dict", *([_plain(key, number), _plain(each, number)] for key, each in value.items())]
    return ["object", number(value)]


def from_plain(plain: Any) -> list[NodeFact]:
    """Return the nodes of JSON.

    Raises
    ------
    ValueError, KeyError, TypeError, IndexError, AttributeError, RecursionError
        It is not a result of `to_plain`.
    """
    count, *rows = plain
    objects: list[Any] = [object.__new__(_CLASSES[name]) for name, *_ in rows]
    for found, (name, *values) in zip(objects, rows, strict=True):
        for (key, annotation), value in zip(_fields(name).items(), values, strict=True):
            made = _value(value, objects)
            if not _fits(made, annotation):
                raise TypeError
            object.__setattr__(found, key, made)  # some classes are frozen
    nodes = objects[:count]
    if len(nodes) != count or not _fits(nodes, list[NodeFact]):
        raise TypeError
    return nodes


def _value(plain: Any, objects: list[Any]) -> Any:
    if not isinstance(plain, list):
        return plain
    kind, *values = plain
    if kind == "dict":
        return {_value(key, objects): _value(each, objects) for key, each in values}
    if kind == "object":
        (number,) = values
        if number < 0:
            raise IndexError
        return objects[number]
    if kind == "float":
        return float(*values)
    made = [_value(each, objects) for each in values]
    return made if kind == "list" else {"tuple": tuple, "set": frozenset}[kind](made)


@cache
def _fields(name: str) -> dict[str, Any]:
    """Return the annotations of the fields that are kept of a class, in their order.

    The others have constant defaults, which are attributes of the class.
    """
    hints = get_type_hints(_CLASSES[name])
    kept = (each for each in dataclasses.fields(_CLASSES[name]) if each.metadata.get("is_kept", True))
    return {each.name: hints[each.name] for each in kept}


def _fits(value: Any, annotation: Any) -> bool:
    """Return whether a value has the type of an annotation.

    Examples
    --------
    >>> _fits([1, 2], list[int]), _fits([1, "2"], list[int]), _fits(True, int), _fits(None, int | None)
    (True, False, False, True)
    """
    if annotation in (Any, object):
        return True
    kind, inner = get_origin(annotation), get_args(annotation)
    if kind in (Union, types.UnionType):
        return any(_fits(value, each) for each in inner)
    if kind is dict:
        return isinstance(value, dict) and all(
            _fits(key, inner[0]) and _fits(each, inner[1]) for key, each in value.items()
        )
    if kind is tuple and inner[-1] is not ...:
        return isinstance(value, tuple) and len(value) == len(inner) and all(map(_fits, value, inner))
    if kind is not None:
        return isinstance(value, kind) and all(_fits(each, inner[0]) for each in value)
    if annotation is float:
        return isinstance(value, (int, float)) and not isinstance(value, bool)
    return isinstance(value, annotation) and (annotation is not int or not isinstance(value, bool))
