"""Interprets methods of lists and maps of the standard library."""

from __future__ import annotations

from dineros.sources.cpp.binding import copied
from dineros.sources.cpp.following.calls import Call
from dineros.sources.cpp.following.statements import Statements
from dineros.sources.cpp.parsing import text_of
from dineros.sources.cpp.values import (
    PAIRS,
    Const,
    Items,
    Made,
    Obj,
    Open,
    Value,
    constant,
    is_same_item,
    one_of,
    options,
    value_of,
)

_ADDS = {
    *("push_back", "push_front", "push", "insert", "insert_or_assign"),
    *("emplace_back", "emplace_front", "emplace", "try_emplace"),
}
"""Methods of lists that add an item."""
_GIVES = {
    *("at", "front", "back", "top", "find", "begin", "cbegin", "rbegin", "crbegin"),
    *("lower_bound", "upper_bound"),
}
"""Methods of lists that give an item, or an iterator to one."""


def items(machine: Statements, call: Call, on: Items) -> Value:
    """Return the result of a method of a list or map."""
    if call.last in _ADDS:
        value = _item(machine, call, on)
        if not any(is_same_item(each, value) for each in on.values):
            on.values.append(value)
        if len(call.args) == 2 and (key := constant(call.args[0])) is not None:
            on.keys.setdefault(key, value)
        on.is_open = on.is_open or isinstance(value, Open) or machine.when != "always"
        return on
    if call.last == "equal_range" and on.values:
        found = one_of(on.values)
        return Made("std::pair", [found, found])
    if call.last in _GIVES and on.values:
        index = constant(call.args[0]) if call.args else None
        if index in on.keys and len(on.keys) == len(on.values) and not on.is_open:
            return on.keys[index]
        if call.last == "at" and on.is_map:
            return one_of([value_of(each) for each in on.values])
        if call.last == "at" and isinstance(index, int) and 0 <= index < len(on.values) and not _is_map(on):
            return on.values[index]
        return one_of(on.values)
    if call.last == "swap" and call.args and isinstance(call.args[0], Items):
        other = call.args[0]
        on.values, other.values = on.values or other.values, other.values or on.values
        return Const(None)
    if call.last == "size" and not on.is_open:
        return Const(len(on.values))
    return Open(text_of(call.node)[:60])


def _item(machine: Statements, call: Call, on: Items) -> Value:
    """Return the value that a list stores: a given object, or one constructed from the arguments."""
    args, cls = call.args, on.kind
    if on.of.endswith("thread") and call.last.startswith("emplace") and args:
        made = machine.library.call(Call(call.node, call.frame, on.of, args))
        return made if made is not None else Open("a thread")
    if cls is not None and args and isinstance(args[-1], Items):  # an object in braces
        return machine.construct(cls, args[-1].values, [], call.node, call.frame)
    if cls is not None and call.last.startswith("emplace"):
        given = args[1:] if call.last in ("emplace", "try_emplace") and len(args) > 1 else args
        is_made = any(
            isinstance(each, Obj) and each.cls is not None and cls in machine.bases(each.cls)
            for arg in given
            for each in options(arg)
        )
        if not is_made or len(given) != 1:
            return machine.construct(cls, given, [], call.node, call.frame)
    return copied(args[-1], call) if args else Open("an item")


def _is_map(on: Items) -> bool:
    """Return whether a list of this reader stands for a map: a number is a key then, and not a position."""
    pairs = (
        isinstance(each, Made) and each.path.endswith(PAIRS) for item in on.values for each in options(item)
    )
    return bool(on.keys) or any(pairs)
