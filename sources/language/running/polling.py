"""Recognises loops that wait until other code changes an attribute, as in ``while not self.ready``."""

from __future__ import annotations

import ast
from collections.abc import Iterable
from dataclasses import dataclass

from dineros.sources.branches import Compared, Condition, parts
from dineros.sources.facts import CallbackFact, Effect
from dineros.sources.language.endings import asks_for_shutdown, exits_of, runs_callbacks
from dineros.sources.language.machine import EVENT
from dineros.sources.language.modules import Modules
from dineros.sources.language.running.matching import Matching
from dineros.sources.language.running.progress import makes_progress, sleeps_itself
from dineros.sources.language.values import (
    Bound,
    Const,
    Frame,
    Function,
    Goal,
    Items,
    Made,
    Mapping,
    Object,
    Outside,
    OutsideMethod,
)
from dineros.sources.unknown_ends import UNKNOWN_END

POLLED = "polled, without time-out"
_QUIET = ("sleep", "loop", "publish", "log")
"""What the body of such a loop does; anything else says by itself what it waits for."""
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


@dataclass(frozen=True)
class Poll:
    """A loop of a callback that ends only when an attribute changes, or an event.

    Attributes
    ----------
    fact : CallbackFact
        The callback.
    wait, loop : Effect
        What it waits for, and the loop.
    why : str
        Why the loop seems endless, if nothing changes what it tests.
    names : frozenset of str
        The attributes, and the names of events.
    test : Condition or None
        The test of the loop, if that is its only exit.
    """

    fact: CallbackFact
    wait: Effect
    loop: Effect
    why: str
    names: frozenset[str]
    test: Condition | None


