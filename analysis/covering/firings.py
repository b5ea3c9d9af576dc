"""Finds the transitions that can fire, and deadlocks, in nets whose state space may be infinite.

Firings near the initial marking are found together by a breadth-first search, and by first random walks. The
remaining transitions are proved dead by the tree of Karp and Miller, or searched for one by one, forward and
backward, guided by the state equation. Each stage has a share of the budget; undecided transitions stay open.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.stages import Stage, fairly, run_stages
from dineros.analysis.covering.backward import Backward
from dineros.analysis.covering.bounded_part import bounded_part
from dineros.analysis.covering.directed import MOST_MARKINGS, Directed
from dineros.analysis.covering.growing import Limited, without_growth
from dineros.analysis.covering.tree import Tree, tree_of
from dineros.analysis.explicit import Goal, find_all
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.structure import never_possible
from dineros.analysis.nets.witness import last_marking
from dineros.analysis.walks.first_round import first_round
from dineros.analysis.walks.scouting import short_way

NEAR = 200_000
"""Maximum number of markings of the breadth-first search."""

FEW_MARKINGS = 10_000
"""Maximum number of markings of a search for one transition before the tree of Karp and Miller is built."""

NEAR_BYTES = 512 << 20
"""Bytes of its tables."""

WayTo = Callable[[int, Budget], tuple[tuple[int, ...] | None, bool]]
"""A search for one transition: a firing sequence that ends with it; whether the search is exhaustive."""

_REASONS = {
    "unbounded": "there are infinitely many markings",
    "states": "there are too many markings",
    "memory": "memory ran out",
    "time": "time ran out",
}


@dataclass
class Firings:
    """The known facts about firings.

    Attributes
    ----------
    traces : dict of int to tuple of int
        For each transition that can fire, a firing sequence that ends with it; see `way_to`.
    possible : frozenset of int
        Transitions proved to be able to fire, perhaps without a known sequence.
    has_no_deadlock : bool
        True if the absence of deadlocks is proved; False means unknown.
    is_complete : bool
        Whether all markings were visited, up to differences that affect no transition.
    tree : Tree or None
        Result of the tree of Karp and Miller for the net without places that only grow.
    reason : str
        Why the search for all markings ended.
    is_late : bool
        Whether a later stage had too little time, or none.
    """

    traces: dict[int, tuple[int, ...]] = field(default_factory=dict)
    possible: frozenset[int] = frozenset()
    dead: set[int] = field(default_factory=set)
    deadlock: tuple[int, ...] | None = None
    has_no_deadlock: bool = False
    is_complete: bool = False
    tree: Tree | None = None
    reason: str = ""
    is_late: bool = False
    net: CompiledNet | None = None
    _long: set[int] = field(default_factory=set)

    def note(self, transition: int, trace: tuple[int, ...]) -> None:
        """Record a firing sequence, which may contain detours."""
        self.traces[transition] = trace
        self._long.add(transition)

    def way_to(self, transitions: Iterable[int]) -> tuple[int, ...]:
        """Return a sequence that ends with one of some transitions, without unnecessary firings."""
        t = min((t for t in transitions if t in self.traces), key=lambda t: len(self.traces[t]))
        if t in self._long and self.net is not None:
            self._long.discard(t)
            self.traces[t] = short_way(self.net, self.traces[t])
        return self.traces[t]

    @property
    def why_open(self) -> str:
        """Reason of open questions, as text."""
        whys = [_REASONS.get(self.reason, self.reason), _REASONS["time"] if self.is_late else ""]
        return ", and ".join(dict.fromkeys(filter(None, whys)))

    def is_open(self, transition: int) -> bool:
        """Whether it is unknown if a transition can fire."""
        return not any(transition in known for known in (self.traces, self.possible, self.dead))


def firings(
    net: CompiledNet,
    budget: Budget,
    wanted: Iterable[int] | None = None,
    asks_deadlock: bool = True,
    known: Firings | None = None,
) -> Firings:
    """Find the transitions that can fire, and a deadlock.

    Parameters
    ----------
    wanted : iterable of int, optional
        The transitions in question; all by default.
    known : Firings, optional
        Result of `near_firings` for the same question.
    """
    budget = budget.begun()
    search = _FiringSearch(net, range(len(net.transitions)) if wanted is None else wanted, asks_deadlock)
    if known is not None:
        search.found = known
    run_stages(search, (*(NEAR_PLAN if known is None else ()), *FAR_PLAN), budget)
    search.found.is_late |= budget.is_over
    return search.found


def near_firings(net: CompiledNet, budget: Budget) -> Firings:
    """Run the cheap stages of `firings`, which find near transitions that can fire, and near deadlocks."""
    search = _FiringSearch(net, range(len(net.transitions)), asks_deadlock=True)
    return run_stages(search, NEAR_PLAN, budget).found


class _FiringSearch:
    def __init__(self, net: CompiledNet, wanted: Iterable[int], asks_deadlock: bool) -> None:
        self.net, self.wanted = net, list(wanted)
        self.asks_deadlock = asks_deadlock
        self.small = without_growth(net) or Limited.same(net)
        self.images = self.small.images()
        never = never_possible(net)
        self.found = Firings(dead={t for t in self.wanted if t not in self.images or t in never}, net=net)

    def look_near(self, budget: Budget) -> None:
        """Search breadth first for all transitions."""
        asked = self._open
        goals = [Goal.enabled(self.small.net, *self.images[t]) for t in asked]
        deadlock = [Goal.deadlock()] if self.asks_deadlock else []
        all_answers = find_all(self.small.net, [*goals, *deadlock], budget)
        answers = all_answers[: len(goals)]
        found = self.found
        for t, answer in zip(asked, answers, strict=True):
            if answer.trace is not None:
                found.traces[t] = self._back(answer.trace, t)
            elif answer.status == "unreachable":
                found.dead.add(t)
        for answer in all_answers[len(goals) :]:
            found.deadlock = None if answer.trace is None else self.small.back(answer.trace)
            found.has_no_deadlock = answer.status == "unreachable"
        unknown = [answer for answer in all_answers if answer.status == "unknown"]
        found.is_complete = not unknown
        found.reason = unknown[0].reason if unknown else ""
        if found.reason == "interrupted":
            raise KeyboardInterrupt

    def look_around(self, budget: Budget) -> None:
        """Walk to the remaining transitions."""
        found, asked = self.found, self._open
        numbers = [image for t in asked for image in self.images[t]]
        met = first_round(self.small.net, budget, numbers, not self._knows_deadlock)
        for t in asked:
            ways = [met.ways[image] for image in self.images[t] if image in met.ways]
            if ways:
                found.note(t, self._back(min(ways, key=len)[:-1], t))
        if met.deadlock is not None and not self._knows_deadlock:
            found.deadlock = self.small.back(met.deadlock)

    def look_at_bounds(self, budget: Budget) -> None:
        """Prove facts by the bounded places alone."""
        found, part = self.found, bounded_part(self.small.net, budget)
        found.dead |= {t for t in self._open if part.dead.issuperset(self.images[t])}
        found.has_no_deadlock |= self.asks_deadlock and part.has_no_deadlock

    def make_tree(self, budget: Budget) -> None:
        """Prove transitions dead by the tree of Karp and Miller."""
        tree = self.found.tree = tree_of(self.small.net, budget)
        self.found.is_late |= budget.is_over
        self.found.dead |= {t for t in self._open if tree.dead.issuperset(self.images[t])}

    def look_ahead(self, budget: Budget) -> None:
        """Search forward for each remaining transition, guided by the state equation, among few markings."""
        self._look_forward(FEW_MARKINGS, budget)

    def look_far(self, budget: Budget) -> None:
        """Search forward for each remaining transition among many markings."""
        self._look_forward(MOST_MARKINGS, budget)

    def _look_forward(self, most: int, budget: Budget) -> None:
        directed = Directed(self.small.net)
        self._look_for_each(lambda image, share: directed.way_to(image, share, most), budget)

    def look_back(self, budget: Budget) -> None:
        """Search backward for each remaining transition; this decides if numbers stay small."""
        self._look_for_each(Backward(self.small.net).way_to, budget)

    def _look_for_each(self, way_to: WayTo, budget: Budget) -> None:
        for t, share in fairly(self._open, budget, factor=0.5):
            if share.is_over:
                return
            ends = True
            for image in self.images[t]:
                trace, is_complete = way_to(image, share)
                ends = ends and is_complete
                self.found.is_late |= not is_complete and share.is_over
                if trace is not None:
                    self.found.note(t, self._back(trace[:-1], t))
                    break
            else:
                if ends:
                    self.found.dead.add(t)

    @property
    def asks_firings(self) -> bool:
        """Whether it is unknown of some transition if it can fire."""
        return bool(self._open)

    @property
    def asks_anything(self) -> bool:
        """Whether something is unknown."""
        return self.asks_firings or not self._knows_deadlock

    @property
    def _knows_deadlock(self) -> bool:
        found = self.found
        return not self.asks_deadlock or found.deadlock is not None or found.has_no_deadlock

    @property
    def _open(self) -> list[int]:
        return [t for t in self.wanted if self.found.is_open(t)]

    def _back(self, trace: Sequence[int], transition: int) -> tuple[int, ...]:
        """Return a replayed sequence of the original net."""
        own = (*self.small.back(trace), transition)
        last_marking(self.net, own)
        return own


NEAR_PLAN = (
    Stage(_FiringSearch.look_near, time=0.4, most_bytes=NEAR_BYTES, most_states=NEAR),
    Stage(_FiringSearch.look_around, lambda search: search.asks_anything),
)
"""The cheap stages."""

FAR_PLAN = (
    Stage(_FiringSearch.look_ahead, lambda search: search.asks_firings),
    Stage(_FiringSearch.look_at_bounds, lambda search: search.asks_anything, time=0.3, memory=0.5),
    Stage(_FiringSearch.make_tree, lambda search: search.asks_firings, time=0.5),
    Stage(_FiringSearch.look_back, lambda search: search.asks_firings),
    Stage(_FiringSearch.look_far, lambda search: search.asks_firings),
)
"""The stages for what is left."""
