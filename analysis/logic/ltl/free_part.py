"""A set of places that only its movers change, with its markings: see `free_parts`."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

from dineros.analysis.nets.compiled import CompiledNet

LARGEST_PART = 64
"""Maximum number of markings of a free part."""

#: Tokens of a part's places.
Local = tuple[int, ...]
#: Arcs of one kind: place -> weight.
Arcs = Mapping[int, int]


@dataclass(frozen=True)
class PlaceConditions:
    """The conditions of a transition on some places."""

    inputs: Arcs
    inhibitors: Arcs

    @classmethod
    def of(cls, net: CompiledNet, transition: int, is_asked: Callable[[int], bool]) -> PlaceConditions:
        """Return a transition's conditions on the places asked for."""
        return cls(
            {p: w for p, w in net.pre.row(transition) if is_asked(p)},
            {p: w for p, w in net.inhibitor.row(transition) if is_asked(p)},
        )

    def implies(self, other: PlaceConditions) -> bool:
        """Whether these conditions imply all of another object's conditions."""
        return all(self.inputs.get(p, 0) >= w for p, w in other.inputs.items()) and all(
            self.inhibitors.get(p, w + 1) <= w for p, w in other.inhibitors.items()
        )

    def are_met(self, tokens: Mapping[int, int] | Sequence[int]) -> bool:
        """Whether a marking fulfils the conditions."""
        return all(tokens[p] >= w for p, w in self.inputs.items()) and all(
            tokens[p] < w for p, w in self.inhibitors.items()
        )

    @property
    def key(self) -> tuple[tuple[tuple[int, int], ...], tuple[tuple[int, int], ...]]:
        """The conditions, as something to look up."""
        return tuple(sorted(self.inputs.items())), tuple(sorted(self.inhibitors.items()))


@dataclass(frozen=True, eq=False)
class FreePart:
    """A set of places that only its movers change.

    Attributes
    ----------
    outside : mapping
        Mover -> its conditions on other places.
    graph : mapping
        Tokens of the places -> mover -> tokens after it, if its other conditions hold.
    """

    places: tuple[int, ...]
    movers: tuple[int, ...]
    outside: Mapping[int, PlaceConditions]
    graph: Mapping[Local, Mapping[int, Local]]

    @classmethod
    def of(cls, net: CompiledNet, places: tuple[int, ...], movers: tuple[int, ...]) -> FreePart | None:
        """Return a part with its markings; None if it has too many."""
        position = {place: at for at, place in enumerate(places)}
        inner = {t: PlaceConditions.of(net, t, position.__contains__) for t in movers}
        outside = {t: PlaceConditions.of(net, t, lambda p: p not in position) for t in movers}
        graph: dict[Local, dict[int, Local]] = {}
        todo = [tuple(int(net.initial[p]) for p in places)]
        while todo:
            here = todo.pop()
            if here in graph:
                continue
            if len(graph) == LARGEST_PART:
                return None
            tokens = dict(zip(places, here, strict=True))
            graph[here] = {
                t: tuple(tokens[p] + net.delta[t].get(p, 0) for p in places)
                for t in movers
                if inner[t].are_met(tokens)
            }
            todo += graph[here].values()
        return cls(places, movers, outside, graph)

    def driving(
        self, net: CompiledNet, transition: int, start: Local, free: Collection[int], is_to_hold: bool
    ) -> list[int] | None:
        """Return movers after which the part fulfils, or violates, a transition's conditions.

        The transition's conditions on places that are not free hold. None if no movers do this.
        """
        test = PlaceConditions.of(net, transition, self.places.__contains__)
        others = PlaceConditions.of(net, transition, lambda p: p not in free)
        return self._way(start, others, lambda tokens: test.are_met(tokens) is is_to_hold)

    def _way(
        self, start: Local, allowed: PlaceConditions, is_goal: Callable[[Mapping[int, int]], bool]
    ) -> list[int] | None:
        """Return movers that lead to a goal while `allowed` holds; None if no sequence of movers does."""
        found: dict[Local, list[int]] = {start: []}
        queue = deque([start])
        while queue:
            here = queue.popleft()
            if is_goal(dict(zip(self.places, here, strict=True))):
                return found[here]
            for mover, there in self.graph[here].items():
                if there not in found and allowed.implies(self.outside[mover]):
                    found[there] = [*found[here], mover]
                    queue.append(there)
        return None
