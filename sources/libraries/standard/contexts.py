"""Interprets ``contextlib``: what runs at the begin and at the end of a ``with``."""

from __future__ import annotations

import ast

from dineros.sources.language.machine import Machine
from dineros.sources.language.values import (
    NONE,
    Const,
    Frame,
    Function,
    Made,
    Object,
    Open,
    Value,
    options,
)

_STACKS = ("contextlib.ExitStack", "contextlib.AsyncExitStack")
_CLOSES = {"contextlib.closing": "close", "contextlib.aclosing": "aclose"}
Left = tuple[Value, list[Value], dict[str, Value], bool]
"""What runs at the end of a stack: a function with its arguments, or an entered value; whether perhaps."""


class Contexts:
    """The managers of ``with`` statements.

    `machine`: the interpreter.
    """

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self._pending: dict[Made, list[Left]] = {}  # values compare by identity

    def enter(self, value: Value, node: ast.AST, frame: Frame) -> Value:
        """Begin a ``with``; return what it assigns."""
        if isinstance(value, Object):
            for name in ("__enter__", "__aenter__"):
                method = self.machine.look_up(value.cls, name)
                if isinstance(method, Function):
                    return self.machine.special(value, name, [], node, frame) or value
        if isinstance(value, Made) and value.path in (*_CLOSES, "contextlib.nullcontext"):
            return value.args[0] if value.args else NONE
        return value

    def leave(self, value: Value, node: ast.AST, frame: Frame) -> None:
        """End a ``with``."""
        if isinstance(value, Object):
            for name in ("__exit__", "__aexit__"):
                self.machine.special(value, name, [Open("error")] * 3, node, frame)
        elif isinstance(value, Made) and value.path in _CLOSES and value.args:
            name = _CLOSES[value.path]
            method = self.machine.attribute(value.args[0], name, name, node, frame)
            self.machine.call(method, [], {}, node, frame)
        elif isinstance(value, Made) and value.path in _STACKS:
            self._unwind(value, node, frame)

    def method(
        self, stack: Made, name: str, args: list[Value], keys: dict[str, Value], node: ast.AST, frame: Frame
    ) -> Value | None:
        """Call a method of a stack of managers; None: of something else, or another method."""
        if stack.path not in _STACKS:
            return None
        pending = self._pending.setdefault(stack, [])
        is_perhaps = self.machine.activity.conditional > stack.level
        if name in ("callback", "push_async_callback") and args:
            pending.append((args[0], args[1:], keys, is_perhaps))
            return args[0]
        if name in ("push", "push_async_exit") and args:
            is_manager = any(isinstance(each, (Object, Made)) for each in options(args[0]))
            pending.append((args[0], [], {} if is_manager else {"": Const(None)}, is_perhaps))
            return args[0]
        if name in ("enter_context", "enter_async_context") and args:
            found = self.enter(args[0], node, frame)
            if any(isinstance(each, (Object, Made)) for each in options(args[0])):
                pending.append((args[0], [], {}, is_perhaps))
            return found
        if name in ("close", "aclose"):
            self._unwind(stack, node, frame)
            return NONE
        if name == "pop_all":
            other = Made(stack.path, [], {}, stack.at)
            self._pending[other] = self._pending.pop(stack)
            return other
        return None

    def _unwind(self, stack: Made, node: ast.AST, frame: Frame) -> None:
        for function, args, keys, is_perhaps in reversed(self._pending.pop(stack, [])):
            if is_perhaps:
                with self.machine.perhaps():
                    self._end(function, args, keys, node, frame)
            else:
                self._end(function, args, keys, node, frame)

    def _end(
        self, function: Value, args: list[Value], keys: dict[str, Value], node: ast.AST, frame: Frame
    ) -> None:
        if isinstance(function, (Object, Made)) and not args and not keys:
            self.leave(function, node, frame)
        elif "" in keys:
            self.machine.call(function, [Open("error")] * 3, {}, node, frame)
        else:
            self.machine.call(function, args, keys, node, frame)
