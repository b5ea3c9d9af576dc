"""Recognises loops that wait until other code changes an attribute, as in ``while not self.ready``."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from dineros.sources.branches import Compared, Condition, parts
from dineros.sources.facts import CallbackFact, Effect
from dineros.sources.language.endings import asks_for_shutdown, exits_of, runs_callbacks
from dineros.sources.language.expressions import shared, shared_name
from dineros.sources.language.machine import EVENT
from dineros.sources.language.modules import Modules
from dineros.sources.language.running.matching import Matching
from dineros.sources.language.running.progress import is_quiet, makes_progress, sleeps_itself, stored_names
from dineros.sources.language.values import (
    SETTINGS,
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
from dineros.sources.unknown_ends import ONE_VALUE, UNKNOWN_END

POLLED = "polled, without time-out"
_QUIET = ("sleep", "loop", "publish", "publish_feedback", "log")
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
    asked : list of (Object, str)
        The attributes with their objects; empty if it asks for other variables, too.
    goes_on : bool or None
        Whether the loop goes on with the present values; False: it never begins.
    is_quiet : bool
        Whether its body only sleeps, publishes and writes into the log: no exception is its end.
    sleeps_until : bool
        Whether it only sleeps until something happens.
    """

    fact: CallbackFact
    wait: Effect
    loop: Effect
    why: str
    names: frozenset[str]
    test: Condition | None
    asked: list[tuple[Object, str]]
    goes_on: bool | None
    is_quiet: bool
    sleeps_until: bool


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
        self._polled: list[tuple[Object, str]] = []
        self._stored: frozenset[str] = frozenset()
        self._has_shared = False

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
        self._polled, self._stored, self._has_shared = [], stored_names(node), False
        names, sleeps_until = self._all(tests, frame, 3), self._sleeps_until(node, loop, tests)
        is_unknown = names is None or (not names and self._asks_open(tests, frame))
        if is_unknown and sleeps_until:
            self.effect("wait", f"the end of the loop {loop.what}", node, frame, UNKNOWN_END)
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
        asked = [] if self._has_shared else self._polled
        self.found.append(
            Poll(
                *(fact, wait, loop, loop.how, frozenset(names), test, asked),
                *(self._goes_on(node, tests, frame), is_quiet(node), sleeps_until),
            )
        )
        loop.how = ""

    def _asks_open(self, tests: Iterable[ast.expr], frame: Frame) -> bool:
        """Return whether tests ask for a local variable with a value that is not known."""
        names = {each.id for test in tests for each in ast.walk(test) if isinstance(each, ast.Name)}
        return any(isinstance(frame.names.get(name), Open) for name in names)

    def _goes_on(self, node: ast.While, tests: Iterable[ast.expr], frame: Frame) -> bool | None:
        """Return whether a loop goes on, with the values that attributes have in the whole program.

        True: no test ends it; False: it never begins; None: not known.
        """
        for test in tests:
            is_own = test is node.test
            for each in _conjuncts(test) if is_own else [test]:
                if asks_for_shutdown(each):
                    continue
                verdict, origin = self.decide(each, frame)
                if verdict is not is_own or origin.startswith(SETTINGS):
                    return False if is_own and verdict is False and not origin.startswith(SETTINGS) else None
        return True

    def _sleeps_until(self, node: ast.While, loop: Effect, tests: Iterable[ast.expr]) -> bool:
        """Return whether a loop only sleeps until something happens.

        Loops that also wait for something else, that run callbacks, or that time or a variable that they
        change ends, do not count.
        """
        effects = self.activity.fact.effects
        inner = effects[effects.index(loop) + 1 :]
        return (
            not loop.how
            and any(each.do == "sleep" for each in inner)
            and sleeps_itself(node)
            and all(each.do in _QUIET for each in inner)
            and not runs_callbacks(node)
            and not makes_progress(node, tests)
        )

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
            return self._of_variable(test.id, frame)
        if isinstance(test, _PARTS):
            return self._all(ast.iter_child_nodes(test), frame, depth)
        if isinstance(test, ast.Attribute):
            return self._of_attribute(test, frame, depth)
        return self._of_call(test, frame, depth) if isinstance(test, ast.Call) and depth else None

    def _of_variable(self, name: str, frame: Frame) -> set[str] | None:
        """Return what a variable depends on: itself, if other functions change it."""
        value = self.variable(name, frame)
        if name in frame.names:
            is_shared = frame.function is not None and name in shared(frame.function)
            outer: Frame | None = frame
        else:
            outer = frame.outer
            while outer is not None and name not in outer.names and self.holder_of(outer) is None:
                outer = outer.outer
            holder = None if outer is None else self.holder_of(outer)
            slot = None if holder is None else holder.slots.get(name)
            is_shared = slot is not None and len(slot.values) > 1
        if is_shared and outer is not None:
            self._has_shared = True
            return {shared_name(name, outer)}
        is_kept = name in frame.names.keys() - self._stored
        able = (Const, Outside, Open, OutsideMethod, Text) if is_kept else (Const, Outside)
        return set() if all(isinstance(each, able) for each in options(value)) else None

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
            self._polled.append((value, test.attr))
            return None if inner is None else {*inner, test.attr}
        if isinstance(value, Outside):
            return set()  # a constant of a library
        if isinstance(value, Goal) and test.attr == "is_cancel_requested":
            return {CANCEL}
        if self._is_message(test, frame):
            return set()
        if isinstance(value, Open):
            return None
        return self._depends_on(test.value, frame, depth)

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


