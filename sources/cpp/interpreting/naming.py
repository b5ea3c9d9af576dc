"""Names, types and periods of ports, and names of callbacks, from values."""

from __future__ import annotations

from dineros.sources.cpp.interpreting.parameters import OWN_NAME
from dineros.sources.cpp.operations import binary
from dineros.sources.cpp.parsing import line_of, path_of, text_of
from dineros.sources.cpp.values import (
    Const,
    Either,
    Lambda,
    Made,
    Method,
    Obj,
    Open,
    Seconds,
    Value,
    constant,
    options,
    shown,
)
from dineros.sources.facts import is_open
from dineros.sources.places import Place

SUB_SPACE = "its namespace"
"""The field of a sub-node (``create_sub_node``) with its namespace."""


def private(name: str) -> str:
    """Return a name with ``~`` for the name of the node if the latter is unknown."""
    own = f"{{{OWN_NAME}}}/"
    return f"~/{name.removeprefix(own)}" if name.startswith(own) else name


def name_on(owner: Obj, name: Value | None) -> str:
    """Return the name of a port of a node; names of a sub-node are in its namespace."""
    text = private(shown(name)) if name is not None else "open"
    space = owner.fields.get(SUB_SPACE) if owner.cls is None else None
    if space is None or text.startswith(("/", "~")):
        return text
    return shown(binary("+", binary("+", space, Const("/")), name if name is not None else Open("a name")))


def is_callable(value: Value) -> bool:
    """Return whether a value may be a lambda, a method or a function."""
    return any(isinstance(each, (Lambda, Method)) for each in options(value))


_PARTS_OF_ACTIONS = {
    "SendGoalService": "_SendGoal",
    "GetResultService": "_GetResult",
    "FeedbackMessage": "_FeedbackMessage",
}
"""Interfaces that an action is made of, by their names in C++."""


def ros_type(text: str) -> str:
    """Return the name of an interface in the notation of ROS; open if it is not one."""
    parts = text.lstrip(":").split("::")
    if len(parts) == 3 and parts[1] in ("msg", "srv", "action"):
        return "/".join(parts)
    if len(parts) == 5 and parts[1] == "action" and parts[3] == "Impl" and parts[4] in _PARTS_OF_ACTIONS:
        return "/".join(parts[:3]) + _PARTS_OF_ACTIONS[parts[4]]
    return f"open: {text}"


def period_of(value: Value) -> float | str:
    """Return the seconds of a timer."""
    if isinstance(value, Seconds):
        return round(value.value, 12)
    if isinstance(value, Either):
        return "open: " + " or ".join(str(period_of(each)).removeprefix("open: ") for each in value.options)
    if isinstance(value, Made) and value.path.endswith("Rate") and value.args:
        rate = constant(value.args[0])
        if isinstance(rate, (int, float)) and rate > 0:
            return 1.0 / rate
    return shown(value) if is_open(shown(value)) else f"open: {shown(value)}"


def place_of(target: Value, at: Place) -> tuple[str, Place | None]:
    """Return the name of a callable and its first line; None: unknown."""
    for each in options(target):
        if isinstance(each, Lambda):
            return _name_of(each), Place(each.frame.path, line_of(each.node))
        if isinstance(each, Method):
            routine = next((one for one in each.routines if one.body is not None), None)
            if routine is not None:
                return each.name, Place(routine.path, routine.line)
    return "open", None


def _name_of(found: Lambda) -> str:
    """Return a name for a lambda: its variable, the only method that it calls, or ``lambda``."""
    parent = found.node.parent
    if parent is not None and parent.type == "init_declarator":
        return text_of(parent.child_by_field_name("declarator")).strip("&* ")
    body = found.node.child_by_field_name("body")
    inner = [] if body is None else [each for each in body.named_children if each.type != "comment"]
    if len(inner) == 1 and inner[0].named_children:
        call = inner[0].named_children[0]
        function = call.child_by_field_name("function")
        is_macro = text_of(function).isupper()
        if (
            call.type == "call_expression"
            and function is not None
            and not is_macro
            and "publish" not in text_of(function)
        ):
            return path_of(function.child_by_field_name("field") or function).replace("this->", "")
    return "lambda"
