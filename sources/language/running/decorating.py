"""Applies the decorators of a program to functions and classes."""

from __future__ import annotations

import ast
from dataclasses import replace

from dineros.sources.language.machine import EVENT
from dineros.sources.language.modules import text_of_code
from dineros.sources.language.running.polling import Polling
from dineros.sources.language.values import (
    Bound,
    Class,
    Frame,
    Function,
    Object,
    Outside,
    Partial,
    Value,
)

_WRAPS = "functools.wraps"
Definition = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


class Decorating(Polling):
    """The part of the interpreter that applies decorators."""

    def decorated(
        self,
        value: Function | Class,
        node: ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef,
        frame: Frame,
    ) -> Value:
        """Return what a definition assigns: the result of the program's own decorators, the nearest first.

        Those of libraries, such as ``property``, stay names of the function.
        """
        found: Value = value
        for decorator in reversed(node.decorator_list):
            named = decorator.func if isinstance(decorator, ast.Call) else decorator
            if isinstance(named, ast.Attribute) and named.attr == "register":
                self._register(self.evaluate(named.value, frame), found)
            if self._is_manager(named, frame):
                manager = self.evaluate(decorator, frame)
                if isinstance(found, Function):
                    found = replace(found, around=(*found.around, manager))
                continue
            if self._is_own(named, frame):
                made = self.call(self.evaluate(decorator, frame), [found], {}, decorator, frame)
            elif isinstance(found, Function) and self._is_wraps(named, frame):
                made = replace(found)
            else:
                continue
            if isinstance(made, (Function, Bound, Partial, Object, Class)):
                found = self._with_name(made, found, decorator)
        return found

    def gives_to_rclpy(self, value: ast.expr | None) -> None:
        """Record what a callback returns.

        rclpy awaits the value only if the callback is a coroutine function.
        """
        activity, is_outer = self.activity.fact, len(self.calls) == 1
        if is_outer and not activity.is_async and activity.kind not in (EVENT, "main", "module", "thread"):
            self.unused = value

    def _register(self, generic: Value, function: Value) -> None:
        """Record a function of ``functools.singledispatch`` for another type."""
        if isinstance(generic, Function) and any("singledispatch" in each for each in generic.decorators):
            generic.registered.append(function)

    def _is_manager(self, named: ast.expr, frame: Frame) -> bool:
        """Return whether a decorator enters a ``with`` around each call."""
        value = self.evaluate(named, frame) if isinstance(named, (ast.Name, ast.Attribute)) else None
        if isinstance(value, Object):
            value = value.cls
        return isinstance(value, Class) and any("ContextDecorator" in each for each in value.outside())

    def _is_own(self, named: ast.expr, frame: Frame) -> bool:
        """Return whether the program itself defines a decorator."""
        root = named
        while isinstance(root, ast.Attribute):
            root = root.value
        if not isinstance(root, ast.Name) or text_of_code(named).endswith(_PARTS):
            return False
        value = self.evaluate(named, frame)
        return isinstance(value, (Function, Bound, Class)) or (
            isinstance(value, Object) and self.look_up(value.cls, "__call__") is not None
        )

    def _is_wraps(self, named: ast.expr, frame: Frame) -> bool:
        value = self.evaluate(named, frame) if isinstance(named, (ast.Name, ast.Attribute)) else None
        return isinstance(value, Outside) and value.path == _WRAPS

    @staticmethod
    def _with_name(made: Value, before: Value, decorator: ast.expr) -> Value:
        """Return what a decorator makes of a function, which keeps the name of this function."""
        if not isinstance(made, Function) or not isinstance(before, Function):
            return made
        text = text_of_code(decorator)
        if made is before or made.node is before.node:
            return replace(before, decorators=tuple(each for each in before.decorators if each != text))
        kept = tuple(each for each in before.decorators if each != text)
        return replace(made, original=before.original or before, decorators=(*made.decorators, *kept))


_PARTS = (".setter", ".getter", ".deleter")
