"""Reachable markings by breadth-first search over tuples: plain, slow, and independent of the product."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias, TypeVar

from tests.support.references.flattening import Name, PlainNet

Marking: TypeAlias = tuple[int, ...]


State = TypeVar("State", bound=Hashable)


class TooManyStatesError(ValueError):
    """A system has more states than asked for."""


def explored(
    starts: Iterable[State], successors: Callable[[State], Iterable[State]], most: int
) -> set[State]:
    """Return all states that can be reached from some states.

    Raises
    ------
    TooManyStatesError
        There are more than `most`.
    """
    todo = list(starts)
    known = set(todo)
    while todo:
        for after in successors(todo.pop()):
            if after not in known:
                known.add(after)
                todo.append(after)
        if len(known) > most:
            raise TooManyStatesError
    return known


class TooManyMarkingsError(Exception):
    """There are more markings than asked for."""


@dataclass
class _Transition:
    needs: dict[int, int] = field(default_factory=dict)
    below: dict[int, int] = field(default_factory=dict)
    change: dict[int, int] = field(default_factory=dict)

    def is_enabled(self, marking: Marking) -> bool:
        return all(marking[place] >= tokens for place, tokens in self.needs.items()) and all(
            marking[place] < tokens for place, tokens in self.below.items()
        )

    def fire(self, marking: Marking) -> Marking:
        after = list(marking)
        for place, tokens in self.change.items():
            after[place] += tokens
        return tuple(after)


class ReachabilityGraph:
    """Markings and firings of a net; places in the order of their names as text.

    A read arc counts as a pair of normal arcs. Priorities are not obeyed.
    """

    def __init__(self, net: PlainNet) -> None:
        self.places = sorted(net.places, key=str)
        self.transitions = sorted(net.transitions, key=str)
        self.start: Marking = tuple(net.places[place] for place in self.places)
        number = {place: index for index, place in enumerate(self.places)}
        self._compiled = {name: _Transition() for name in self.transitions}
        for source, target, weight, kind in net.arcs:
            if source in number:
                place, transition = number[source], self._compiled[target]
                if kind == "inhibitor":
                    transition.below[place] = min(weight, transition.below.get(place, weight))
                    continue
                transition.needs[place] = transition.needs.get(place, 0) + weight
                if kind == "normal":
                    transition.change[place] = transition.change.get(place, 0) - weight
            else:
                place, transition = number[target], self._compiled[source]
                transition.change[place] = transition.change.get(place, 0) + weight
        self._touched = self._affected()

    def _affected(self) -> dict[Name, list[Name]]:
        """Return for each transition those that may become enabled or disabled when it fires."""
        tests: dict[int, list[Name]] = {}
        for name, transition in self._compiled.items():
            for place in {*transition.needs, *transition.below}:
                tests.setdefault(place, []).append(name)
        return {
            name: list(
                dict.fromkeys(
                    other
                    for place, tokens in transition.change.items()
                    if tokens
                    for other in tests.get(place, ())
                )
            )
            for name, transition in self._compiled.items()
        }

    def firings(self, limit: int) -> Iterator[tuple[Marking, Name, Marking]]:
        """Yield every firing (before, transition, after), in breadth-first order.

        Raises
        ------
        TooManyMarkingsError
            More than `limit` markings are reachable.
        """
        enabled = frozenset(name for name, each in self._compiled.items() if each.is_enabled(self.start))
        seen = {self.start}
        queue = deque([(self.start, enabled)])
        while queue:
            marking, enabled = queue.popleft()
            for name in sorted(enabled, key=str):
                after = self._compiled[name].fire(marking)
                yield marking, name, after
                if after in seen:
                    continue
                seen.add(after)
                if len(seen) > limit:
                    raise TooManyMarkingsError
                changed = {other: self._compiled[other].is_enabled(after) for other in self._touched[name]}
                kept = (other for other in enabled if changed.get(other, True))
                queue.append((after, frozenset((*kept, *(other for other, now in changed.items() if now)))))

    def successors(self, marking: Marking) -> Iterator[tuple[Name, Marking]]:
        """Yield what can fire in a marking, and the markings that follow."""
        for name, transition in self._compiled.items():
            if transition.is_enabled(marking):
                yield name, transition.fire(marking)

    def markings(self, limit: int) -> set[Marking]:
        """Return all reachable markings."""
        found = {self.start}
        found.update(after for _, _, after in self.firings(limit))
        return found

    def count(self, limit: int = 1_000_000) -> int:
        """Return the number of reachable markings."""
        return len(self.markings(limit))

    def named(self, marking: Marking) -> Mapping[Name, int]:
        """Return a marking by place."""
        return dict(zip(self.places, marking, strict=True))
