"""Runs loops: turn by turn if these are known, or else once for any number of turns."""

from __future__ import annotations

import ast
from collections.abc import Callable

from dineros.sources.branches import Anything, Condition, Loop, Turns
from dineros.sources.facts import TRANSFORM, Item
from dineros.sources.language.computing.operations import Verdict
from dineros.sources.language.endings import (
    TRANSFORMS,
    asks_for_shutdown,
    exits_of,
    may_give_up,
    runs_callbacks,
    waits_for,
    why_endless,
)
from dineros.sources.language.machine import BREAKS, CONTINUES, FALLS, RAISES, RETURNS
from dineros.sources.language.modules import text_of_code
from dineros.sources.language.running.carrying import MOST_TURNS_AGAIN, Carried
from dineros.sources.language.running.decorating import Decorating
from dineros.sources.language.running.matching import merge
from dineros.sources.language.running.pacing import pace_of, published_in
from dineros.sources.language.values import (
    Const,
    Frame,
    Future,
    Made,
    Open,
    Value,
    join,
    options,
)


class Repeating(Decorating):
    """The part of the interpreter that runs loops."""

    def tested(self, test: ast.expr, frame: Frame) -> tuple[Verdict, Condition]:
        """Evaluate the test of a statement; return its verdict, and its condition."""
        with self.block() as before:
            verdict = self.decide(test, frame)
        if verdict[0] is not None and not verdict[1]:
            self.activity.block += before
            return verdict, Anything()
        return verdict, self.condition(test, frame, before)

    def _run_For(self, node: ast.For | ast.AsyncFor, frame: Frame) -> set[str]:  # noqa: N802
        values, is_exact = self.turns(self.drawn(self.evaluate(node.iter, frame), node.iter, frame))
        if is_exact and not values:
            return self.execute(node.orelse, frame)
        if is_exact:
            return self._turns(node, values, frame)
        value = join([*values, Open(text_of_code(node.target))])

        def begin() -> None:
            self.assign(node.target, value, frame)

        found = self._open_loop(node.body, frame, begin) | {FALLS}
        if node.orelse:
            self.activity.is_lost = True
        return found

    _run_AsyncFor = _run_For  # noqa: N815

    def _turns(self, node: ast.For | ast.AsyncFor, values: list[Value], frame: Frame) -> set[str]:
        ends: set[str] = set()
        count = 0
        done = Turns([])
        self.activity.block.append(done)
        try:
            for index, value in enumerate(values):
                with self.each(index), self.block() as turn:
                    done.turns.append(turn)
                    self.assign(node.target, value, frame)
                    found = self.execute(node.body, frame)
                ends |= found - {FALLS, CONTINUES}
                if not found & {FALLS, CONTINUES}:
                    break
                if found & {RETURNS, BREAKS, RAISES}:
                    self.activity.conditional += 1
                    count += 1
            else:
                ends |= {FALLS}
        finally:
            self.activity.conditional -= count
        if BREAKS in ends:
            ends = (ends - {BREAKS}) | {FALLS}
            self.activity.is_lost |= bool(node.orelse)
        elif node.orelse and FALLS in ends:
            ends = (ends - {FALLS}) | self.execute(node.orelse, frame)
        return ends

    def _run_While(self, node: ast.While, frame: Frame) -> set[str]:  # noqa: N802
        changed = _assigned(node.body)
        self._forget(changed, frame)
        self.activity.loops += 1
        (verdict, origin), condition = self.tested(node.test, frame)
        self.activity.loops -= 1
        self.activity.is_lost |= bool(node.orelse)
        self._polls(node, frame)
        self._repeats(node, frame)
        if verdict is False and not origin:
            return self.execute(node.orelse, frame)
        asked = {each.id for each in ast.walk(node.test) if isinstance(each, ast.Name)}
        is_endless = verdict is True and not origin and not asked & changed
        why = why_endless(node, self.never(node, frame)) if is_endless or asks_for_shutdown(node.test) else ""
        loop = self.effect("loop", f"while {_text(node.test)}", node, frame, why)
        before = len(self.attributes.changed)
        found = self._open_loop(node.body, frame, lambda: None, condition, is_entered=is_endless)
        turn = self.activity.block[-1]
        if isinstance(turn, Loop):
            loop.pace = pace_of(turn.body)
            loop.turn = tuple(published_in(turn.body)) if loop.pace is not None else ()
        self._awaits(node, frame)
        effects = self.activity.fact.effects
        spins = any(each.do.startswith("spin") for each in effects[effects.index(loop) :])
        if loop.order and (spins or any(each.spun > loop.order for each in self.nodes)):
            loop.how = ""  # it runs callbacks
        self.polls(node, frame, loop, condition, before)
        ends = found & {RETURNS, RAISES}
        if not is_endless or BREAKS in found:
            ends |= {FALLS}
        if node.orelse and not is_endless:
            ends |= self.execute(node.orelse, frame)
        return ends

    def _awaits(self, node: ast.While, frame: Frame) -> None:
        """Record that a loop repeats a wait for a server until it is there."""
        method = waits_for(node, never=self.never(node, frame))
        at = None if method is None else self.place(method, frame)
        for effect in self.activity.fact.effects:
            if effect.at == at and effect.do.startswith("wait_for_"):
                effect.is_repeated = True

    def _repeats(self, node: ast.While, frame: Frame) -> None:
        """Record that a loop repeats a wait for a transform until it is there."""
        asked = waits_for(node, TRANSFORMS, self.never(node, frame))
        if asked is None or isinstance(asked.value, ast.Call) or runs_callbacks(node):
            return  # spinning in the loop may receive it
        for value in options(self.evaluate(asked.value, frame)):
            if isinstance(value, Made) and value.path.endswith("Buffer"):
                self.effect("wait", TRANSFORM, node, frame, "polled, without time-out").is_repeated = True

    def _polls(self, node: ast.While, frame: Frame) -> None:
        """Record that a loop waits for a future that it tests repeatedly: in its test, or in its ways out."""
        never = self.never(node, frame)
        exits = [] if runs_callbacks(node) else exits_of(node, never) or []
        for test in (node.test, *(each for each in exits if each is not node.test)):
            others = [each for each in exits if each is not test and not _only_runs(each)]
            gives_up = (
                may_give_up(node, never) if test is node.test else bool(others) or _has_alternative(test)
            )
            for each in ast.walk(test):
                if (
                    isinstance(each, ast.Call)
                    and isinstance(each.func, ast.Attribute)
                    and each.func.attr == "done"
                ):
                    for value in options(self.evaluate(each.func.value, frame)):
                        effect = value.effect if isinstance(value, Future) else None
                        is_own = test is node.test or effect in self.activity.fact.effects
                        if effect is not None and is_own:
                            effect.how = "polled, time-out open" if gives_up else "polled"

    def _open_loop(
        self,
        body: list[ast.stmt],
        frame: Frame,
        begin: Callable[[], None],
        condition: Condition | None = None,
        *,
        is_entered: bool = False,
    ) -> set[str]:
        """Run the body of a loop with unknown iterations: changed variables may have any value."""
        before = dict(frame.names)
        self._forget(_assigned(body), frame)
        activity = self.activity
        activity.loops += 1
        activity.conditional += not is_entered
        first = Carried(body, frame)
        try:
            turn, ends = self._turn(body, frame, begin)
            if self.turns_again < MOST_TURNS_AGAIN and first.matters():
                self.turns_again += 1
                turn, later = self._turn(body, frame, begin)
                self.turns_again -= 1
                ends |= later
        finally:
            activity.loops -= 1
            activity.conditional -= not is_entered
        activity.block.append(Loop(condition or Anything(), turn, is_entered))
        merge(frame, [dict(frame.names)] if is_entered else [before, dict(frame.names)], before)
        return ends

    def _turn(
        self, body: list[ast.stmt], frame: Frame, begin: Callable[[], None]
    ) -> tuple[list[Item], set[str]]:
        """Run the body of a loop once; return what it does, and how it may end."""
        with self.block() as turn:
            begin()
            ends = self.execute(body, frame)
        return turn, ends

    def _forget(self, names: frozenset[str], frame: Frame) -> None:
        """Mark a constant that a loop changes as open, before the first iteration."""
        for name in names:
            value = frame.names.get(name)
            if isinstance(value, Const) and value.value is not None:
                frame.names[name] = Open(name)


def _assigned(body: list[ast.stmt]) -> frozenset[str]:
    """Return the names that the statements of a loop assign."""
    found: frozenset[str] | None = getattr(body[0], "assigned_from_here", None)
    if found is None:
        inner = (each for statement in body for each in ast.walk(statement))
        found = frozenset(
            each.id for each in inner if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)
        )
        body[0].assigned_from_here = found  # type: ignore[attr-defined]
    return found


def _only_runs(test: ast.expr) -> bool:
    """Return whether the test of a loop only requires that ROS runs."""
    return asks_for_shutdown(test) or (isinstance(test, ast.Constant) and bool(test.value))


def _has_alternative(test: ast.expr) -> bool:
    """Return whether a way out may be taken although the future in its test is not done."""
    return isinstance(test, ast.BoolOp) and isinstance(test.op, ast.Or)


def _text(node: ast.expr) -> str:
    text = text_of_code(node)
    return text if len(text) <= 60 else f"{text[:57]}..."
