"""That something can always fire, where some places have no bound.

The places without a bound are left out: what is left can do all that the net can, and more. Where even there
each marking enables a transition that no place left out can hold up, the net has no deadlock.
"""

from __future__ import annotations

from collections.abc import Collection

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.nets.compiled import CompiledNet, Transition


def has_no_deadlock(net: CompiledNet, unbounded: Collection[int], budget: Budget) -> bool:
    """Whether it is proved that each reachable marking enables something.

    Parameters
    ----------
    net : CompiledNet
        The net.
    unbounded : collection of int
        Places that may have no bound; all others have one.
    budget : Budget
        What it may cost.
    """
    from dineros.analysis.symbolic.engine import symbolic_state_space
    from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError
    from dineros.analysis.symbolic.saturation import DiagramMemoryError
    from dineros.analysis.symbolic.vector_sets import Scope

    free = [t for t in range(len(net.transitions)) if not _looked_at(net, t).intersection(unbounded)]
    if any(not net.pre.row(t) and not net.inhibitor.row(t) for t in free):
        return True
    try:
        space = symbolic_state_space(without_places(net, unbounded), budget)
        if not space.complete:
            return False
        masks = [mask for t in free for mask in space.event_masks(t)]
        with Scope(space.diagram):
            return space.sets.without_boxes(space.diagram.root, masks) == 0
    except (UnknownBoundError, LevelSizeError, DiagramMemoryError, BudgetExceededError):
        return False


def without_places(net: CompiledNet, places: Collection[int]) -> CompiledNet:
    """Return the net without some places; transitions keep their numbers."""
    names = net.places

    def kept(row: list[tuple[int, int]]) -> dict[str, int]:
        return {names[p]: weight for p, weight in row if p not in places}

    rows = [
        Transition(name, kept(net.pre.row(t)), kept(net.post.row(t)), kept(net.inhibitor.row(t)))
        for t, name in enumerate(net.transitions)
    ]
    tokens = {name: int(net.initial[p]) for p, name in enumerate(names) if p not in places}
    return CompiledNet.build(tokens, rows)


def _looked_at(net: CompiledNet, transition: int) -> set[int]:
    return {p for p, _ in (*net.pre.row(transition), *net.inhibitor.row(transition))}