class Polling(Matching):
    """The part of the interpreter that recognises loops that wait for attributes.

    Attributes
    ----------
    found : list of Poll
        What was recognised.
    """

    def __init__(self, modules: Modules, program: str) -> None:
        super().__init__(modules, program)
        self.found: list[Poll] = []

    def polls(self, node: ast.While, frame: Frame, loop: Effect, condition: Condition, before: int) -> None:
        """Record that a loop waits for attributes that it does not change itself.

        Parameters
        ----------
        node : ast.While
            The loop, whose body has been read.
        frame : Frame
            Its variables.
        loop : Effect
            Its effect.
        condition : Condition
            Its test.
        before : int
            Number of changes of attributes before its body.
        """
        fact, tests = self.activity.fact, exits_of(node, self.never(node, frame))
        if fact.kind in ("main", "module", "constructor", "thread", EVENT) or tests is None:
            return
        changes = self.attributes.changed[before:]
        names = self._all(tests, frame, 3)
        if names is None:
            self._waits_for_unknown(node, frame, loop, tests)
        if not names or any(name in names for name, _ in changes) or runs_callbacks(node):
            return
        inner = fact.effects[fact.effects.index(loop) + 1 :]
        if any(
            each.do.startswith("spin") or (loop.how and each.do not in ("sleep", "loop", "wait"))
            for each in inner
        ):
            return  # it runs callbacks; or it does something and may end at once, and `how` says enough
        words = " or ".join(sorted(names))
        wait = self.effect("wait", words, node, frame, POLLED)
        test = condition if len(tests) == 1 else None
        self.found.append(Poll(fact, wait, loop, loop.how, frozenset(names), test))
        loop.how = ""

    def _waits_for_unknown(
        self, node: ast.While, frame: Frame, loop: Effect, tests: Iterable[ast.expr]
    ) -> None:
        """Record that a loop sleeps until something happens that is not known.

        Loops that also wait for something else, that run callbacks, or that time or a variable that they
        change ends, are left alone.
        """
        effects = self.activity.fact.effects
        inner = effects[effects.index(loop) + 1 :]
        if loop.how or not any(each.do == "sleep" for each in inner) or not sleeps_itself(node):
            return
        if (
            any(each.do not in _QUIET for each in inner)
            or runs_callbacks(node)
            or makes_progress(node, tests)
        ):
            return
        self.effect("wait", f"the end of the loop {loop.what}", node, frame, UNKNOWN_END)

    def never(self, node: ast.While, frame: Frame) -> frozenset[ast.If]:
        """Return the branches of a loop that are never taken, as with an argument ``timeout=None``."""
        return frozenset(
            each
            for statement in node.body
            for each in ast.walk(statement)
            if isinstance(each, ast.If) and any(self._is_never(one, frame) for one in _conjuncts(each.test))
        )

    def _is_never(self, test: ast.expr, frame: Frame) -> bool:
        """Return whether a test is certainly false: it asks for local variables only."""
        parts_ = list(ast.walk(test))
        names = {each.id for each in parts_ if isinstance(each, ast.Name)}
        is_plain = all(isinstance(each, _OF_LOCALS) for each in parts_) and names <= frame.names.keys()
        return bool(names) and is_plain and self.decide(test, frame) == (False, "")

    def _depends_on(self, test: ast.AST, frame: Frame, depth: int) -> set[str] | None:
        """Return the attributes and events on which the value of a test depends; None: on something else."""
        if isinstance(test, ast.Constant):
            return set()
        if isinstance(test, ast.Name):
            value = self.variable(test.id, frame)
            return set() if isinstance(value, (Const, Outside)) else None
        if isinstance(test, _PARTS):
            return self._all(ast.iter_child_nodes(test), frame, depth)
        if isinstance(test, ast.Attribute):
            return self._of_attribute(test, frame, depth)
        return self._of_call(test, frame, depth) if isinstance(test, ast.Call) and depth else None

    def _all(self, tests: Iterable[ast.AST], frame: Frame, depth: int) -> set[str] | None:
        found: set[str] = set()
        for test in tests:
            names = self._depends_on(test, frame, depth)
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
                self._depends_on(test.value, frame, depth) if isinstance(test.value, ast.Attribute) else set()
            )
            return None if inner is None else {*inner, test.attr}
        if isinstance(value, Outside):
            return set()  # a constant of a library
        if isinstance(value, Goal) and test.attr == "is_cancel_requested":
            return {CANCEL}
        return self._depends_on(test.value, frame, depth)

    def _of_call(self, test: ast.Call, frame: Frame, depth: int) -> set[str] | None:
        function = self.alone(test.func, frame)
        if not isinstance(function, Bound) and asks_for_shutdown(test):
            return set()  # it ends at shutdown
        if isinstance(function, Outside) and function.path.removeprefix("builtins.") in _ASK:
            return self._all(test.args, frame, depth)
        if isinstance(function, Bound) and not test.args and not test.keywords:
            return self._of_function(function, depth)
        if not isinstance(function, OutsideMethod) or not isinstance(test.func, ast.Attribute):
            return None
        value = function.instance
        asks = f".{value.path.rpartition('.')[2]}.{test.func.attr}" if isinstance(value, Made) else ""
        if isinstance(value, Made) and asks in (".Event.is_set", ".Future.done"):
            return {value.name or value.path}
        if isinstance(value, (Items, Mapping)) and test.func.attr in _LOOK:
            return self._all([test.func.value, *test.args], frame, depth)
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
        return self._depends_on(body[0].value, inner, depth - 1) if depth else None


def _conjuncts(test: ast.expr) -> list[ast.expr]:
    return test.values if isinstance(test, ast.BoolOp) and isinstance(test.op, ast.And) else [test]


_OF_LOCALS = (
    *(ast.Name, ast.Constant, ast.Compare, ast.UnaryOp, ast.BoolOp),
    *(ast.expr_context, ast.cmpop, ast.unaryop, ast.boolop),
)


def _is_text(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)


def add_setters(machine: Polling) -> None:
    """Give each callback that changes what a loop polls an effect that says so.

    Waits that the model itself has, by variables, are left out.
    """
    kept = {id(variable) for node in machine.nodes for variable in node.variables}
    for poll in machine.found:
        if poll.wait not in poll.fact.effects:
            continue  # of the first time that the callback was read
        asked = [] if poll.test is None else list(parts(poll.test))
        setters = {id(fact): fact for name, fact in machine.attributes.changed if name in poll.names}
        if CANCEL in poll.names:
            every = (each.fact for each in machine.callbacks.values())
            setters |= {id(fact): fact for fact in every if fact.kind == "cancel"}
        if not setters:
            poll.loop.how = poll.why
        if not setters or (asked and all(_is_in(kept, each) for each in asked)):
            poll.fact.effects.remove(poll.wait)
            continue
        for fact in setters.values():
            fact.effects.append(Effect("notify", poll.wait.what, fact.at, "conditional"))


def _is_in(kept: set[int], test: Condition) -> bool:
    return isinstance(test, Compared) and id(test.variable) in kept
