"""Interprets the classes that ``generate_parameter_library`` generates: ``ParamListener`` and ``Params``."""

from __future__ import annotations

from typing import Any

from dineros.sources.cpp.following.calls import Call
from dineros.sources.cpp.following.statements import Statements
from dineros.sources.cpp.interpreting.parameters import given_value
from dineros.sources.cpp.tables.parameter_libraries import Library
from dineros.sources.cpp.values import Const, Made, Obj, Open, Value, constant, node_in

LISTENER, STRUCT = "ParamListener", "Params"
_GETS = ("get_params", "try_get_params", "update_params")


def generated(machine: Statements, call: Call) -> Value | None:
    """Return the result of a call that makes or uses a generated class; None: another call."""
    on = call.on
    if on is None and call.last in (LISTENER, STRUCT):
        space = call.frame.cls.full if call.frame.cls is not None else call.frame.space
        library = machine.index.libraries.find(call.path, space, call.frame.path)
        if library is None:
            return None
        if call.last == STRUCT:
            return _struct(_values(machine, library, ""))
        prefix = constant(call.args[1]) if len(call.args) > 1 else ""
        before = f"{prefix}." if isinstance(prefix, str) and prefix else ""
        values = _values(machine, library, before)
        owner = next((each for each in map(node_in, call.args) if each is not None), call.frame.this)
        if owner is not None and owner.node is not None:
            _declare(machine, call, owner, before, values)
        return Made(call.path, [], {STRUCT: _struct(values)}, node=call.node)
    if isinstance(on, Made) and on.path.endswith(LISTENER) and STRUCT in on.fields and call.last in _GETS:
        found = _copy(on.fields[STRUCT])
        if call.nodes:
            machine.assign(call.nodes[0], found, call.frame)
            return Open(call.last)
        return found
    return None


def _values(machine: Statements, library: Library, prefix: str) -> dict[str, Value]:
    found: dict[str, Value] = {}
    for name, default in library.defaults.items():
        given: Any = machine.given.get(prefix + name, default)
        found[name] = Open(f"parameter {prefix}{name}") if given is None else given_value(given)
    return found


def _declare(machine: Statements, call: Call, owner: Obj, prefix: str, values: dict[str, Value]) -> None:
    for name, value in values.items():
        full = prefix + name
        owner.parameters[full] = value
        entity = machine.entity_of("parameters", full, call.node, call.frame, owner)
        entity.name = full
        if isinstance(value, Const) and value.value is not None:
            entity.details["default"] = value.value


def _struct(values: dict[str, Value]) -> Made:
    """Return a struct with members for parts of names: ``gains.p`` is the member ``p`` of ``gains``."""
    made = Made(STRUCT)
    for name, value in values.items():
        inner = made
        *around, last = name.split(".")
        for each in around:
            found = inner.fields.setdefault(each, Made(STRUCT))
            if not isinstance(found, Made):
                break
            inner = found
        else:
            inner.fields[last] = value
    return made


def _copy(value: Value) -> Value:
    if not isinstance(value, Made):
        return value
    return Made(value.path, value.args, {name: _copy(each) for name, each in value.fields.items()})
