"""Ways to a goal, searched for explicitly, on the fly: one marking after another, or led by a diagram."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.explicit import Order, find
from dineros.analysis.explicit.answers import Reduction
from dineros.analysis.explicit.engine import NO_END
from dineros.analysis.explicit.goals import Goal, excludes
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.shortening import shortened

if TYPE_CHECKING:
    from dineros.analysis.symbolic.engine import SymbolicStateSpace

QUICK = 256 << 20
"""Bytes for the search for a shortest trace, before the net is reduced."""

NEAR_IF_UNBOUNDED = 1_000_000
"""Markings of a search for a shortest trace in a net that is seen to have no end of them."""

INTERRUPTED = "interrupted"
_REASONS = {
    "memory": "memory ran out",
    "time": "time ran out",
    "states": "the limit of markings was reached",
    "unbounded": "the net is unbounded, and memory ran out",
    "interrupted": INTERRUPTED,
}


def find_firing(net: CompiledNet, transition: int, budget: Budget = UNLIMITED) -> Outcome:
    """Find a trace that ends with a transition: a shortest one, unless only the reduced net is small enough.

    Reduction by rules that preserve LTL without next keeps whether the transition ever fires; a trace of the
    reduced net is mapped back, and what it does not need is left out.
    """
    from dineros.analysis.reductions import Property, reduce

    budget = budget.begun()
    name = net.transitions[transition]
    answer = search(net, Goal.enabled(net, transition), budget.share(most_bytes=QUICK), "breadth-first")
    if answer.trace is not None:
        return replace(answer, trace=(*answer.trace, transition))
    if answer.status != "unknown" or answer.reason == INTERRUPTED or budget.is_over:
        return answer
    reduction = reduce(net, {Property.LTL_WITHOUT_NEXT}, observed_transitions=[name])
    smaller = reduction.net
    answer = search(smaller, Goal.enabled(smaller, name), budget, "breadth-first", is_shortest=False)
    if answer.trace is None:
        return answer
    index = {name: number for number, name in enumerate(net.transitions)}
    names = reduction.expand([*(smaller.transitions[number] for number in answer.trace), name])
    trace = _to_goal(net, Goal.enabled(net, transition), [index[name] for name in names[:-1]])
    return Outcome("reachable", (*trace, transition))


def way_to_firing(space: SymbolicStateSpace, transition: int) -> tuple[int, ...]:
    """Return a firing sequence that ends with a transition, where some reachable marking enables it.

    It is led by the diagram of all reachable markings, so that it is found however far away it is; a shortest
    one it need not be. Of the markings that enable the transition one is chosen: what leads to any of them
    can take far more nodes.

    Raises
    ------
    DiagramMemoryError
        If memory runs out.
    """
    from dineros.analysis.logic.ctl.symbolic_sets import SymbolicSets
    from dineros.analysis.symbolic.vector_sets import Scope

    ways = SymbolicSets(space)
    sets, all_of_them = ways.sets, space.diagram.root
    with Scope(space.diagram) as scope:
        others = sets.without_boxes(all_of_them, space.event_masks(transition))
        scope.hold(others)
        enabling = sets.difference(all_of_them, others)
        scope.hold(enabling)
        goal = sets.some(enabling)
        scope.hold(goal)
        way = ways.way_to(goal)
    return (*_to_goal(space.net, Goal.enabled(space.net, transition), way), transition)


def search(
    net: CompiledNet,
    goal: Goal,
    budget: Budget,
    order: Order,
    is_shortest: bool = True,
    *,
    is_near: bool = False,
) -> Outcome:
    """Search for a goal explicitly: for a shortest trace first, on an unbounded net also for a proof.

    Where a shortest one is not asked for, any that the search meets first will do. Where only what is near is
    asked for (`is_near`), that is all.
    """

    def explore(share: Budget) -> Outcome:
        reduction: Reduction | None = "stubborn" if goal.is_deadlock else None
        return find(
            net,
            goal,
            share,
            reduction=reduction,
            order=order,
            is_shortest=is_shortest,
            most_if_unbounded=most_if_unbounded,
        )

    most_if_unbounded = NEAR_IF_UNBOUNDED
    answer = explore(budget.share(most_bytes=QUICK))
    # Of an unbounded net, more markings would prove nothing; the largest ones may.
    if answer.reason == "unbounded" and not is_near:
        from dineros.analysis.covering.goals import decide_goal
        from dineros.analysis.nets.coverability import coverability

        found = decide_goal(net, goal, budget.share(0.5))
        if found is not None:
            return found
        if excludes(net, coverability(net, budget=budget.share(0.3)), goal):
            return Outcome("unreachable", states=answer.states)
    if answer.reason in ("memory", "unbounded") and budget.memory > QUICK and not is_near:
        most_if_unbounded = NO_END
        answer = explore(budget.share(most_bytes=budget.memory))
    if answer.trace is None or order == "breadth-first":
        return replace(answer, reason=_REASONS.get(answer.reason, answer.reason))
    return Outcome("reachable", _to_goal(net, goal, answer.trace))


def _to_goal(net: CompiledNet, goal: Goal, trace: Sequence[int]) -> tuple[int, ...]:
    """Leave out of a trace what the goal does not need."""
    if len(goal.transitions) == 1:
        needs, inhibitors = net.pre.row(goal.transitions[0]), net.inhibitor.row(goal.transitions[0])

        def is_goal(marking: list[int]) -> bool:
            return all(marking[place] >= weight for place, weight in needs) and all(
                marking[place] < weight for place, weight in inhibitors
            )
    else:

        def is_goal(marking: list[int]) -> bool:
            return goal.holds(net, marking)

    return shortened(net, trace, is_goal)
