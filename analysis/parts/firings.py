"""Which transitions can fire, and whether there is a deadlock, decided on parts of a net."""

from __future__ import annotations

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.stages import Share, fairly
from dineros.analysis.covering.firings import Firings
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import last_marking
from dineros.analysis.parts.part import TOO_LARGE, GrowingPart, Whole

ROUNDS = 150
"""Parts that are tried for each question."""

WORK = (200_000, 2_000_000)
"""Cache misses of saturation that a part may cost, in each pass over what is open: a second is 3 000 000."""

START_WORK = 50_000
"""Cache misses that one first part of the proof of deadlock freedom may cost."""

MOST_STARTS = 40
"""Maximum number of first parts that are tried for the proof of deadlock freedom."""

FIRINGS = Share(time=0.7)
"""Share of the firings; the rest is for the question whether there is a deadlock."""


def decide_by_parts(net: CompiledNet, found: Firings, budget: Budget) -> None:
    """Add to what is known which transitions can fire, and whether there is a deadlock."""
    budget = budget.begun()
    budget.stage("parts of the net")
    whole = Whole(net, found.dead)
    search = _Search(whole, found)
    search.note_dead()
    search.decide_firings(FIRINGS.share(budget))
    if found.deadlock is None and not found.has_no_deadlock:
        search.decide_deadlock(budget)


class _Search:
    def __init__(self, whole: Whole, found: Firings) -> None:
        self.whole, self.found = whole, found
        self._places: dict[int, set[int]] = {}

    @property
    def _open(self) -> list[int]:
        return [t for t in range(len(self.whole.net.transitions)) if self.found.is_open(t)]

    def note_dead(self) -> None:
        """Keep what is proved never to fire."""
        self.found.dead |= {t for t in self.whole.dead if self.found.is_open(t)}

    def decide_firings(self, budget: Budget) -> None:
        """Decide each open transition, cheap ones first."""
        for work in WORK:
            for t, share in fairly(self._open, budget, factor=2.0):
                if share.is_over:
                    return
                if self.found.is_open(t):
                    self._decide(t, share, work)

    def _decide(self, transition: int, budget: Budget, work: int) -> None:
        """Enlarge a part until it proves that a transition never fires, or shows a run that fires it."""
        whole = self.whole
        if not whole.lifted((transition,))[1]:
            self._note_way((transition,))
            return
        places = self._places.setdefault(transition, whole.grown(whole.takes(transition)))
        if not places:
            return
        for _ in range(ROUNDS):
            if budget.is_over:
                return
            asked = [t for t in self._open if whole.takes(t) & places or t == transition]
            try:
                part = GrowingPart(whole, places, asked, budget, work)
                dead = [t for t in part.transitions if self.found.is_open(t) and part.is_dead(t)]
                if dead:
                    whole.prove_dead(dead)
                    self.note_dead()
                if transition in whole.dead:
                    return
                way = (*part.way_to_enabled(transition), transition)
            except TOO_LARGE:
                return
            _, blocking = whole.lifted(way)
            if not blocking:
                self._note_way(way)
                return
            more = whole.grown(blocking & whole.free.keys()) - places
            if not more:
                return  # a place without a known bound is in the way
            places |= more

    def _note_way(self, way: tuple[int, ...]) -> None:
        last_marking(self.whole.net, way)
        for end, transition in enumerate(way, 1):
            if self.found.is_open(transition):
                self.found.note(transition, way[:end])

    def decide_deadlock(self, budget: Budget) -> None:
        """Find a part whose every marking enables what fires in the net, or a run to a deadlock.

        A part begins with the input places of one enabled transition. One node that can always continue is
        enough; its part stays small.
        """
        whole, net = self.whole, self.whole.net
        count, initial = range(len(net.transitions)), net.initial.tolist()
        if any(not whole.takes(t) for t in count if t not in whole.dead):
            self.found.has_no_deadlock = True
            return
        enabled = [t for t in count if net.is_enabled(t, initial)]
        starts = {frozenset(whole.grown(whole.takes(t))) for t in enabled if self._has_bounds(t)}
        tried = sorted(starts, key=lambda places: (len(places), sorted(places)))[:MOST_STARTS]
        for places, share in fairly(tried, budget, kept=len(tried)):
            self._decide_deadlock(set(places), share, START_WORK)
            if self.found.has_no_deadlock or self.found.deadlock is not None:
                return
        self._decide_deadlock(set(), budget, WORK[-1])

    def _has_bounds(self, transition: int) -> bool:
        return self.whole.takes(transition) <= self.whole.free.keys()

    def _decide_deadlock(self, places: set[int], budget: Budget, work: int) -> None:
        """Enlarge a part until each of its markings enables what fires in the net, or a run ends there."""
        whole, net = self.whole, self.whole.net
        for _ in range(ROUNDS):
            if budget.is_over:
                return
            way: tuple[int, ...] = ()
            if places:
                try:
                    asked = [t for t in range(len(net.transitions)) if whole.takes(t) <= places]
                    part = GrowingPart(whole, places, asked, budget, work)
                    certain = [n for n, t in enumerate(part.transitions) if part.is_certain(t)]
                    masks = [mask for number in certain for mask in part.space.event_masks(number)]
                    stuck = part.sets.sets.without_boxes(part.sets.everything, masks)
                    part.space.diagram.pinned.append(stuck)
                    if not stuck:
                        self.found.has_no_deadlock = True
                        return
                    way = part.way_to(stuck)
                except TOO_LARGE:
                    return
            marking, blocking = whole.lifted(way)
            if not blocking:
                enabled = [t for t in range(len(net.transitions)) if net.is_enabled(t, marking)]
                if not enabled:
                    last_marking(net, way)
                    self.found.deadlock = way
                    return
                blocking = self._next(enabled, places)
            more = whole.grown(blocking & whole.free.keys()) - places
            if not more:
                return
            places |= more

    def _next(self, enabled: list[int], places: set[int]) -> set[int]:
        """Return the input places of one of these transitions: one that extends a part by few places."""
        whole = self.whole
        choices = [t for t in enabled if self._has_bounds(t)]

        def cost(t: int) -> tuple[bool, int]:
            own = whole.takes(t) | whole.net.delta[t].keys()
            return own.isdisjoint(places), len(whole.grown(whole.takes(t)) - places)

        return whole.takes(min(choices, key=cost)) if choices else set()
