"""Callbacks that always end, or not, decided on a part of the net that grows only as far as it has to.

A part is some places and the transitions that change them. Conditions on other places are ignored, so that
the part reaches all markings that the net does, and maybe more. A transition that takes from places of
the part only is *certain*: in the net it can fire wherever it can in the part. So a callback always ends
where certain transitions alone can end it from each marking of the part; and it never ends where no
transition of the part can end it, in a marking that the net reaches. Elsewhere the part is too small: what
blocks the run in the net is added, or what else a transition takes from on whose firing the answer hangs
(see `dineros.analysis.parts`). Histories of topics and nodes that have nothing to do with the callback never
come in.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from dineros.analysis.answers.budget import RAN_OUT, Budget, BudgetExceededError
from dineros.analysis.answers.stages import Share, fairly
from dineros.analysis.callbacks.blocking import without
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import last_marking
from dineros.analysis.parts.part import PARTS_TOO_LARGE, TOO_LARGE, GrowingPart, Whole
from dineros.analysis.symbolic.saturation import DiagramMemoryError

ROUNDS = 80
"""Parts that are tried for each callback."""

WORK = (200_000, 2_000_000)
"""Cache misses of saturation that the markings of a part may cost, in each pass over what is open: a second
is 3 000 000. The last pass is repeated while there is time and callbacks are decided."""

KEPT = 3
"""Parts that are begun with again: those with which callbacks were last proved to end."""

NEAR = Share(time=0.5)
"""Part of the time of a callback in which it begins with such a part."""

NO_BOUND = "it depends on places without a proved bound"
"""Why it is not known whether a callback ends, if no part of the net can have the places that decide it."""

Running = tuple[int, ...]
"""Places of which one is marked from the beginning of a callback to its end."""


@dataclass(frozen=True)
class Ending:
    """Whether a callback that has begun can always end."""

    status: Literal["ends", "waits", "unknown"]
    """``ends``: it can end; ``waits``: it can wait forever; ``unknown``: that is not known."""
    trace: tuple[int, ...] = ()
    """Transitions of the net that lead to where it never ends."""
    is_limited: bool = False
    """Whether it is not known because a limit of time or work was exceeded."""
    reason: str = ""
    """Why it is not known; empty if it is."""


def why_unknown(endings: Iterable[Ending]) -> str:
    """Return why some endings are not known: a limit of time or memory first, as more of it may help."""
    reasons = [each.reason for each in endings if each.status == "unknown"]
    return next((limit for limit in RAN_OUT.values() if limit in reasons), reasons[0] if reasons else "")


class Endings:
    """Decides of callbacks of a net whether they always end."""

    def __init__(self, net: CompiledNet) -> None:
        self._whole = Whole(net)
        self._places: dict[Running, set[int]] = {}
        self._kept: list[set[int]] = []

    def of_all(self, asked: Iterable[Running], budget: Budget) -> dict[Running, Ending]:
        """Decide it of several callbacks.

        In each pass, the time that is left is divided again among those that are open, so that what one of
        them does not need is there for the others.
        """
        budget, found, passed = budget.begun(), dict[Running, Ending](), 0
        left = list(dict.fromkeys(asked))
        while left:
            work = WORK[min(passed, len(WORK) - 1)]
            for running, share in fairly(left, budget):
                found[running] = self.of(running, share, work)
            before, left = len(left), [each for each in left if found[each].is_limited]
            passed += 1
            if passed >= len(WORK) and (budget.left is None or budget.is_over or len(left) == before):
                break
        return found

    def at_once(self, running: Running, budget: Budget) -> Ending | None:
        """Decide it of one callback by its smallest part; None: that part does not decide it."""
        if not set(running) <= self._whole.free.keys():
            return None
        return self._grown(running, self._part_of(running), budget, WORK[0], rounds=1)

    def _part_of(self, running: Running) -> set[int]:
        if running not in self._places:
            self._places[running] = self._whole.grown(running)
        return self._places[running]

    def of(self, running: Running, budget: Budget, work: int = WORK[-1]) -> Ending:
        """Decide it of one callback; a later call continues with the part that was reached.

        Parameters
        ----------
        running : tuple of int
            Places of which one is marked from its beginning to its end.
        work : int
            Cache misses of saturation that the markings of a part may cost.
        """
        whole = self._whole
        if not set(running) <= whole.free.keys():
            return Ending("unknown", reason=NO_BOUND)
        places = self._part_of(running)
        found = self._grown(running, places, budget, work, rounds=1)
        near = next((each for each in self._kept if each.issuperset(running)), None)
        if found is None and near is not None:
            # Callbacks of one node, or slots of one action, need much of the same.
            share = NEAR.share(budget)
            found = self._grown(running, near | places, share, work)
            if found is not None and found.status == "unknown":
                found = None
        if found is None:
            found = self._grown(running, places, budget, work)
        return found or Ending("unknown", reason=PARTS_TOO_LARGE)

    def _grown(
        self, running: Running, places: set[int], budget: Budget, work: int, rounds: int = ROUNDS
    ) -> Ending | None:
        """Enlarge a part in place until it decides; None if that takes more rounds."""
        whole = self._whole
        try:
            for _ in range(rounds):
                budget.check_time()
                part = _RefinedPart(whole, places, running, budget, work)
                if not part.doomed:
                    self._kept = [set(places), *self._kept][:KEPT]
                    return Ending("ends")
                more = part.missing()
                if more is None:
                    last_marking(whole.net, part.trace)
                    return Ending("waits", part.trace)
                known = whole.grown(whole.free.keys() & more) - places
                if not known:
                    return Ending("unknown", reason=NO_BOUND)
                places |= known
        except BudgetExceededError as limit:
            reason = RAN_OUT["time"] if budget.is_over else str(limit)
            return Ending("unknown", is_limited=True, reason=reason)
        except DiagramMemoryError:
            return Ending("unknown", reason=RAN_OUT["memory"])
        except TOO_LARGE:
            return Ending("unknown", reason=PARTS_TOO_LARGE)
        return None


class _RefinedPart(GrowingPart):
    """A part of the net: what it reaches, and where the callback cannot be proved to end."""

    def __init__(
        self, whole: Whole, places: set[int], running: Running, budget: Budget, most_work: int
    ) -> None:
        super().__init__(whole, places, (), budget, most_work)
        sets, order = self.sets, sorted(places)
        self._ended = without(sets, map(order.index, running))
        certain = [n for n, transition in enumerate(self.transitions) if self.is_certain(transition)]
        for number in certain:
            self._ended = sets.union(
                self._ended, sets.intersection(sets.everything, self._impossible(number))
            )
        ending = sets.sets.restricted(frozenset(certain)).closure(
            self._ended, sets.everything, backwards=True
        )
        self.space.diagram.pinned.append(ending)
        self.doomed = sets.complement(ending)

    def _impossible(self, number: int) -> int:
        """Return markings in which only free room keeps a certain transition from firing: the net has none.

        It could fire there, and then a place would hold more than it ever does.
        """
        net, encoding, found = self.net, self.space.encoding, 0
        bounds, own = encoding.boxes.bounds, len(self.places)
        guard = {place: (0, weight - 1) for place, weight in net.inhibitor.row(number)}
        rooms = [(place, weight) for place, weight in net.pre.row(number) if place >= own]
        for place, weight in net.pre.row(number):
            if place < own:
                guard[place] = (weight, min(bounds[place], guard.get(place, (0, bounds[place]))[1]))
        for place, weight in rooms:
            box = {**guard, place: (0, min(weight - 1, bounds[place]))}
            if all(low <= high for low, high in box.values()):
                for masks in encoding.masks(box):
                    found = self.sets.union(found, self.sets.sets.box(masks))
        return found

    @cached_property
    def _hopeless(self) -> int:
        """Markings from which nothing at all ends the callback."""
        return self.sets.complement(self.sets.some_until(self.sets.everything, self._ended))

    @cached_property
    def _way(self) -> tuple[int, ...]:
        """A way to a marking from which no certain transitions end the callback, others do if possible."""
        sets = self.sets
        hopeful = sets.sets.difference(self.doomed, self._hopeless)
        sets.space.diagram.pinned.append(hopeful)
        return sets.way_to(hopeful or self.doomed)

    @property
    def trace(self) -> tuple[int, ...]:
        """The same way, as transitions of the whole net."""
        return tuple(self.transitions[number] for number in self._way)

    def missing(self) -> set[int] | None:
        """Return places on which it hangs whether the callback ends, or comes that far at all.

        None: the net comes that far, and the callback never ends from there.
        """
        _, blocking = self.whole.lifted(self.trace)
        if blocking:
            return blocking
        last = tuple(last_marking(self.net, self._way))
        if self.sets.contains(self._hopeless, last):
            return None
        ending = (self.transitions[number] for number in self.sets.way_between(last, self._ended))
        doubtful = (self.whole.takes(t) for t in ending if not self.is_certain(t))
        return set().union(*doubtful) - self.places
