"""Ways to a goal by what cannot be undone: explicit search between one firing that no cycle has and the next.

Transitions that are not repeatable raise a weighted sum of tokens that no firing lowers and that is bounded.
Where the goal can still be reached after such a firing, a search need not come back to before it.
"""

from __future__ import annotations

from collections.abc import Callable

from dineros.analysis.compiled import CompiledNet

Marking = tuple[int, ...]
#: Markings looked at between two firings, before another way to search is worth more.
MOST_MARKINGS = 2_000


def climb(
    net: CompiledNet,
    start: Marking,
    is_near: Callable[[Marking], bool],
    is_goal: Callable[[Marking], bool],
    repeatable: frozenset[int],
) -> tuple[int, ...] | None:
    """Return transitions that lead to a goal; None where too many markings lie between two steps.

    Parameters
    ----------
    net : CompiledNet
        The net, bounded.
    start : tuple of int
        A marking, near the goal.
    is_near : callable
        Whether a marking is one from which a goal can be reached over such markings only.
    is_goal : callable
        Whether a marking is a goal.
    repeatable : frozenset of int
        See `dineros.analysis.repetition`.
    """
    route: list[int] = []
    while not is_goal(start):
        came: dict[Marking, tuple[Marking, int] | None] = {start: None}
        queue, end = [start], None
        for marking in queue:
            for transition in range(len(net.transitions)):
                if not net.is_enabled(transition, marking):
                    continue
                after = tuple(net.fire(transition, marking))
                if after in came or not is_near(after):
                    continue
                came[after] = marking, transition
                if transition not in repeatable or is_goal(after):
                    end = after
                    break
                queue.append(after)
            if end is not None or len(came) > MOST_MARKINGS:
                break
        if end is None:
            return None
        start, part = end, []
        while (before := came[end]) is not None:
            end, transition = before
            part.append(transition)
        route += reversed(part)
    return tuple(route)
