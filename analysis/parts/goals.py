"""Whether a marking with some numbers of tokens is reachable, decided on parts of a net."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

from dineros.analysis.answers.budget import Budget
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.parts.part import TOO_LARGE, GrowingPart, Whole

ROUNDS = 150
"""Parts that are tried for each range of markings."""

WORK = 2_000_000
"""Cache misses of saturation that the markings of a part may cost."""

Ranges = Mapping[int, tuple[int, int | None]]
"""By place: its least number of tokens, and its greatest one, if there is one."""


class ReachableGoals:
    """Decides whether markings within ranges of tokens are reachable.

    `is_goal`: whether a marking of the net is what is looked for; it is then within one of the ranges.
    """

    def __init__(self, net: CompiledNet, is_goal: Callable[[Sequence[int]], bool]) -> None:
        self._whole = Whole(net)
        self._is_goal = is_goal

    def way_to(self, each_ranges: Iterable[Ranges], budget: Budget) -> tuple[tuple[int, ...] | None, bool]:
        """Return a firing sequence to a goal, if there is one, and whether the question is decided.

        A place without a proved bound belongs to no part: its range is ignored. So no sequence is found if
        that range matters, and the question stays open.
        """
        is_decided = True
        for ranges in each_ranges:
            way, is_known = self._way_to(ranges, budget)
            if way is not None:
                return way, True
            is_decided &= is_known
        return None, is_decided

    def _way_to(self, ranges: Ranges, budget: Budget) -> tuple[tuple[int, ...] | None, bool]:
        whole = self._whole
        initial = whole.net.initial.tolist()
        box: dict[int, tuple[int, int]] = {}
        for place in ranges.keys() & whole.free.keys():
            bound, (low, high) = initial[place] + whole.free[place], ranges[place]
            box[place] = max(0, low), bound if high is None else min(bound, high)
            if box[place][0] > box[place][1]:
                return None, True
        places = whole.grown(box)
        if not places:
            return None, False
        for _ in range(ROUNDS):
            if budget.is_over:
                break
            try:
                way = self._way_in_part(GrowingPart(whole, places, (), budget, WORK), box)
            except TOO_LARGE:
                break
            if way is None:
                return None, True
            marking, blocking = whole.lifted(way)
            if not blocking:
                return (way, True) if self._is_goal(marking) else (None, False)
            more = whole.grown(blocking & whole.free.keys()) - places
            if not more:
                break  # a place without a known bound is in the way
            places |= more
        return None, False

    @staticmethod
    def _way_in_part(part: GrowingPart, box: Mapping[int, tuple[int, int]]) -> tuple[int, ...] | None:
        """Return transitions that lead to a marking of a part within a box; None: there is none."""
        order = sorted(part.places)
        goals = 0
        for masks in part.space.encoding.masks({order.index(place): ends for place, ends in box.items()}):
            goals = part.sets.union(goals, part.sets.sets.box(masks))
        goals = part.sets.intersection(part.sets.everything, goals)
        part.space.diagram.pinned.append(goals)
        return part.way_to(goals) if goals else None
