"""Runs statements: assignments, their order, and the possible ends of statements."""

from __future__ import annotations

import ast
import copy

from dineros.sources.branches import Attempt, Branch, Leave
from dineros.sources.language.attributes import Written
from dineros.sources.language.machine import BREAKS, CONTINUES, FALLS, RAISES, RETURNS
from dineros.sources.language.modules import text_of_code
from dineros.sources.language.running.loops import Repeating
from dineros.sources.language.running.matching import merge
from dineros.sources.language.values import (
    SETTINGS,
    Const,
    Frame,
    Future,
    Items,
    Made,
    Object,
    Open,
    Value,
    join,
    options,
)

_NAMES = {each: f"_run_{each.__name__}" for each in ast.stmt.__subclasses__()}
"""Names of the methods that run statements."""
_LEAVES = {RETURNS, RAISES, BREAKS, CONTINUES}


class Statements(Repeating):
    """The part of the interpreter that runs statements."""

    def execute(self, body: list[ast.stmt], frame: Frame) -> set[str]:
        """Run statements; those after a possible exit may be executed."""
        ends: set[str] = set()
        count = 0
        try:
            for statement in body:
                self.step()
                method = getattr(self, _NAMES[type(statement)], None)
                found = {FALLS} if method is None else method(statement, frame)
                ends |= found - {FALLS}
                if FALLS not in found:
                    return ends
                if found & _LEAVES:
                    self.activity.conditional += 1
                    count += 1
        finally:
            self.activity.conditional -= count
        return ends | {FALLS}

    # ------------------------------------------------------------------------------------------------- values

    def _run_Expr(self, node: ast.Expr, frame: Frame) -> set[str]:  # noqa: N802
        self.unused = node.value
        value = self.evaluate(node.value, frame)
        for each in options(value):
            if isinstance(each, Future) and each.effect is not None and each.effect.how == "async":
                each.effect.how = "async and ignored"
        call = node.value
        if isinstance(call, ast.Call) and text_of_code(call.func) in ("sys.exit", "exit", "quit", "os._exit"):
            return self._leave(RAISES)
        return {FALLS}

    def _run_Assign(self, node: ast.Assign, frame: Frame) -> set[str]:  # noqa: N802
        value = self.evaluate(node.value, frame)
        for target in node.targets:
            self.assign(target, value, frame, node.value)
        return {FALLS}

    def _run_AnnAssign(self, node: ast.AnnAssign, frame: Frame) -> set[str]:  # noqa: N802
        if node.value is not None:
            self.assign(node.target, self.evaluate(node.value, frame), frame, node.value)
        return {FALLS}

    def _run_AugAssign(self, node: ast.AugAssign, frame: Frame) -> set[str]:  # noqa: N802
        before, value = self.evaluate(_loaded(node.target), frame), self.evaluate(node.value, frame)
        if isinstance(before, Items) and isinstance(node.op, ast.Add):
            values, is_exact = self.turns(value)
            before.items += values
            before.is_open |= not is_exact
            return {FALLS}
        of_class = self.augmented(node.op, before, value, node, frame)
        if of_class is not None:
            self.assign(node.target, of_class, frame)
            return {FALLS}
        found = self.combined(node.op, before, value, text_of_code(node.target))
        is_counted = isinstance(node.target, ast.Attribute) or self.activity.loops or self.run
        if is_counted and isinstance(found, Const) and not isinstance(found.value, str):
            found = Open(text_of_code(node.target))
        self.assign(node.target, found, frame)
        return {FALLS}

    def _run_Delete(self, node: ast.Delete, frame: Frame) -> set[str]:  # noqa: N802
        for target in node.targets:
            self.changes_attribute(target)
            if isinstance(target, ast.Name):
                self.special(self.evaluate(_loaded(target), frame), "__del__", [], target, frame)
            elif isinstance(target, ast.Attribute):
                self.delete_attribute(self.evaluate(target.value, frame), target.attr, target, frame)
            elif isinstance(target, ast.Subscript):
                held, key = self.evaluate(target.value, frame), self.evaluate(target.slice, frame)
                self.special(held, "__delitem__", [key], target, frame)
        return {FALLS}

    # -------------------------------------------------------------------------------------------- definitions

    def _run_FunctionDef(self, node: ast.FunctionDef | ast.AsyncFunctionDef, frame: Frame) -> set[str]:  # noqa: N802
        owner = getattr(frame, "cls", None)
        function = self.function(node, frame, owner)
        parts = (f"{node.name}.setter", f"{node.name}.deleter")
        name = next((each for each in function.decorators if each in parts), node.name)
        self.assign_variable(name, self.decorated(function, node, frame), frame)
        if owner is None and any(self._registers(each, frame) for each in node.decorator_list):
            self.escape(function)
        return {FALLS}

    def _registers(self, decorator: ast.expr, frame: Frame) -> bool:
        """Return whether a decorator gives a function to an object of a library: ``@app.route("/")``."""
        named = decorator.func if isinstance(decorator, ast.Call) else decorator
        if not isinstance(named, ast.Attribute):
            return False
        return any(isinstance(each, (Made, Open)) for each in options(self.evaluate(named.value, frame)))

    _run_AsyncFunctionDef = _run_FunctionDef  # noqa: N815

    def _run_Global(self, node: ast.Global, frame: Frame) -> set[str]:  # noqa: N802
        frame.globals |= set(node.names)
        return {FALLS}

    def _run_Nonlocal(self, node: ast.Nonlocal, frame: Frame) -> set[str]:  # noqa: N802
        frame.nonlocals |= set(node.names)
        return {FALLS}

    def _run_Return(self, node: ast.Return, frame: Frame) -> set[str]:  # noqa: N802
        self.gives_to_rclpy(node.value)
        frame.returns.append(Const(None) if node.value is None else self.evaluate(node.value, frame))
        self.returns(node.value, frame)
        return self._leave(RETURNS)

    def _leave(self, way: str) -> set[str]:
        self.activity.block.append(Leave(way))
        return {way}

    def _run_Raise(self, node: ast.Raise, frame: Frame) -> set[str]:  # noqa: N802
        if node.exc is not None:
            self.raised += [
                each for each in options(self.evaluate(node.exc, frame)) if isinstance(each, Object)
            ]
            call = node.exc.func if isinstance(node.exc, ast.Call) else node.exc
            if self.activity.fact.effects:  # it has already had effects: not a check of its arguments
                self.effect("raise", text_of_code(call), node, frame)
        return self._leave(RAISES)

    def _run_Break(self, _node: ast.Break, _frame: Frame) -> set[str]:  # noqa: N802
        return self._leave(BREAKS)

    def _run_Continue(self, _node: ast.Continue, _frame: Frame) -> set[str]:  # noqa: N802
        return self._leave(CONTINUES)

    def _run_Assert(self, node: ast.Assert, frame: Frame) -> set[str]:  # noqa: N802
        self.evaluate(node.test, frame)
        if node.msg is not None:
            with self.perhaps():
                self.evaluate(node.msg, frame)
        return {FALLS}

    # ----------------------------------------------------------------------------------------------- branches

    def _run_If(self, node: ast.If, frame: Frame) -> set[str]:  # noqa: N802
        (verdict, origin), condition = self.tested(node.test, frame)
        if verdict is not None and not origin:
            if frame.function is None and "__name__" not in text_of_code(node.test):
                self._is_dead(node.orelse if verdict else node.body, frame)
            return self.execute(node.body if verdict else node.orelse, frame)
        done = Branch(condition, [], [])
        self.activity.block.append(done)
        is_setting = origin.startswith(SETTINGS)
        before = dict(frame.names)
        after: list[dict[str, Value]] = []
        off: dict[str, Value] = {}
        goes_on = False
        ways: list[Written] = []
        ends: set[str] = set()
        parts = [(True, node.body), (False, node.orelse)]
        if is_setting:
            parts.sort(key=lambda part: part[0] is verdict)  # branches not taken by default come first
        for is_body, body in parts:
            frame.names.clear()
            frame.names.update(before)
            is_off = is_setting and verdict is not is_body
            count = len(frame.returns)
            with self.perhaps(is_disabled=is_off, is_kept=True, ways=ways) as block:
                found = self.execute(body, frame)
            (done.then if is_body else done.otherwise).extend(block)
            if is_off:
                off = dict(frame.names)  # useful if the same setting is tested again
                if found != {FALLS}:
                    del frame.returns[count:]
                goes_on = FALLS in found
                continue
            ends |= found
            if FALLS in found:
                after.append(dict(frame.names))
        if ends == {RAISES} and goes_on:  # without the setting, the program only says that it is missing
            ends, after = {FALLS}, [off]
        self.merge_slots(ways, has_rest=False)
        merge(frame, after, before)
        for name, value in off.items():
            frame.names.setdefault(name, value)
        return ends

    def _is_dead(self, body: list[ast.stmt], frame: Frame) -> None:
        """Record that a module never runs these statements: the model lacks nothing of them."""
        calls = (each for part in body for each in ast.walk(part) if isinstance(each, ast.Call))
        lines = (each.func.end_lineno or each.lineno for each in calls)
        self.modules.reached.update((frame.module.path, line) for line in lines)

    def _run_Try(self, node: ast.Try, frame: Frame) -> set[str]:  # noqa: N802
        before = dict(frame.names)
        first = len(self.raised)
        done = Attempt([], [])
        self.activity.block.append(done)
        with self.block() as done.body:
            ends = self.execute(node.body, frame)
        if FALLS in ends:
            with self.block() as done.otherwise:
                ends = (ends - {FALLS}) | self.execute(node.orelse, frame)
        after = [dict(frame.names)] if FALLS in ends else []
        if node.handlers:
            ends.discard(RAISES)
        for handler in node.handlers:
            merge(frame, [before, *after], before)
            with self.perhaps(is_kept=True) as block:
                if handler.type is not None:
                    self.evaluate(handler.type, frame)
                if handler.name:
                    caught = join([Open(handler.name), *self.raised[first:]])
                    self.assign_variable(handler.name, caught, frame)
                found = self.execute(handler.body, frame)
            done.handlers.append(block)
            # A handler with an exit ends the code that runs only after an error.
            ends |= found if FALLS in found or FALLS not in ends else set()
            if FALLS in found:
                after.append(dict(frame.names))
        merge(frame, after, before)
        with self.block() as done.last:
            last = self.execute(node.finalbody, frame)
        return ends if FALLS in last else last

    _run_TryStar = _run_Try  # noqa: N815

    def _run_With(self, node: ast.With | ast.AsyncWith, frame: Frame) -> set[str]:  # noqa: N802
        activity = self.activity
        held = len(activity.holding)
        entered: list[Value] = []
        for item in node.items:
            before = len(activity.acquired)
            value = self.evaluate(item.context_expr, frame)
            activity.holding += activity.acquired[before:]  # by a function with `contextmanager`
            text = text_of_code(item.context_expr)
            if "suppress" in text:
                activity.is_lost = True
            inner = self.library.enter(value, text, node, frame)
            entered.append(value)
            if item.optional_vars is not None:
                self.assign(item.optional_vars, inner, frame)
        try:
            return self.execute(node.body, frame)
        finally:
            for value in reversed(entered):
                self.library.leave(value, node, frame)
            del activity.holding[held:]

    _run_AsyncWith = _run_With  # noqa: N815


def _loaded(target: ast.expr) -> ast.expr:
    """Return the expression that reads what a target names."""
    load = copy.copy(target)
    load.ctx = ast.Load()  # type: ignore[attr-defined]
    return load
