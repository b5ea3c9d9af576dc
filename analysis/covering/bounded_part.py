"""Proofs about a net from the part of it with bounded places.

Places without a proved bound are removed. The rest can do everything that the net can, and has a finite state
space: transitions that can never fire there can never fire in the net. If each of its markings enables a
transition that no removed place can disable, the net has no deadlock.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.nets.bounds import place_bounds
from dineros.analysis.nets.compiled import CompiledNet, Transition


@dataclass(frozen=True)
class BoundedPart:
    """The proved facts."""

    dead: frozenset[int] = frozenset()
    has_no_deadlock: bool = False


def bounded_part(net: CompiledNet, budget: Budget) -> BoundedPart:
    """Prove facts from the bounded places alone; nothing if the budget is not sufficient."""
    from dineros.analysis.symbolic.engine import symbolic_state_space
    from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError
    from dineros.analysis.symbolic.saturation import DiagramMemoryError

    unbounded = unbounded_places(net)
    free = free_transitions(net, unbounded)
    always = any(not net.tested(t) for t in free)
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
    """Places without a structural bound."""
    return {place for place, bound in enumerate(place_bounds(net)) if bound is None}


def free_transitions(net: CompiledNet, unbounded: Collection[int]) -> list[int]:
    """Transitions that none of some places can disable."""
    return [t for t in range(len(net.transitions)) if not net.tested(t).intersection(unbounded)]


def without_places(net: CompiledNet, places: Collection[int]) -> CompiledNet:
    """Return the net without some places; transitions keep their numbers."""
    gone = {net.places[p] for p in places}

    def kept(row: Mapping[str, int]) -> dict[str, int]:
        return {place: number for place, number in row.items() if place not in gone}

    tokens, rows = net.by_names()
    smaller = [Transition(row.name, *map(kept, (row.inputs, row.outputs, row.inhibitors))) for row in rows]
    return CompiledNet.build(kept(tokens), smaller)
