"""Traces to a goal by irreversible firings: explicit search from one firing outside of cycles to the next.

Transitions that are not repeatable raise a weighted sum of tokens that no firing lowers and that is bounded.
If the goal can still be reached after such a firing, a search need not come back to before it.
"""

from __future__ import annotations

from collections.abc import Callable

from dineros.analysis.logic.verdicts.verdict import Marking
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import moves

#: Number of markings examined between two such firings, before another search is better.
MOST_MARKINGS = 2_000


def climb(
    net: CompiledNet,
    start: Marking,
    is_near: Callable[[Marking], bool],
    is_goal: Callable[[Marking], bool],
    repeatable: frozenset[int],
) -> tuple[int, ...] | None:
    """Return transitions that lead to a goal; None: there are too many markings between two steps.

    Parameters
    ----------
    net : CompiledNet
        The net, bounded.
    start : tuple of int
        A marking, near the goal.
    is_near : callable
        Whether a goal can be reached from a marking through such markings only.
    repeatable : frozenset of int
        See `dineros.analysis.nets.repetition`.
    """
    route: list[int] = []
    changes = [frozenset(change.items()) for change in net.delta]
    inverses = {frozenset((place, -tokens) for place, tokens in change) for change in changes}
    switches = frozenset(t for t, change in enumerate(changes) if change in inverses)
    while not is_goal(start):
        part = _up(net, start, is_near, is_goal, repeatable, switches)
        if part is None:
            return None
        for transition in part:
            start = tuple(net.fire(transition, start))
        route += part
    return tuple(route)


def _up(
    net: CompiledNet,
    start: Marking,
    is_near: Callable[[Marking], bool],
    is_goal: Callable[[Marking], bool],
    repeatable: frozenset[int],
    switches: frozenset[int],
) -> list[int] | None:
    """Return a trace to the next irreversible firing, or to a goal, with as few switches as possible.

    A switch is a transition that another one undoes, such as the changes of signals: n of them alone make up
    to 2^n markings, few of which are one or two steps away.
    """
    came: dict[Marking, tuple[Marking, int] | None] = {start: None}
    now, later = [start], list[Marking]()
    while now:
        for marking in now:
            for transition, after in moves(net, marking):
                if after in came or not is_near(after):
                    continue
                came[after] = marking, transition
                if transition not in repeatable or is_goal(after):
                    return _way_to(after, came)
                (later if transition in switches else now).append(after)
            if len(came) > MOST_MARKINGS:
                return None
        now, later = later, []
    return None


def _way_to(marking: Marking, came: dict[Marking, tuple[Marking, int] | None]) -> list[int]:
    way = []
    while (before := came[marking]) is not None:
        marking, transition = before
        way.append(transition)
    return way[::-1]
