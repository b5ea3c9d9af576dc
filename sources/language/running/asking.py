"""Finds the attributes, shared variables and events on which the value of a test depends."""

from __future__ import annotations

import ast
from collections.abc import Iterable

from dineros.sources.language.computing.names import shared, shared_name
from dineros.sources.language.endings import asks_for_shutdown
from dineros.sources.language.modules import Modules
from dineros.sources.language.running.matching import Matching
from dineros.sources.language.values import (
    Bound,
    Const,
    Frame,
    Function,
    Future,
    Goal,
    Items,
    Made,
    Mapping,
    Message,
    Object,
    Open,
    Outside,
    OutsideMethod,
    Response,
    Text,
    is_none,
    options,
)

CANCEL = "a request to cancel the goal"
"""What a loop waits for that tests whether a goal shall be canceled."""
_ASK = ("len", "bool", "any", "all", "isinstance", "sum", "min", "max", "abs", "set", "list", "sorted")
"""Built-in functions whose value changes only with their arguments."""
_LOOK = ("empty", "qsize", "full", "get", "keys", "values", "items", "copy")
"""Methods of containers that change nothing."""
_PARTS = (
    *(ast.BoolOp, ast.UnaryOp, ast.Compare, ast.BinOp, ast.Subscript, ast.Tuple, ast.List, ast.Set),
    *(ast.boolop, ast.unaryop, ast.cmpop, ast.operator, ast.expr_context, ast.Slice),
)
"""Parts of a test whose value depends only on their own parts."""


