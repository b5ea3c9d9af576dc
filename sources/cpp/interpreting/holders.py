"""Interprets classes of the standard library that hold one value: optional, variant, any; and atomics."""

from __future__ import annotations

from contextlib import nullcontext
from typing import TYPE_CHECKING

from dineros.sources.cpp.following.calls import Call
from dineros.sources.cpp.following.endings.polling import POLLED, Polled, value_in_words
from dineros.sources.cpp.following.statements import Statements
from dineros.sources.cpp.parsing import arguments_of, on_text, path_of, text_of
from dineros.sources.cpp.values import (
    NO_VALUE,
    Const,
    Items,
    Lambda,
    Made,
    Method,
    Obj,
    Open,
    Port,
    Value,
    one_of,
    options,
)

if TYPE_CHECKING:
    from tree_sitter import Node

OPTIONAL, VARIANT, ANY = "optional", "variant", "any"
_HOLDERS = {
    f"{space}::{name}": name for space in ("std", "boost", "tl", "absl") for name in (OPTIONAL, VARIANT, ANY)
}
"""Classes that hold one value, of another type."""
_IN_PLACE = ("std::in_place", "std::in_place_type", "std::in_place_index")
_GETS = ("std::get", "std::get_if", "std::any_cast", "boost::get", "boost::any_cast")
_ATOMIC = ("atomic", "atomic_flag", "atomic_bool", "atomic_int", "atomic_uint", "atomic_size_t")


def held(machine: Statements, call: Call) -> Value | None:
    """Return the result of a call of a class that holds one value; None: another call."""
    if call.last == "wait" and call.args and call.on is not None:
        return _wait_of_atomic(machine, call)
    if call.last == "emplace" and not isinstance(call.on, (Items, Port)):
        return _emplaced(machine, call)
    if call.last == "swap" and (call.on is not None or call.path == "std::swap"):
        return _swapped(machine, call)
    if call.on is not None:
        return None
    if call.path == "std::exchange" and len(call.args) == 2:
        machine.assign(call.nodes[0], call.args[1], call.frame)
        return call.args[0]
    if call.path in _HOLDERS:
        return _new(machine, call)
    if call.path == "std::make_optional" and arguments_of(call.named):
        kind = arguments_of(call.named)[0]
        return machine.declared(kind, call.args, call.node, call.frame)
    if call.path in _GETS and call.args:
        return _item(machine, call)
    return None


def visited(machine: Statements, call: Call) -> Value:
    """Call the function that ``std::visit`` receives with the value of a variant, whichever it has."""
    found: list[Value] = []
    values = options(call.args[1]) if len(call.args) > 1 else ()
    for each in values:
        with machine.perhaps() if len(values) > 1 else nullcontext():
            found.append(machine.invoke(call.args[0], [each, *call.args[2:]], call.node, call.frame))
    return one_of(found) if found else Open(text_of(call.node)[:60])


def _swapped(machine: Statements, call: Call) -> Value | None:
    """Give two variables the values of each other; None: something else is swapped."""
    function = call.node.child_by_field_name("function")
    left = None if function is None else function.child_by_field_name("argument")
    nodes = call.nodes if call.on is None else [left, *call.nodes]
    values = call.args if call.on is None else [call.on, *call.args]
    if len(values) != 2 or len(nodes) != 2:
        return None
    for node, value in zip(nodes, reversed(values), strict=True):
        machine.assign(node, value, call.frame)
    return Const(None)


def _new(machine: Statements, call: Call) -> Value:
    """Return the value of a new object: the given one, or one that is made in it."""
    first = getattr(call.args[0], "path", "") if call.args else ""
    if first in _IN_PLACE:
        node = call.nodes[0] if call.nodes else None
        kind = next(iter(arguments_of(node)), None) or _inner(machine, call.named, call, 0)
        if kind is not None:
            return machine.declared(kind, call.args[1:], call.node, call.frame)
    return call.args[0] if len(call.args) == 1 else NO_VALUE


def _emplaced(machine: Statements, call: Call) -> Value | None:
    """Give an object of such a class a new value; None: it belongs to another class."""
    function = call.node.child_by_field_name("function")
    left = None if function is None else function.child_by_field_name("argument")
    holder = machine.kind_of(left, call.frame)
    name = _HOLDERS.get(machine.type_text(holder, call.frame)) if holder is not None else None
    given = arguments_of(call.named)
    if name is None:
        return None
    number = text_of(given[0]) if given else "0"
    kind = _inner(machine, holder, call, int(number)) if number.isdigit() else given[0]
    value: Value = Open(text_of(call.node)[:60])
    if kind is not None:
        value = machine.declared(kind, call.args, call.node, call.frame)
    machine.assign(left, value, call.frame)
    return value


def _inner(machine: Statements, holder: Node | None, call: Call, number: int) -> Node | None:
    """Return a type that such a class may hold; None: it is not known."""
    inner = machine.templated(holder, call.frame)
    return inner[number] if number < len(inner) else None


def _item(machine: Statements, call: Call) -> Value | None:
    """Return the value that a variant holds if it has a type; None: of a tuple, or not known."""
    given, found = arguments_of(call.named), options(call.args[0])
    if not given or text_of(given[0]).isdigit():
        return None
    kind = machine.template_text(given[0], call.frame)
    cls = machine.class_of(kind.partition("<")[0], call.frame)
    fitting = [each for each in found if _fits(machine, each, kind, cls)]
    return one_of(fitting) if fitting else None


def _fits(machine: Statements, value: Value, kind: str, cls: object) -> bool:
    if isinstance(value, Obj):
        return cls is None or (value.cls is not None and cls in machine.bases(value.cls))
    if isinstance(value, (Lambda, Method)):
        return cls is None
    return cls is None and isinstance(value, (Port, Made, Items))


def _wait_of_atomic(machine: Statements, call: Call) -> Value | None:
    """Wait until an atomic variable has another value: callbacks that change it end the wait."""
    function = call.node.child_by_field_name("function")
    left = None if function is None else function.child_by_field_name("argument")
    kind = machine.kind_of(left, call.frame)
    last = machine.type_text(kind, call.frame).rpartition("::")[2] if kind is not None else ""
    if last not in _ATOMIC:
        return None
    if machine.fact.kind not in ("thread", "event"):
        name = path_of(left).rpartition("->")[2].rpartition(".")[2]
        polled = Polled(name, name, value_in_words(call.args[0]), is_equal=False)
        machine.does("wait", on_text(call.node).removeprefix("this->"), call.node, call.frame, POLLED)
        machine.polled.setdefault(on_text(call.node).removeprefix("this->"), set()).add(polled)
    return Open("a wait")
