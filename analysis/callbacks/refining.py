"""Callbacks that always end, or not, decided on a part of the net that grows only as far as it has to.

A part is some places and the transitions that change them. What other places would allow is not asked, so
that the part reaches all markings that the net does, and maybe more. A transition that takes from places of
the part only is *certain*: in the net it can fire wherever it can in the part. So a callback always ends
where certain transitions alone can end it from each marking of the part; and it never ends where no
transition of the part can end it, in a marking that certain ones lead to. Elsewhere the part is too small:
what else a transition takes from on whose firing the answer hangs is added (E. Clarke et al.,
*Counterexample-guided abstraction refinement for symbolic model checking*, JACM 50(5), 2003). Histories of
topics and nodes that have nothing to do with the callback never come in.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.callbacks.blocking import without
from dineros.analysis.logic.ctl.symbolic_sets import SymbolicSets
from dineros.analysis.nets.bounds import flows_and_bounds
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import replay
from dineros.analysis.reductions.cut_out import cut_out
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.analysis.symbolic.levels import LevelSizeError
from dineros.analysis.symbolic.saturation import DiagramMemoryError

ROUNDS = 40
"""Parts that are tried for each callback."""

MOST_WORK = 2_000_000
"""Cache misses of saturation, a second or so, that the markings of a part may cost."""


@dataclass(frozen=True)
class Ending:
    """Whether a callback that has begun can always end.

    Attributes
    ----------
    status : {"ends", "waits", "unknown"}
        It can; it can wait forever; that is not known.
    trace : tuple of int
        Transitions of the net that lead to where it never ends.
    """

    status: Literal["ends", "waits", "unknown"]
    trace: tuple[int, ...] = ()


class Endings:
    """Decides of callbacks of a net whether they always end.

    Parameters
    ----------
    net : CompiledNet
        The net.
    """

    def __init__(self, net: CompiledNet) -> None:
        self._net = net
        bounds = net.once(flows_and_bounds)[1]
        self._free = {p: b.value - int(net.initial[p]) for p, b in enumerate(bounds) if b is not None}
        count = range(len(net.transitions))
        self._takes = [{p for arcs in (net.pre, net.inhibitor) for p, _ in arcs.row(t)} for t in count]

    def of(self, running: tuple[int, ...], budget: Budget) -> Ending:
        """Decide it of one callback.

        Parameters
        ----------
        running : tuple of int
            Places of which one is marked from its beginning to its end.
        budget : Budget
            Time and memory.
        """
        places = set(running)
        if not places <= self._free.keys():
            return Ending("unknown")
        try:
            for _ in range(ROUNDS):
                budget.check_time()
                part = _RefinedPart(self, sorted(places), running, budget)
                if not part.doomed:
                    return Ending("ends")
                more = part.missing()
                if not more:
                    replay(self._net, part.trace)
                    return Ending("waits", part.trace)
                known = self._free.keys() & more
                if not known:
                    break
                places |= known
        except (BudgetExceededError, LevelSizeError, DiagramMemoryError):
            pass
        return Ending("unknown")

    def users(self, places: Iterable[int]) -> list[int]:
        """Return the transitions that change some of the places."""
        return sorted(set().union(*(self._net.changing[place] for place in places)))

    def part(self, places: Sequence[int], transitions: Sequence[int]) -> CompiledNet:
        """Return a part of the net."""
        return cut_out(self._net, places, transitions, self._free)

    def missing(self, transitions: Iterable[int], places: set[int]) -> set[int]:
        """Return what transitions take from that is not among the places."""
        return set().union(*(self._takes[transition] for transition in transitions)) - places


class _RefinedPart:
    """A part of the net: what it reaches, and where the callback cannot be proved to end."""

    def __init__(self, whole: Endings, places: list[int], running: tuple[int, ...], budget: Budget) -> None:
        self._whole = whole
        self._places = set(places)
        self._transitions = whole.users(places)
        self._net = whole.part(places, self._transitions)

        def stop(work: int) -> None:
            if work > MOST_WORK:
                raise BudgetExceededError("a part of the net is too large")

        space = symbolic_state_space(self._net, budget, between=stop)
        if not space.complete:
            raise BudgetExceededError(space.reason)
        self._sets = sets = SymbolicSets(space, budget=budget)
        self._ended = without(sets, map(places.index, running))
        certain = [
            n
            for n, transition in enumerate(self._transitions)
            if not whole.missing([transition], self._places)
        ]
        for number in certain:
            self._ended = sets.union(
                self._ended, sets.intersection(sets.everything, self._impossible(number))
            )
        ending = sets.sets.restricted(frozenset(certain)).closure(
            self._ended, sets.everything, backwards=True
        )
        space.diagram.pinned.append(ending)
        self.doomed = sets.complement(ending)

    def _impossible(self, number: int) -> int:
        """Return markings in which only free room keeps a certain transition from firing: the net has none.

        It could fire there, and then a place would hold more than it ever does.
        """
        net, encoding, found = self._net, self._sets.space.encoding, 0
        bounds, own = encoding.boxes.bounds, len(self._places)
        guard = {place: (0, weight - 1) for place, weight in net.inhibitor.row(number)}
        rooms = [(place, weight) for place, weight in net.pre.row(number) if place >= own]
        for place, weight in net.pre.row(number):
            if place < own:
                guard[place] = (weight, min(bounds[place], guard.get(place, (0, bounds[place]))[1]))
        for place, weight in rooms:
            box = {**guard, place: (0, min(weight - 1, bounds[place]))}
            if all(low <= high for low, high in box.values()):
                for masks in encoding.masks(box):
                    found = self._sets.union(found, self._sets.sets.box(masks))
        return found

    @cached_property
    def _hopeless(self) -> int:
        """Markings from which nothing at all ends the callback."""
        return self._sets.complement(self._sets.some_until(self._sets.everything, self._ended))

    @cached_property
    def _way(self) -> tuple[int, ...]:
        """A way to a marking from which no certain transitions end the callback, others do if possible."""
        sets = self._sets
        hopeful = sets.sets.difference(self.doomed, self._hopeless)
        sets.space.diagram.pinned.append(hopeful)
        return sets.way_to(hopeful or self.doomed)

    @property
    def trace(self) -> tuple[int, ...]:
        """The same way, as transitions of the whole net."""
        return tuple(self._transitions[number] for number in self._way)

    def missing(self) -> set[int]:
        """Return places on which it hangs whether the callback ends, or comes that far at all; or none."""
        last = tuple(replay(self._net, self._way)[-1])
        doubtful = self._way
        if not self._sets.contains(self._hopeless, last):
            doubtful = self._sets.way_between(last, self._ended)
        return self._whole.missing((self._transitions[number] for number in doubtful), self._places)