class Asking(Matching):
    """The part of the interpreter that finds what the test of a loop asks for."""

    def __init__(self, modules: Modules, program: str) -> None:
        super().__init__(modules, program)
        self.asked: list[tuple[Object, str]] = []
        """The attributes that the test asks for, with their objects."""
        self.stored: frozenset[str] = frozenset()
        """The local variables that the loop changes."""
        self.has_shared = False
        """Whether the test asks for a variable that several functions share."""

    def depends_on(self, test: ast.AST, frame: Frame, depth: int) -> set[str] | None:
        """Return the attributes and events on which the value of a test depends; None: on something else."""
        if isinstance(test, ast.Constant):
            return set()
        if isinstance(test, ast.Name):
            return self._of_variable(test.id, frame)
        if isinstance(test, _PARTS):
            return self.depend_on(ast.iter_child_nodes(test), frame, depth)
        if isinstance(test, (ast.GeneratorExp, ast.ListComp, ast.SetComp)):
            return self._of_comprehension(test, frame, depth)
        if isinstance(test, ast.Attribute):
            return self._of_attribute(test, frame, depth)
        return self._of_call(test, frame, depth) if isinstance(test, ast.Call) and depth else None

    def _of_comprehension(
        self, test: ast.GeneratorExp | ast.ListComp | ast.SetComp, frame: Frame, depth: int
    ) -> set[str] | None:
        """Return what a comprehension depends on: what it goes through, and what its parts ask of that."""
        inner = Frame(frame.module, dict(frame.names), frame.outer, function=frame.function)
        inner.globals, inner.nonlocals, inner.instance = frame.globals, frame.nonlocals, frame.instance
        found: set[str] = set()
        stored = self.stored
        try:
            for each in test.generators:
                names = self.depends_on(each.iter, inner, depth)
                if names is None or not isinstance(each.target, ast.Name):
                    return None
                found |= names
                values = self.turns(self.evaluate(each.iter, inner))[0]
                is_object = bool(values) and isinstance(values[0], Object)
                self.has_shared |= is_object
                inner.names[each.target.id] = values[0] if is_object else Open(each.target.id)
                self.stored = self.stored - {each.target.id}
            parts = [test.elt, *(each for one in test.generators for each in one.ifs)]
            names = self.depend_on(parts, inner, depth)
        finally:
            self.stored = stored
        return None if names is None else found | names

    def _of_variable(self, name: str, frame: Frame) -> set[str] | None:
        """Return what a variable depends on: itself, if other functions change it."""
        value = self.variable(name, frame)
        if name in frame.names:
            is_shared = frame.function is not None and name in shared(frame.function)
            outer: Frame | None = frame
        else:
            outer = frame.outer
            while outer is not None and name not in outer.names and outer.holder is None:
                outer = outer.outer
            holder = None if outer is None else outer.holder
            slot = None if holder is None else holder.slots.get(name)
            is_shared = slot is not None and len(slot.values) > 1
        if is_shared and outer is not None:
            self.has_shared = True
            return {shared_name(name, outer)}
        is_kept = name in frame.names.keys() - self.stored
        able = (Const, Outside, Open, OutsideMethod, Text) if is_kept else (Const, Outside)
        return set() if all(isinstance(each, able) for each in options(value)) else None

    def depend_on(self, tests: Iterable[ast.AST], frame: Frame, depth: int) -> set[str] | None:
        """Return the attributes and events on which the values of tests depend; None: on something else."""
        found: set[str] = set()
        for test in tests:
            names = self.depends_on(test, frame, depth)
            if names is None:
                return None
            found |= names
        return found

    def _of_attribute(self, test: ast.Attribute, frame: Frame, depth: int) -> set[str] | None:
        value = self.alone(test.value, frame)
        if isinstance(value, Object):
            found = self.look_up(value.cls, test.attr)
            if isinstance(found, Function):
                return self._of_function(Bound(found, value), depth)
            inner = (
                self.depends_on(test.value, frame, depth) if isinstance(test.value, ast.Attribute) else set()
            )
            self.asked.append((value, test.attr))
            return None if inner is None else {*inner, test.attr}
        if isinstance(value, Outside):
            return set()  # a constant of a library
        if isinstance(value, Goal) and test.attr == "is_cancel_requested":
            return {CANCEL}
        if self._is_message(test, frame):
            return set()
        if isinstance(value, Open):
            return None
        return self.depends_on(test.value, frame, depth)

    def _is_message(self, test: ast.expr, frame: Frame) -> bool:
        """Return whether an expression is a message that nothing changes, or a field of one."""
        name = ""
        while isinstance(test, (ast.Attribute, ast.Subscript)):
            name = test.attr if isinstance(test, ast.Attribute) else name
            test = test.value
        value = frame.names.get(test.id) if isinstance(test, ast.Name) else None
        return isinstance(value, (Message, Response)) or (isinstance(value, Goal) and name == "request")

    def _of_call(self, test: ast.Call, frame: Frame, depth: int) -> set[str] | None:
        if isinstance(test.func, ast.Attribute) and test.func.attr == "done":
            futures = [each for each in options(self.evaluate(test.func.value, frame)) if not is_none(each)]
            if futures and all(isinstance(each, Future) and each.effect is not None for each in futures):
                return set()  # the effect says how the code waits
        function = self.alone(test.func, frame)
        if not isinstance(function, Bound) and asks_for_shutdown(test):
            return set()  # it ends at shutdown
        if isinstance(function, Outside) and function.path.removeprefix("builtins.") in _ASK:
            return self.depend_on(test.args, frame, depth)
        if isinstance(function, Bound) and not test.args and not test.keywords:
            return self._of_function(function, depth)
        if not isinstance(function, OutsideMethod) or not isinstance(test.func, ast.Attribute):
            return None
        value = function.instance
        asks = f".{value.path.rpartition('.')[2]}.{test.func.attr}" if isinstance(value, Made) else ""
        if isinstance(value, Made) and asks in (".Event.is_set", ".Future.done"):
            return {value.name or value.path}
        if isinstance(value, (Items, Mapping)) and test.func.attr in _LOOK:
            return self.depend_on([test.func.value, *test.args], frame, depth)
        return None

    def _of_function(self, bound: Bound, depth: int) -> set[str] | None:
        """Return what the result of a method depends on that only returns an expression."""
        function = bound.function
        body = [each for each in getattr(function.node, "body", []) if not _is_text(each)]
        wanted = function.node.args.args
        if len(body) != 1 or not isinstance(body[0], ast.Return) or body[0].value is None or not wanted:
            return None
        names = {wanted[0].arg: bound.instance}
        inner = Frame(
            function.frame.module, names, function.frame, function=function, instance=bound.instance
        )
        return self.depends_on(body[0].value, inner, depth - 1) if depth else None


def _is_text(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)
