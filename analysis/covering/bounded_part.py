"""What the part of a net that has bounds proves of the whole net.

Places without a proved bound are left out. What is left can do all that the net can, and more, and its state
space ends: what can never fire there never can in the net. Where each of its markings enables a transition
that no place left out can hold up, the net has no deadlock.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.nets.bounds import place_bounds
from dineros.analysis.nets.compiled import CompiledNet, Transition


@dataclass(frozen=True)
class BoundedPart:
    """What is proved.

    Attributes
    ----------
    dead : frozenset of int
        Transitions that can never fire.
    has_no_deadlock : bool
        Whether there is no deadlock.
    """

    dead: frozenset[int] = frozenset()
    has_no_deadlock: bool = False


def bounded_part(net: CompiledNet, budget: Budget) -> BoundedPart:
    """Prove what the places with bounds alone tell; nothing where the budget is not enough.

    Parameters
    ----------
    net : CompiledNet
        The net.
    budget : Budget
        What it may cost.
    """
    from dineros.analysis.symbolic.engine import symbolic_state_space
    from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError
    from dineros.analysis.symbolic.saturation import DiagramMemoryError

    unbounded = unbounded_places(net)
    free = free_transitions(net, unbounded)
    always = any(not _looked_at(net, t) for t in free)
    if len(unbounded) == len(net.places):
        return BoundedPart(has_no_deadlock=always)
    try:
        space = symbolic_state_space(without_places(net, unbounded), budget)
        if not space.complete:
            return BoundedPart(has_no_deadlock=always)
        dead = frozenset(t for t, name in enumerate(net.transitions) if space.enabled(name) == 0)
        masks = [mask for t in free for mask in space.event_masks(t)]
        stuck = 0 if always else space.sets.without_boxes(space.diagram.root, masks)
    except (UnknownBoundError, LevelSizeError, DiagramMemoryError, BudgetExceededError):
        return BoundedPart(has_no_deadlock=always)
    return BoundedPart(dead, stuck == 0)


def unbounded_places(net: CompiledNet) -> set[int]:
    """Places whose structure proves no bound."""
    return {place for place, bound in enumerate(place_bounds(net)) if bound is None}


def free_transitions(net: CompiledNet, unbounded: Collection[int]) -> list[int]:
    """Transitions that none of some places can hold up."""
    return [t for t in range(len(net.transitions)) if not _looked_at(net, t).intersection(unbounded)]


def without_places(net: CompiledNet, places: Collection[int]) -> CompiledNet:
    """Return the net without some places; transitions keep their numbers."""
    gone = {net.places[p] for p in places}

    def kept(row: Mapping[str, int]) -> dict[str, int]:
        return {place: number for place, number in row.items() if place not in gone}

    tokens, rows = net.by_names()
    smaller = [Transition(row.name, *map(kept, (row.inputs, row.outputs, row.inhibitors))) for row in rows]
    return CompiledNet.build(kept(tokens), smaller)


def _looked_at(net: CompiledNet, transition: int) -> set[int]:
    return {p for p, _ in (*net.pre.row(transition), *net.inhibitor.row(transition))}
