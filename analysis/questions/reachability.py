"""Ways to a firing: searched for explicitly, one marking after another, or led by a diagram."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.explicit.goals import Goal
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.portfolio.methods.explicit_search import QUICK, search, way_without_detours
from dineros.analysis.portfolio.reach import INTERRUPTED

if TYPE_CHECKING:
    from dineros.analysis.symbolic.engine import SymbolicStateSpace


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
    trace = way_without_detours(net, Goal.enabled(net, transition), [index[name] for name in names[:-1]])
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
    return (*way_without_detours(space.net, Goal.enabled(space.net, transition), way), transition)
