"""Parts of the net that grow only as far as the question needs them."""

from __future__ import annotations

from collections.abc import Iterable

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.explicit.goals import Comparison, Goal
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.reach import Reach
from dineros.analysis.portfolio.satisfies import Question

PARTS = "parts of the net"

MOST_RANGES = 64
"""Ranges that a conjunction may have: each inequality of a place with a number doubles them."""

ANY: tuple[int, int | None] = (0, None)
"""The range of all numbers of tokens."""


class PartsOfNet(Method):
    """Prove that no part of the net reaches a goal, or find a trace that the whole net can fire.

    The goals are enabled transitions and comparisons of single places with numbers.
    """

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Decide the question on parts of its net."""
        if not isinstance(question, Reach) or not question.goals:
            return None
        ranges = [found for goal in question.goals for found in _ranges(question.net, goal)]
        if None in ranges:
            return None
        from dineros.analysis.parts.goals import ReachableGoals

        asked = (each for each in ranges if each is not None)
        way, is_decided = ReachableGoals(question.net, question.holds).way_to(asked, budget)
        if way is not None:
            return question.reached(way, PARTS)
        return Outcome("unreachable", by=PARTS) if is_decided else None


def _ranges(net: CompiledNet, goal: Goal) -> Iterable[dict[int, tuple[int, int | None]] | None]:
    """Yield the ranges of tokens that fulfil a goal; None if the goal compares anything else."""
    if goal.is_deadlock:
        yield None
        return
    for conjunction in goal.alternatives(net):
        boxes: list[dict[int, tuple[int, int | None]]] = [{}]
        for comparison in conjunction:
            single = _range(comparison)
            if single is None:
                yield None
                return
            place, ends = single
            boxes = [{**box, place: _both(box.get(place, ANY), end)} for box in boxes for end in ends]
            if len(boxes) > MOST_RANGES:
                yield None
                return
        yield from boxes


def _range(comparison: Comparison) -> tuple[int, list[tuple[int, int | None]]] | None:
    """Return the place that is compared, and the ranges in which the comparison is true."""
    (place, factor), *others = comparison.weights.items() or ((0, 0),)
    value = comparison.value
    if others or factor != 1:
        return None
    match comparison.relation:
        case ">=" | ">":
            return place, [(value + (comparison.relation == ">"), None)]
        case "<=" | "<":
            return place, [(0, value - (comparison.relation == "<"))]
        case "=":
            return place, [(value, value)]
        case "!=":
            return place, [(0, value - 1), (value + 1, None)]


def _both(one: tuple[int, int | None], other: tuple[int, int | None]) -> tuple[int, int | None]:
    highs = [high for high in (one[1], other[1]) if high is not None]
    return max(one[0], other[0]), min(highs, default=None)
