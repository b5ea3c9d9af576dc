"""Sets of markings of one part of a net, with cached successors by shown firings.

A set is a node of a decision diagram, so equal sets have equal numbers. Together the sets and the steps
between them are a deterministic automaton, of which only the states that a recording needs are built.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from typing import ParamSpec

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.symbolic.engine import SymbolicStateSpace, symbolic_state_space
from dineros.analysis.symbolic.saturation import DiagramMemoryError
from dineros.analysis.symbolic.vector_sets import Scope, VectorSets
from dineros.metamodel.errors import BudgetError
from dineros.observation.explaining.parts import NetPart

P = ParamSpec("P")
Vector = tuple[int, ...]

NOTHING = 0
"""The empty set."""

MOST_KEPT = 100_000
"""Limit of the cached sets of a part; beyond it, all except those in use are recomputed when needed."""

MOST_ANSWERS = 500_000
"""Limit of the cached answers about sets of a part."""


class SetsFullError(Exception):
    """There is no space for another set unless cached sets are discarded."""


def all_markings(part: NetPart, budget: Budget) -> SymbolicStateSpace:
    """Return all markings of a part.

    Raises
    ------
    BudgetError
        The time or the memory does not suffice.
    """
    try:
        space = symbolic_state_space(part.net, budget)
    except BudgetExceededError as limit:
        raise BudgetError(f"{limit}: not all markings of a part of the model were found") from limit
    if not space.complete:
        raise BudgetError("memory ran out: a part of the model has too many markings")
    return space


class MarkingSets:
    """The sets of markings of a part. All sets are closed under silent firings.

    `budget`: the budget of its diagram.

    Raises
    ------
    BudgetError
        The time or the memory does not suffice for the markings of the part.
    """

    def __init__(self, part: NetPart, budget: Budget) -> None:
        self.part = part
        self.space = space = all_markings(part, budget)
        self.sets: VectorSets = space.sets
        self._anything = bool(space.diagram.top)
        events = {event.transition for event in space.encoding.events}
        self._silent = self._only(part.silent & events)
        self._firing = {
            part.transitions[number]: self._only(frozenset({number})) for number in events - part.silent
        }
        # The diagram's relations omit transitions that change nothing; their enabling is kept.
        self._tests = {
            transition: space.event_masks(number)
            for number, transition in enumerate(part.transitions)
            if transition in self._firing and not part.net.delta[number]
        }
        self._steps: dict[tuple[int, int], int] = {}
        self._unions: dict[tuple[int, int], int] = {}
        self._covers: dict[tuple[int, int], bool] = {}
        self._kept: set[int] = set()
        self.reached_edge = False
        """Whether a firing was ignored because an unbounded place had too many tokens; then there may be more
        markings.
        """
        self.anywhere = self._hold(space.diagram.root) if self._anything else 1
        """All markings that the part can have, independent of the other parts."""
        self._edge = self._hold(self._edge_box())
        self._fixed = len(space.diagram.pinned)
        self.first = tuple(level.initial for level in space.encoding.levels)
        self.start = self.closed(self.sets.single(self.first)) if self._anything else 1
        """The set of markings before any message."""
        self._fixed = len(space.diagram.pinned)

    def step(self, states: int, transition: int) -> int:
        """Return the set after a shown transition of the whole net, followed by silent ones.

        Raises
        ------
        SetsFullError
            There is no space; `forget` frees some.
        """
        found = self._steps.get((states, transition))
        if found is None:
            found = self._steps[states, transition] = self._step(states, transition)
        return found

    def union(self, one: int, other: int) -> int:
        """Return the union of two sets."""
        if one == other:
            return one
        key = (one, other) if one < other else (other, one)
        found = self._unions.get(key)
        if found is None:
            found = self._unions[key] = self._hold(self._made(self.sets.union, *key))
        return found

    def covers(self, one: int, other: int) -> bool:
        """Return whether a set includes another one."""
        found = self._covers.get((one, other))
        if found is None:
            found = self._covers[one, other] = self.union(one, other) == one
        return found

    @property
    def is_full(self) -> bool:
        """Whether the caches are so large that they should be cleared."""
        return len(self._steps) + len(self._unions) + len(self._covers) > MOST_ANSWERS

    def forget(self, used: Iterable[int]) -> None:
        """Discard all sets except those in use."""
        self._steps.clear()
        self._unions.clear()
        self._covers.clear()
        del self.space.diagram.pinned[self._fixed :]
        self._kept.clear()
        for states in used:
            self._hold(states)

    def closed(self, states: int) -> int:
        """Return the closure of a set under silent firings."""
        if self._silent is not None and states and self._anything:
            with Scope(self.space.diagram) as scope:
                scope.hold(states)
                states = self._made(self._silent.closure, states, self.anywhere, False)
        states = self._hold(states)
        if not self.reached_edge:
            self.reached_edge = self.meets_edge(states)
        return states

    def meets_edge(self, states: int) -> bool:
        """Return whether a firing was ignored for a marking of a set; see `reached_edge`."""
        return bool(
            states and self._edge and self._anything and self.sets.intersection(states, self._edge) != NOTHING
        )

    def asks(self, transition: int) -> bool:
        """Return whether the enabling of a transition of the whole net depends on places of the part."""
        if transition not in self.part.transitions:
            return False
        number, net = self.part.transitions.index(transition), self.part.net
        return any(
            place < len(self.part.places)
            for arcs in (net.pre, net.inhibitor)
            for place, _ in arcs.row(number)
        )

    @property
    def has_levels(self) -> bool:
        """Whether the part has more than one marking."""
        return self._anything

    def consumers(self, place: int) -> list[int]:
        """Return the transitions of the whole net that take tokens from a place of the part."""
        net = self.part.net
        return [
            transition
            for number, transition in enumerate(self.part.transitions)
            if any(taken == place for taken, _ in net.pre.row(number))
        ]

    def restricted(self, transitions: Collection[int]) -> VectorSets | None:
        """Return the steps of some transitions of the whole net; None if they do not change this part."""
        numbers = {
            number for number, transition in enumerate(self.part.transitions) if transition in transitions
        }
        return self._only(frozenset(numbers & {event.transition for event in self.space.encoding.events}))

    def enabled(self, states: int, transition: int) -> int:
        """Return the markings of a set in which this part enables a shown transition of the whole net."""
        firing = self._firing.get(transition)
        if firing is None or not states:
            return NOTHING
        if not self._anything:
            return states
        if transition in self._tests:
            return self._enabled(states, transition)
        return self._made(firing.image, self.anywhere, states, True)

    # single markings, as local states of the diagram's levels

    def some(self, states: int) -> Vector:
        """Return a marking of a set that is not empty."""
        return tuple(self.sets.some_vector(states)) if self._anything else ()

    def contains(self, states: int, marking: Vector) -> bool:
        """Return whether a set has a marking."""
        return self.sets.contains(states, marking) if self._anything else bool(states)

    def tokens(self, marking: Vector) -> list[int]:
        """Return the tokens of each place of a marking."""
        tokens: list[int] = self.space.marking_of(marking)
        return tokens

    def fired(self, marking: Vector, transition: int) -> Vector:
        """Return the marking after a transition of the whole net, which is enabled."""
        net = self.part.net
        tokens = net.fire(self.part.transitions.index(transition), self.tokens(marking))
        levels = self.space.encoding.levels
        return tuple(level.states.index(tuple(tokens[place] for place in level.places)) for level in levels)

    def before(self, states: int, transition: int, marking: Vector) -> Vector | None:
        """Return a marking of a set from which a shown transition, then silent ones, lead to another."""
        firing = self._firing.get(transition)
        if firing is None or not self._anything:
            return None if firing is None else ()
        with Scope(self.space.diagram) as scope:
            last = self.sets.single(marking)
            scope.hold(last, states)
            if self._silent is not None:
                last = self._silent.closure(last, self.anywhere, True)
                scope.hold(last, states)
            if transition in self._tests:
                found = self.sets.intersection(self._enabled(states, transition), last)
            else:
                found = firing.image(last, states, True)
            return self.some(found) if found else None

    def path(self, start: Vector, end: Vector) -> list[int]:
        """Return silent transitions of the whole net that lead from one marking to another, the fewest."""
        if start == end or self._silent is None:
            return []
        diagram = self.space.diagram
        with Scope(diagram) as scope:
            seen = last = self.sets.single(end)
            layers = [last]
            scope.hold(*layers, seen)
            while not self.sets.contains(layers[-1], start):
                new = self.sets.difference(self._silent.image(layers[-1], self.anywhere, True), seen)
                layers.append(new)
                scope.hold(*layers, seen)
                seen = self.sets.union(seen, new)
                scope.hold(*layers, seen)
            path = []
            for layer in reversed(layers[:-1]):
                transition, start = self._into(start, layer)
                path.append(transition)
            return path

    def _into(self, marking: Vector, layer: int) -> tuple[int, Vector]:
        net, tokens = self.part.net, self.tokens(marking)
        for number in sorted(self.part.silent):
            if net.is_enabled(number, tokens):
                transition = self.part.transitions[number]
                following = self.fired(marking, transition)
                if self.sets.contains(layer, following):
                    return transition, following
        raise AssertionError("each layer leads into the one before it")

    def _step(self, states: int, transition: int) -> int:
        firing = self._firing.get(transition)
        if firing is None or not states:
            return NOTHING
        if not self._anything:
            return states
        if transition in self._tests:
            return self._hold(self._made(self._enabled, states, transition))
        return self.closed(self._made(firing.image, states, self.anywhere, False))

    def _enabled(self, states: int, transition: int) -> int:
        """Return the markings of a set that enable a shown transition which changes nothing here."""
        with Scope(self.space.diagram) as scope:
            found = NOTHING
            for masks in self._tests[transition]:
                scope.hold(found, enabled := self.sets.box(masks))
                scope.hold(found, enabled := self.sets.intersection(enabled, states))
                found = self.sets.union(found, enabled)
            return found

    def _made(self, operation: Callable[P, int], *arguments: P.args, **named: P.kwargs) -> int:
        if len(self._kept) > MOST_KEPT:
            raise SetsFullError
        try:
            return operation(*arguments, **named)
        except DiagramMemoryError:
            raise SetsFullError from None

    def _hold(self, states: int) -> int:
        if states > 1 and states not in self._kept:
            self._kept.add(states)
            self.space.diagram.pinned.append(states)
        return states

    def _only(self, transitions: frozenset[int]) -> VectorSets | None:
        return self.sets.restricted(transitions) if transitions else None

    def _edge_box(self) -> int:
        edge, bounds = NOTHING, self.space.encoding.boxes.bounds
        for place, least in self.part.edges.items():
            if least <= bounds[place]:
                for masks in self.space.encoding.masks({place: (least, bounds[place])}):
                    edge = self.sets.union(edge, self.sets.box(masks)) if edge else self.sets.box(masks)
        return edge
