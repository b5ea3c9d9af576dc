"""Operations on constants: methods of strings, simple built-in functions."""

from __future__ import annotations

import posixpath
import re
import string
from collections.abc import Callable
from typing import Any

from dineros.sources.language.values import Const, Items, Open, OutsideMethod, Text, Value, hole, spread

_METHODS = frozenset(
    (
        *("strip", "lstrip", "rstrip", "lower", "upper", "title", "capitalize", "replace", "split", "rsplit"),
        *(
            "startswith",
            "endswith",
            "removeprefix",
            "removesuffix",
            "partition",
            "rpartition",
            "count",
            "find",
        ),
        *("join", "isdigit", "splitlines"),
    )
)

_MOST_TEXT = 5_000


def call_constant(function: Value, args: list[Value], keys: dict[str, Value]) -> Value | None:
    """Call a method of a string; None: an unknown method."""
    if not isinstance(function, OutsideMethod):
        return None
    instance, name = function.instance, function.name
    if name == "format":
        template = instance.value if isinstance(instance, Const) else None
        if not isinstance(template, str):
            return None
        names = list(keys)
        return spread(
            [*args, *keys.values()],
            lambda found: format_text(
                template, found[: len(args)], dict(zip(names, found[len(args) :], strict=True))
            ),
        )
    if not isinstance(instance, Const) or name not in _METHODS or not hasattr(instance.value, name):
        return None
    if name == "join":
        parts = args[0].items if args and isinstance(args[0], Items) and not args[0].is_open else None
        if parts is None:
            return Open(function.text)
        text = str(instance.value).join(hole(each) for each in parts)
        return Const(text, instance.origin) if all(isinstance(each, Const) for each in parts) else Text(text)
    if not all(isinstance(each, Const) for each in args) or keys:
        return Open(function.text)
    if sum(len(str(each.value)) for each in (instance, *args) if isinstance(each, Const)) > _MOST_TEXT:
        return Open(function.text)
    try:
        found = getattr(instance.value, name)(*(each.value for each in args if isinstance(each, Const)))
    except (TypeError, ValueError, ArithmeticError):
        return Open(function.text)
    origin = instance.origin or next(
        (each.origin for each in args if isinstance(each, Const) and each.origin), ""
    )
    if isinstance(found, (list, tuple)):
        return Items([Const(each, origin) for each in found])
    return Const(found, origin)


def format_text(template: str, args: list[Value], keys: dict[str, Value]) -> Value:
    """Return ``template.format(...)``; unknown parts are in braces."""
    found = ""
    number, is_known, origin = 0, True, ""
    try:
        parts = list(string.Formatter().parse(template))
    except ValueError:
        return Open(template)
    for text, field, spec, conversion in parts:
        found += text
        if field is None:
            continue
        name = field or str(number)
        number += not field
        value: Value | None = keys.get(name)
        if name.isdecimal():
            at = int(name) if len(name) < 5 else len(args)
            value = args[at] if at < len(args) else None
        if isinstance(value, Const):
            origin = origin or value.origin
            if re.search(r"\d{4}", spec or ""):  # a width that would take all memory
                return Open(template)
            try:
                found += format(value.value, spec or "") if not conversion else str(value.value)
            except (ValueError, TypeError, ArithmeticError):
                return Open(template)
        else:
            found += hole(value or Open(name))
            is_known = False
    return Const(found, origin) if is_known else Text(found)


def call_built_in(name: str, args: list[Value], text: str) -> Value | None:
    """Call a built-in function, or one of ``os.path``, with constants; None: another function."""
    values = [each.value for each in args if isinstance(each, Const)]
    if len(values) != len(args) or not args:
        return None
    origin = next((each.origin for each in args if isinstance(each, Const) and each.origin), "")
    try:
        if name in ("str", "int", "float", "bool", "abs", "round", "len"):
            function: dict[str, Callable[..., Any]] = {
                **{"str": str, "int": int, "float": float, "bool": bool},
                **{"abs": abs, "round": round, "len": len},
            }
            return Const(function[name](*values), origin)
        if name in ("min", "max"):
            return Const((min if name == "min" else max)(*values), origin)
        if name == "os.path.join":
            return Const(posixpath.join(*map(str, values)), origin)
        if name in ("os.path.basename", "os.path.dirname"):
            return Const(getattr(posixpath, name[8:])(str(values[0])), origin)
        if name in ("os.path.abspath", "os.path.realpath", "os.path.normpath"):
            return Const(values[0], origin)
    except (TypeError, ValueError, ArithmeticError):
        return Open(text)
    return None
