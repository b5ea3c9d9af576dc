"""Values that calls store: callables with bound arguments, and copies of objects in lists."""

from __future__ import annotations

from dataclasses import replace

from dineros.sources.cpp.following.calls import Call
from dineros.sources.cpp.values import Lambda, Made, Method, Obj, Open, Value, one_of, options


def copied(value: Value, call: Call) -> Value:
    """Return the value that a list stores of an object: a copy with the current members."""
    if isinstance(value, Obj) and value.is_held:
        return replace(value, fields=dict(value.fields), made_at=hash((value.made_at, call.node.id)))
    if isinstance(value, Made) and value.effect is None and value.fields:
        return replace(value, fields=dict(value.fields))
    return value


def bound(args: list[Value]) -> Value:
    """Return the result of ``std::bind`` or ``std::thread`` for a callable and its arguments."""
    target, rest = args[0], args[1:]
    several = options(target)
    if len(several) > 1:
        return one_of([bound([each, *rest]) for each in several])
    if rest and isinstance(target, Method) and len(options(rest[0])) > 1:
        return one_of([bound([target, each, *rest[1:]]) for each in options(rest[0])])
    if isinstance(target, Lambda):
        return target
    if isinstance(target, Method):
        this = target.this
        if rest and isinstance(rest[0], Obj) and any(each.cls is not None for each in target.routines):
            this, rest = rest[0], rest[1:]
        plain = [
            Open("an argument")
            if "_1" in (p := getattr(each, "path", getattr(each, "text", "")))
            or p.startswith(("std::placeholders", "placeholders", "_2", "_3", "_4"))
            else each
            for each in rest
        ]
        return Method(target.routines, target.name, this, [*target.args, *plain])
    return target
