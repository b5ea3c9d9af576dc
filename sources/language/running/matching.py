"""Runs ``match`` statements: each case is a branch, whose condition compares the subject with constants."""

from __future__ import annotations

import ast

from dineros.sources.branches import Anything, Branch, Condition, Joined
from dineros.sources.language.assigning import Assignments
from dineros.sources.language.machine import FALLS
from dineros.sources.language.modules import text_of_code
from dineros.sources.language.values import (
    Const,
    Frame,
    Items,
    Mapping,
    Object,
    Open,
    Value,
    join,
    options,
)


class Matching(Assignments):
    """The part of the interpreter that runs ``match`` statements."""

    def _run_Match(self, node: ast.Match, frame: Frame) -> set[str]:  # noqa: N802
        with self.block() as asked:
            value = self.evaluate(node.subject, frame)
        self.activity.block += asked
        subject = None if asked else node.subject
        rest = self.activity.block
        before = dict(frame.names)
        after: list[dict[str, Value]] = []
        ends: set[str] = set()
        for case in node.cases:
            frame.names.clear()
            frame.names.update(before)
            condition = self._pattern(case.pattern, subject, frame)
            with self.perhaps(is_kept=True) as block:
                self._bind_names(case.pattern, value, node, frame)
                if case.guard is not None:
                    with self.block() as asked:
                        self.decide(case.guard, frame)
                    holds = self.condition(case.guard, frame, asked)
                    condition = holds if condition is None else Joined([condition, holds], is_or=False)
                    subject = None if asked else subject  # the guard may change what the subject was
                found = self.execute(case.body, frame)
            ends |= found
            if FALLS in found:
                after.append(dict(frame.names))
            if condition is None:
                rest += block
                break
            choice = Branch(condition, block, [])
            rest.append(choice)
            rest = choice.otherwise
        else:
            ends |= {FALLS}
            after.append(before)
        merge(frame, after, before)
        return ends

    def _pattern(self, pattern: ast.pattern, subject: ast.expr | None, frame: Frame) -> Condition | None:
        """Return the condition of a pattern, which compares the subject if it is given; None: always true."""
        match pattern:
            case ast.MatchAs(pattern=None):
                return None
            case ast.MatchAs(pattern=ast.pattern() as inner):
                return self._pattern(inner, subject, frame)
            case ast.MatchOr(patterns=patterns):
                found = [self._pattern(each, subject, frame) for each in patterns]
                known = [each for each in found if each is not None]
                return Joined(known, is_or=True) if len(known) == len(found) else None
            case ast.MatchValue(value=value) if subject is not None:
                return self.compared(subject, ast.Eq(), value, frame)
            case ast.MatchSingleton(value=single) if subject is not None:
                return self.compared(subject, ast.Is(), ast.Constant(single), frame)
        return Anything()

    def _bind_names(self, pattern: ast.pattern, value: Value, node: ast.AST, frame: Frame) -> None:
        """Assign the matching parts of a value to the variables of a pattern, as far as they are known."""
        match pattern:
            case ast.MatchAs(pattern=inner, name=name):
                if inner is not None:
                    self._bind_names(inner, value, node, frame)
                if name is not None:
                    self.assign_variable(name, Open(name) if isinstance(value, Const) else value, frame)
            case ast.MatchStar(name=name) if name is not None:
                self.assign_variable(name, Items([value], is_open=True), frame)
            case ast.MatchOr(patterns=patterns):
                for each in patterns:
                    self._bind_names(each, value, node, frame)
            case ast.MatchSequence(patterns=patterns):
                turns, is_exact = self.turns(value)
                rest = join(turns) if turns else Open("element")
                has_star = any(isinstance(each, ast.MatchStar) for each in patterns)
                is_exact &= len(turns) == len(patterns) and not has_star
                for index, each in enumerate(patterns):
                    self._bind_names(each, turns[index] if is_exact else rest, node, frame)
            case ast.MatchMapping(keys=keys, patterns=patterns, rest=name):
                for key, each in zip(keys, patterns, strict=True):
                    known = self.element(value, self.evaluate(key, frame), text_of_code(key))
                    self._bind_names(each, known, node, frame)
                if name is not None:
                    self.assign_variable(name, Mapping(rest=[value], is_open=True), frame)
            case ast.MatchClass(patterns=patterns, kwd_attrs=names, kwd_patterns=named):
                for each in patterns:
                    self._bind_names(each, self._any_field(value), node, frame)
                for name, each in zip(names, named, strict=True):
                    self._bind_names(each, self.attribute(value, name, name, node, frame), node, frame)

    def _any_field(self, value: Value) -> Value:
        """Return any attribute of an object: patterns name some by their position."""
        slots = [
            each.any() for part in options(value) if isinstance(part, Object) for each in part.slots.values()
        ]
        return join(slots) if slots else Open("field")


def merge(frame: Frame, after: list[dict[str, Value]], before: dict[str, Value]) -> None:
    """Merge the values of variables from all branches that continue."""
    if len(after) < 2:
        found = dict(*after) if after else dict(before)
        frame.names.clear()
        frame.names.update(found)
        return
    names = {name for each in after for name in each}
    merged = {name: join([each[name] for each in after if name in each]) for name in names}
    frame.names.clear()
    frame.names.update(merged)
