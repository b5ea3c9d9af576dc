"""Recognises callbacks that are the same code: inner functions differ by the variables around them.

A callback may schedule itself again, such as ``future.add_done_callback(lambda future: self.send())``. Then
it is read once, or a few times if the variables around it have other constants each time.
"""

from __future__ import annotations

import ast
from collections.abc import Hashable, Iterator
from dataclasses import replace

from dineros.sources.language.values import (
    QUEUE,
    Bound,
    Callback,
    Frame,
    Function,
    Items,
    Made,
    Mapping,
    Object,
    Open,
    Partial,
    Port,
    Value,
    identity,
    same,
)


def callback_key(function: Value) -> tuple[Hashable, ...]:
    """Return the key of a callback; its first part is the code."""
    if isinstance(function, Bound):
        return (id(function.function.code), id(function.instance))
    if isinstance(function, Function):
        values = (*_around(function).items(), *sorted(function.defaults.items()))
        return (id(function.code), *((name, _made_again(value)) for name, value in values))
    if isinstance(function, Partial):
        return callback_key(function.function)
    if isinstance(function, Object):
        return (id(function),)
    return (type(function).__name__, getattr(function, "path", ""))


def widen(callback: Callback, most: int) -> None:
    """Let a callback that has scheduled itself at least `most` times have any constants around it.

    Objects that each turn makes again at one line count as the same. So the number of turns is finite.
    """
    function = callback.function
    before = [each for each in _parents(callback) if _is_again(each, callback)]
    if not isinstance(function, Function) or len(before) < most:
        return
    last = before[0].function
    known = _around(last) if isinstance(last, Function) else {}
    names = {name: _any_time(name, value, known.get(name)) for name, value in _around(function).items()}
    callback.again = before[0]
    frame = replace(function.frame, names={**function.frame.names, **names})
    callback.function = replace(function, frame=frame)


def _any_time(name: str, value: Value, before: Value | None) -> Value:
    """Return a value that stands for a variable at any turn."""
    if before is not None and same(value, before):
        return value
    if isinstance(value, Object) and isinstance(before, Object):
        return before if (value.cls, value.at) == (before.cls, before.at) else value
    return value if isinstance(value, (Bound, Function, Made, Object, Port)) else Open(name)


def _parents(callback: Callback) -> Iterator[Callback]:
    """Yield the callbacks whose code scheduled a callback, the nearest first."""
    found = callback.parent
    while found is not None:
        yield found
        found = found.parent


def _is_again(one: Callback, other: Callback) -> bool:
    """Return whether two callbacks are the same code."""
    return one.fact.kind == other.fact.kind and (
        callback_key(one.function)[0] == callback_key(other.function)[0]
    )


def _around(function: Function) -> dict[str, Value]:
    """Return the variables of outer functions that an inner function uses, sorted by name."""
    found: dict[str, Value] = {}
    if function.frame.function is None:
        return found
    own = {each.arg for each in ast.walk(function.node) if isinstance(each, ast.arg)}
    used = {each.id for each in ast.walk(function.node) if isinstance(each, ast.Name)}
    for name in sorted(used - own):
        frame: Frame | None = function.frame
        while frame is not None and name not in frame.names:
            frame = frame.outer
        if frame is not None:
            found[name] = frame.names[name]
    return found


def _made_again(value: Value, depth: int = 3) -> Hashable:
    """Return a key of a value; what one line makes again counts as the same: results of a library, lists."""
    if isinstance(value, Items) and value.kind != QUEUE and depth:
        return (Items, value.kind, *(_made_again(each, depth - 1) for each in value.items[:8]))
    if isinstance(value, Mapping) and depth:
        return (
            Mapping,
            *((key, _made_again(each, depth - 1)) for key, each in list(value.items.items())[:8]),
        )
    return (value.path, value.at) if isinstance(value, Made) else identity(value)
