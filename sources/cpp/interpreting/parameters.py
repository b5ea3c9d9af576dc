"""Interprets calls that declare parameters of nodes or get their values."""

from __future__ import annotations

from typing import Any

from dineros.sources.cpp.following.calls import Call
from dineros.sources.cpp.following.statements import Statements
from dineros.sources.cpp.values import Const, Items, Made, Obj, Open, Value, constant, node_in, shown
from dineros.sources.facts import NODE, SPACE, NodeFact, is_open
from dineros.sources.resolving import own_name

_NAMES = ("get_name", "get_namespace", "get_fully_qualified_name")
OWN_NAME = "the name of the node"
"""Stands for the name of a node in names of ports."""
_DECLARE_OR_GET = ("declare_or_get_parameter", "declare_parameter_if_not_declared")


def _own_name(machine: Statements, node: NodeFact, method: str) -> Value:
    """Return what a node learns of its own name or namespace."""
    found = own_name(node, machine.given, method)
    if found is None:
        return Open("the name of the node", f"{{{OWN_NAME}}}")
    return Open(found, found) if is_open(found) else Const(found)


def parameter(machine: Statements, call: Call) -> Value | None:
    """Return the result of a call that declares or gets parameters; None: another call."""
    on = call.on if call.on is not None else call.frame.this
    args = call.args
    if call.last in _DECLARE_OR_GET:  # of nav2: the node, or parts of it, may precede the name
        first = next((at for at, each in enumerate(args) if isinstance(constant(each), str)), len(args))
        given = [each for each in map(node_in, args[:first]) if each is not None]
        on, args = (given[0] if given else on), args[first:]
    if not isinstance(on, Obj) or on.node is None:
        return None
    if call.last in _NAMES and not call.args and (machine.is_launched or call.last != "get_namespace"):
        return _own_name(machine, on.node, call.last)
    if not args:
        return None
    if call.last == "list_parameters":
        return _listed(machine, on, args)
    name = shown(args[0])
    if call.last == "has_parameter":
        return Const(name in on.parameters)
    if call.last in ("declare_parameter", "add_parameter", *_DECLARE_OR_GET):
        value = machine.given.get(name, None)
        default = args[1] if len(args) > 1 else Open(f"parameter {name}")
        default = on.parameters.get(name, default) if call.last in _DECLARE_OR_GET else default
        if isinstance(default, Made) and default.path.endswith("ParameterValue") and default.args:
            default = default.args[0]
        if "PARAMETER_" in (getattr(default, "path", "") or getattr(default, "text", "")):
            default = Open(f"parameter {name}")  # only its type is declared: it may have no value
            on.unset.add(name)
        if value is not None:
            default = given_value(value)
            on.unset.discard(name)
        on.parameters[name] = default
        entity = machine.entity_of("parameters", name, call.node, call.frame, on)
        entity.name = name
        if constant(default) is not None:
            entity.details["default"] = constant(default)
        return default
    if call.last in ("get_parameter", "get_parameter_or"):
        found = on.parameters.get(name, Open(f"parameter {name}"))
        is_unset = name not in on.parameters or name in on.unset
        if is_unset and name in machine.given:  # declared by its value, as options of nodes can say
            found = given_value(machine.given[name])
        elif len(call.args) > 2 and is_unset:
            found = call.args[2]
        if len(call.nodes) > 1:
            machine.assign(call.nodes[1], found, call.frame)
        return found
    return None


def _listed(machine: Statements, on: Obj, args: list[Value]) -> Value | None:
    """Return the names of parameters, and their parts before the last dot; None: not known."""
    spaces = [constant(each) for each in args[0].values] if isinstance(args[0], Items) else [None]
    known = [each for each in (*on.parameters, *machine.given) if each not in (NODE, SPACE)]
    if not machine.given or any(not isinstance(each, str) for each in spaces):
        return None
    names = [name for name in dict.fromkeys(known) if any(name.startswith(f"{each}.") for each in spaces)]
    names = names if spaces else known
    parts = dict.fromkeys(name.rpartition(".")[0] for name in names if "." in name)
    fields: dict[str, Value] = {
        "names": Items([Const(each) for each in names]),
        "prefixes": Items([Const(each) for each in parts]),
    }
    return Made("rcl_interfaces::msg::ListParametersResult", fields=fields)


def given_value(given: Any) -> Value:
    """Return a value that a launch or parameter file gives."""
    return Items([given_value(each) for each in given]) if isinstance(given, list) else Const(given)