def add_setters(machine: Polling, is_known: Callable[[Object, str], bool]) -> None:
    """Give each callback that changes what a loop polls an effect that says so.

    Waits that the model itself has, by variables, are left out. A loop whose attributes have one value in the
    whole program says that it never ends.

    Parameters
    ----------
    machine : Polling
        The interpreter, at the end of the program.
    is_known : callable
        Whether only code that was followed sets an attribute of an object.
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
        is_certain = bool(poll.asked) and all(
            is_known(holder, name) and _has_one_value(holder, name) for holder, name in poll.asked
        )
        is_endless = is_certain and poll.goes_on is True
        is_off = is_certain and poll.goes_on is False and not setters
        is_unknown = not setters and not is_endless and poll.sleeps_until
        if (is_endless and not poll.is_quiet) or (is_unknown and not is_off):
            poll.wait.what, poll.wait.how = f"the end of the loop {poll.loop.what}", UNKNOWN_END
            continue
        if is_endless:
            poll.loop.how = f"{ONE_VALUE} {' or '.join(sorted(poll.names))}"
        elif not setters:
            poll.loop.how = poll.why
        is_variable = asked and all(_is_in(kept, each) for each in asked)
        is_variable = is_variable and all(
            _is_in_model(machine, each) for each in (poll.fact, *setters.values())
        )
        if not setters or is_endless or is_off or is_variable:
            poll.fact.effects.remove(poll.wait)
            continue
        for fact in setters.values():
            if fact is poll.fact:
                continue  # before or after the loop
            fact.effects.append(Effect("notify", poll.wait.what, fact.at, "conditional"))


def _has_one_value(holder: Object, name: str) -> bool:
    slot = holder.slots.get(name)
    if slot is None:
        return True  # of its class
    is_fixed = not slot.is_off and not slot.is_setting
    return is_fixed and len(slot.values) == 1 and isinstance(slot.values[0], Const)


def _is_in_model(machine: Polling, fact: CallbackFact) -> bool:
    """Return whether models have what a callback sets: one entity begins it, which is always there."""
    if fact.kind not in ("subscription", "timer", "service", "execute", "done callback") or fact.body is None:
        return False
    entities = [each for node in machine.nodes for each in node.entities if fact in each.callbacks.values()]
    effects = [
        each
        for callback in machine.callbacks.values()
        for each in callback.fact.effects
        if each.then is fact and each.entity is not None
    ]
    return len(entities) + len(effects) == 1 and not any(
        each.details.get(key) for each in entities for key in ("created_in", "instances", "conditional")
    )


def _is_in(kept: set[int], test: Condition) -> bool:
    return isinstance(test, Compared) and id(test.variable) in kept
