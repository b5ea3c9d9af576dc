"""Runs ``match`` statements: each case is a branch, whose condition compares the subject with constants."""

from __future__ import annotations

import ast

from dineros.sources.branches import Anything, Branch, Condition, Joined
from dineros.sources.language.assigning import Assignments
from dineros.sources.language.machine import FALLS
from dineros.sources.language.values import Frame, Open, Value, join


class Matching(Assignments):
    """The part of the interpreter that runs ``match`` statements."""

    def _run_Match(self, node: ast.Match, frame: Frame) -> set[str]:  # noqa: N802
        with self.block() as asked:
            self.evaluate(node.subject, frame)
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
                self._bind_names(case.pattern, frame)
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

    def _bind_names(self, pattern: ast.pattern, frame: Frame) -> None:
        """Assign unknown values to the variables of a pattern."""
        for each in ast.walk(pattern):
            name = each.rest if isinstance(each, ast.MatchMapping) else getattr(each, "name", None)
            if isinstance(each, (ast.MatchAs, ast.MatchStar, ast.MatchMapping)) and name:
                self.assign_variable(name, Open(name), frame)


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
