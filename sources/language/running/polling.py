"""Recognises loops that wait until other code changes an attribute, as in ``while not self.ready``."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from dineros.sources.branches import Compared, Condition, parts
from dineros.sources.facts import CallbackFact, Effect
from dineros.sources.language.endings import asks_for_shutdown, exits_of, runs_callbacks
from dineros.sources.language.machine import EVENT
from dineros.sources.language.modules import Modules
from dineros.sources.language.running.asking import CANCEL, Asking
from dineros.sources.language.running.progress import is_quiet, makes_progress, sleeps_itself, stored_names
from dineros.sources.language.values import (
    SETTINGS,
    Const,
    Frame,
    Object,
    Open,
)
from dineros.sources.unknown_ends import ONE_VALUE, UNKNOWN_END

POLLED = "polled, without time-out"
_QUIET = ("sleep", "loop", "publish", "publish_feedback", "log")
"""What the body of such a loop does; anything else says by itself what it waits for."""


@dataclass(frozen=True)
class Poll:
    """A loop of a callback that ends only when an attribute changes, or an event."""

    fact: CallbackFact
    wait: Effect
    loop: Effect
    """`wait`, `loop`: what it waits for, and the loop."""
    why: str
    """Why the loop seems endless, if nothing changes what it tests."""
    names: frozenset[str]
    """The attributes, and the names of events."""
    test: Condition | None
    """The test of the loop, if that is its only exit."""
    asked: list[tuple[Object, str]]
    """The attributes with their objects; empty if it asks for other variables, too."""
    goes_on: bool | None
    """Whether the loop continues with the present values; False: it never begins."""
    is_quiet: bool
    """Whether its body only sleeps, publishes and writes into the log: no exception is its end."""
    sleeps_until: bool
    """Whether it only sleeps until something happens."""


class Polling(Asking):
    """The part of the interpreter that recognises loops that wait for attributes."""

    def __init__(self, modules: Modules, program: str) -> None:
        super().__init__(modules, program)
        self.found: list[Poll] = []
        """What was recognised."""

    def polls(self, node: ast.While, frame: Frame, loop: Effect, condition: Condition, before: int) -> None:
        """Record that a loop waits for attributes that it does not change itself.

        Parameters
        ----------
        node : ast.While
            The loop, whose body has been read.
        frame : Frame
            Its variables.
        condition : Condition
            Its test.
        before : int
            Number of changes of attributes before its body.
        """
        fact, tests = self.activity.fact, exits_of(node, self.never(node, frame))
        if fact.kind in ("main", "module", "constructor", "thread", EVENT) or tests is None:
            return
        changes = self.attributes.changed[before:]
        self.asked, self.stored, self.has_shared = [], stored_names(node), False
        names, sleeps_until = self.depend_on(tests, frame, 3), self._sleeps_until(node, loop, tests)
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
        asked = [] if self.has_shared else self.asked
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
        """Return whether a loop continues, with the values that attributes have in the whole program.

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


def _conjuncts(test: ast.expr) -> list[ast.expr]:
    return test.values if isinstance(test, ast.BoolOp) and isinstance(test.op, ast.And) else [test]


_OF_LOCALS = (
    *(ast.Name, ast.Constant, ast.Compare, ast.UnaryOp, ast.BoolOp),
    *(ast.expr_context, ast.cmpop, ast.unaryop, ast.boolop),
)


def add_setters(machine: Polling, is_known: Callable[[Object, str], bool]) -> None:
    """Give each callback that changes what a loop polls an effect that says so.

    A wait that asks only for variables says which: a model may have them. A loop whose attributes have one
    value in the whole program says that it never ends.

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
        if not setters or is_endless or is_off:
            poll.fact.effects.remove(poll.wait)
            continue
        compared = [each for each in asked if isinstance(each, Compared) and id(each.variable) in kept]
        if len(compared) == len(asked):
            poll.wait.variables = tuple(dict.fromkeys(each.variable for each in compared))
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
