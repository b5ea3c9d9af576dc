"""Levels of a decision diagram: small groups of places with their local states, and events as local tables.

Places of a semiflow of constant one (a state machine with one token) share a level: at most one of them is
marked, so that k places need k + 1 local states instead of k levels. Each other kept place gets its own
level.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from operator import add, mul

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.nets.bounds import Bound, bounds_like, flows_and_bounds
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.state_machines import state_machines
from dineros.analysis.nets.structure import PlaceInvariant, place_invariants, proportional_places
from dineros.analysis.symbolic.boxes import LARGEST_PRODUCT, Box, BoxNet
from dineros.analysis.symbolic.dropping import GuardedNet
from dineros.analysis.symbolic.grouping import groups_of_bounds, groups_of_flows, groups_of_wide_net
from dineros.metamodel.errors import BudgetError

Int32Array = NDArray[np.int32]
#: By encoding level: a number for each local state, to be summed; levels without numbers count as zero.
Weights = Mapping[int, Sequence[int]]

#: Bytes of a local state, including its entries in the tables of a few events.
BYTES_OF_A_STATE = 300
#: Bytes that levels may always take, even if little memory is left for the diagram.
ALWAYS_ALLOWED = 1 << 24
#: Additional events allowed for each dropped place.
LARGEST_GROWTH = 8


@dataclass(frozen=True)
class Level:
    """A group of places and the combinations of tokens it can hold.

    Attributes
    ----------
    states : tuple of tuple of int
        Local states: tokens of the places, in their order.
    initial : int
        Index of the initial local state.
    """

    places: tuple[int, ...]
    states: tuple[tuple[int, ...], ...]
    initial: int


def changes(table: Sequence[int]) -> bool:
    """Return whether a table changes a local state."""
    return any(j not in (-1, i) for i, j in enumerate(table))


@dataclass(frozen=True)
class LocalEvent:
    """An event: per level it touches, a table from local state to the next, -1 where it is not enabled."""

    transition: int
    tables: dict[int, tuple[int, ...]]

    @property
    def is_change(self) -> bool:
        """Whether it changes a local state."""
        return any(map(changes, self.tables.values()))


@dataclass(frozen=True)
class Encoding:
    """Input of the symbolic engine for a net, before any order of the levels.

    Attributes
    ----------
    bounds : tuple of (Bound or None)
        By place.
    flows : tuple of tuple of int
        Levels with the places of a semiflow, if there are several such levels.
    """

    boxes: BoxNet
    levels: tuple[Level, ...]
    events: tuple[LocalEvent, ...]
    bounds: tuple[Bound | None, ...]
    flows: tuple[tuple[int, ...], ...]

    @cached_property
    def home(self) -> dict[int, int]:
        """Kept place -> level."""
        return {place: index for index, level in enumerate(self.levels) for place in level.places}

    def renumbered(self, net: CompiledNet, places: Sequence[int], transitions: Sequence[int]) -> Encoding:
        """Return the same levels and events with the numbers of a net whose elements are ordered differently.

        Place n of this net is place ``places[n]`` of the other one; `transitions` works likewise.
        """
        bounds: list[Bound | None] = [None] * len(places)
        renumbered: dict[int, dict[int, int]] = {}  # most places share their weighting with others
        for place, bound in zip(places, self.bounds, strict=True):
            if bound is not None:
                weights = renumbered.get(id(bound.weights))
                if weights is None:
                    weights = {places[p]: weight for p, weight in bound.weights.items()}
                    renumbered[id(bound.weights)] = weights
                bounds[place] = Bound(bound.value, weights)
        return Encoding(
            self.boxes.renumbered(net, places),
            tuple(replace(level, places=tuple(places[p] for p in level.places)) for level in self.levels),
            tuple(LocalEvent(transitions[event.transition], event.tables) for event in self.events),
            tuple(bounds),
            self.flows,
        )

    def weights_of(self, factors: Mapping[int, int]) -> tuple[Weights, int]:
        """Return a weighted sum of tokens as weights of local states, ``[level][state]``, and a constant.

        Levels that do not contribute to the sum have no weights.
        """
        kept: dict[int, int] = {}
        constant = 0
        for place, factor in factors.items():
            rule = self.boxes.determined.get(place)
            constant += factor * rule.constant if rule else 0
            for p, k in (rule.factors if rule else {place: 1}).items():
                kept[p] = kept.get(p, 0) + factor * k
        kept = {place: factor for place, factor in kept.items() if factor}
        weights: dict[int, Sequence[int]] = {}
        for k in {self.home[place] for place in kept}:
            level = self.levels[k]
            # Levels of several hundred places have as many local states: only the places of the sum count.
            at = [i for i, place in enumerate(level.places) if place in kept]
            row = [kept[level.places[i]] for i in at]
            weights[k] = [sum(map(mul, row, map(state.__getitem__, at))) for state in level.states]
        return weights, constant

    def masks(self, guard: Box) -> list[dict[int, Sequence[bool]]]:
        """Return a guard over any places as disjoint products of local-state sets (level -> flags)."""
        home = self.home
        answers: list[dict[int, Sequence[bool]]] = []
        for box in self.boxes.guard_boxes(guard):
            masks: dict[int, Sequence[bool]] = {}
            for k in {home[place] for place in box}:
                level = self.levels[k]
                asked = [(at, *box[p]) for at, p in enumerate(level.places) if p in box]
                masks[k] = tuple(_holds(state, asked) for state in level.states)
            answers.append(masks)
        return answers


def encode(
    net: CompiledNet,
    caps: Sequence[int | None] | None = None,
    memory: int | None = None,
    keep: Collection[int] = (),
) -> Encoding:
    """Choose levels for a net and write its events over them.

    Parameters
    ----------
    caps
        Assumed largest number of tokens for places that no invariant bounds.
    memory
        Bytes that the levels may take; unlimited by default.
    keep
        Places that must belong to a level even if others determine them.

    Raises
    ------
    UnknownBoundError
        If a place is bounded neither by an invariant nor by a cap; it names the places.
    LevelSizeError
        The local states of places that may hold many tokens exceed the memory.
    """
    flows, bounds = net.once(flows_and_bounds)
    values = [None if bound is None else bound.value for bound in bounds]
    if caps is not None:
        values = [cap if value is None else value for value, cap in zip(values, caps, strict=True)]
    known = [value for value in values if value is not None]
    if len(known) < len(values):
        raise UnknownBoundError([net.places[p] for p, value in enumerate(values) if value is None])
    exact = net.once(exact_invariants)
    droppable = set(range(len(net.places))).difference(keep)
    guarded = GuardedNet(net, known)
    for place in droppable:
        if not net.changing[place]:
            guarded.drop(PlaceInvariant.of(net, {place: 1}), place, 0)
    guarded.drop_determined((y for y in exact if len(y.weights) == 2), 0, droppable)
    if flows is None:
        groups = _by_bounds(net, guarded.kept, known, bounds, [])
        single = _single(guarded.kept, known, groups)
        groups += groups_of_wide_net(net, single, bounds) or state_machines(net, single)
    else:
        groups = groups_of_flows(guarded.kept, [flow for flow in flows if flow.constant == 1])
        groups += _by_bounds(net, guarded.kept, known, bounds, groups)
    alone = set(guarded.kept) - {place for group in groups for place in group}
    guarded.drop_determined(exact, LARGEST_GROWTH, alone & droppable)
    groups += [(place,) for place in guarded.kept if place in alone]
    if memory is not None:
        _require_few_states(net, known, [group[0] for group in groups if len(group) == 1], memory)
    levels = tuple(_level(net, known, group) for group in groups)
    home = {place: k for k, level in enumerate(levels) for place in level.places}
    spans = (tuple(sorted({home[p] for p in guarded.over_kept(flow).weights})) for flow in exact)
    shared = tuple(span for span in spans if len(span) > 1)
    return Encoding(guarded.boxes(), levels, _local_events(guarded, levels), tuple(bounds), shared)


def exact_invariants(net: CompiledNet) -> Sequence[PlaceInvariant]:
    """Return the semiflows of a net, or simpler invariants if it has too many of them."""
    flows, _ = net.once(flows_and_bounds)
    return [*proportional_places(net), *place_invariants(net)] if flows is None else flows


def encode_like(encoding: Encoding, net: CompiledNet) -> Encoding:
    """Return the encoding of another net of the same structure, with the same levels and dropped places.

    It is used for scaled-down instances, on which orders of levels are tried: a level has the same
    meaning in both encodings.
    """
    known = [value for value in bounds_like(net, encoding.bounds) if value is not None]
    if len(known) < len(net.places):
        raise ValueError("the weightings that bound the net do not bound the other one")
    guarded = GuardedNet(net, known)
    for place, rule in encoding.boxes.determined.items():
        weights = {place: 1, **{p: -factor for p, factor in rule.factors.items()}}
        constant = sum(int(net.initial[p]) * weight for p, weight in weights.items())
        if not guarded.drop(PlaceInvariant(weights, constant), place, LARGEST_PRODUCT):
            raise ValueError(f"place {net.places[place]!r} cannot be dropped in the other net")
    levels = tuple(_level(net, known, level.places) for level in encoding.levels)
    return Encoding(guarded.boxes(), levels, _local_events(guarded, levels), encoding.bounds, encoding.flows)


def _require_few_states(net: CompiledNet, bounds: Sequence[int], alone: Sequence[int], memory: int) -> None:
    """Raise an error for levels that exceed the memory, before they are made."""
    if sum(bounds[place] + 1 for place in alone) * BYTES_OF_A_STATE > max(memory, ALWAYS_ALLOWED):
        largest = max(alone, key=bounds.__getitem__)
        raise LevelSizeError(
            f"memory ran out: place {net.places[largest]!r} may hold {bounds[largest]} tokens, "
            "more than a decision diagram has memory for",
            hint="allow more with --memory, or use --engine explicit if the command has this option",
        )


def _by_bounds(
    net: CompiledNet,
    kept: Sequence[int],
    values: Sequence[int],
    bounds: Sequence[Bound | None],
    groups: Sequence[tuple[int, ...]],
) -> list[tuple[int, ...]]:
    """Return further groups of kept places, by bounds."""
    single = _single(kept, values, groups)
    others = len(kept) - len(single) - sum(len(group) - 1 for group in groups)
    return groups_of_bounds(net, single, bounds, others)


def _single(kept: Iterable[int], bounds: Sequence[int], groups: Iterable[tuple[int, ...]]) -> list[int]:
    """Return kept places with at most one token that belong to no group."""
    return sorted({p for p in kept if bounds[p] == 1}.difference(*groups))


def _level(net: CompiledNet, bounds: Sequence[int], group: tuple[int, ...]) -> Level:
    if len(group) == 1:
        states: list[tuple[int, ...]] = [(tokens,) for tokens in range(bounds[group[0]] + 1)]
    else:
        states = [tuple(int(p == marked) for p in group) for marked in (-1, *group)]
    initial = states.index(tuple(int(net.initial[p]) for p in group))
    return Level(group, tuple(states), initial)


def _holds(state: tuple[int, ...], asked: Iterable[tuple[int, int, int]]) -> bool:
    """Return whether a local state is within intervals: (position in the level, fewest, most)."""
    return all(low <= state[at] <= high for at, low, high in asked)


def _local_events(guarded: GuardedNet, levels: Sequence[Level]) -> tuple[LocalEvent, ...]:
    home = {place: k for k, level in enumerate(levels) for place in level.places}
    # Tables depend on the states of a level, not on its places: many levels share their tables.
    shapes: dict[tuple[tuple[int, ...], ...], _Shape] = {}
    shape_of = [shapes.setdefault(level.states, _Shape(level.states)) for level in levels]
    events = []
    for event in guarded.events:
        guard, change = event.guard, event.change
        tables: dict[int, tuple[int, ...]] = {}
        for k in sorted({home[p] for p in (*guard, *change)}):
            places = levels[k].places
            table = shape_of[k].table(tuple(map(guard.get, places)), tuple(map(change.get, places)))
            if table is None:
                break
            tables[k] = table
        else:
            events.append(LocalEvent(event.transition, tables))
    return tuple(events)


class _Shape:
    """The local states of a level, and the tables of all events on levels with these states."""

    def __init__(self, states: tuple[tuple[int, ...], ...]) -> None:
        self._states = states
        self._position = {state: i for i, state in enumerate(states)}
        self._tables: dict[tuple[object, object], tuple[int, ...] | None] = {}

    def table(
        self, guard: tuple[tuple[int, int] | None, ...], gain: tuple[int | None, ...]
    ) -> tuple[int, ...] | None:
        """Return the table of an event from (fewest, most) and gain by place; None if it is never enabled."""
        key = guard, gain
        if key not in self._tables:
            asked = [(at, *interval) for at, interval in enumerate(guard) if interval is not None]
            gained = [tokens or 0 for tokens in gain]
            table = []
            for state in self._states:
                for at, low, high in asked:
                    if not low <= state[at] <= high:
                        table.append(-1)
                        break
                else:
                    # A target outside the local states breaks a proved bound: another guard forbids it.
                    table.append(self._position.get(tuple(map(add, state, gained)), -1))
            self._tables[key] = tuple(table) if max(table) >= 0 else None
        return self._tables[key]


class LevelSizeError(BudgetError):
    """Places may hold more tokens than a decision diagram has memory for."""


class UnknownBoundError(ValueError):
    """Places that no invariant bounds."""

    def __init__(self, places: list[str]) -> None:
        super().__init__(f"no invariant bounds {', '.join(places)}")
        self.places = places
