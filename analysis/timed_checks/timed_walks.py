"""Random runs of a time Petri net: what they meet can happen, however many state classes there are.

A run has concrete times. Each step draws one of the transitions that can fire next, and a moment at which it
can. So each run is one of the net with its times, and needs no further check of its schedule. Events that
the runs do not show may still happen.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from functools import partial
from random import Random

from dineros.analysis.answers.budget import Budget
from dineros.analysis.timed.exploring import Trace
from dineros.analysis.timed.nets import TimedNet

RUNS = 24
"""Runs that are drawn."""

STEPS = 2_000
"""Firings of each."""

LATE_RUNS, LATE_STEPS = 2, 20_000
"""Runs in which everything takes as long as it can, and firings of each: some queues fill up slowly."""

TRIES = 4
"""Runs for a transition that no run has fired yet."""

RIVAL_STEPS = 3
"""Transitions from one whose tokens are taken away to one that is slow."""

FINE = 8
"""Parts of the net's unit in which moments are counted: a bound that is left out is missed by one part."""


class TimedRun:
    """A run that has begun: its marking, and since when each transition is enabled.

    Attributes
    ----------
    marking : list of int
    now : int
        The time, in parts of the net's unit.
    transitions : int
        How many the net has.
    """

    def __init__(self, net: TimedNet) -> None:
        self._net = net
        self.transitions = len(net.untimed.transitions)
        self.marking: list[int] = net.untimed.initial.tolist()
        self.now = 0
        self._earliest: list[int] = []
        self._latest: list[int | None] = []
        for interval in net.intervals:
            self._earliest.append(int(interval.earliest / net.unit) * FINE + interval.is_open_below)
            latest = interval.latest
            self._latest.append(
                None if latest is None else int(latest / net.unit) * FINE - interval.is_open_above
            )
        self._lookers: list[list[int]] = [[] for _ in net.untimed.places]
        for transition in range(self.transitions):
            for place in net.untimed.tested(transition):
                self._lookers[place].append(transition)
        self._since = {t: 0 for t in range(self.transitions) if net.untimed.is_enabled(t, self.marking)}

    @property
    def is_over(self) -> bool:
        """Whether nothing is enabled any more."""
        return not self._since

    def step(self, draw: Random, is_hasty: bool, slow: AbstractSet[int] = frozenset()) -> int | None:
        """Fire a transition, and return which; None if no moment is left in which one can.

        Parameters
        ----------
        is_hasty : bool
            Whether one of those fires that can first, as soon as it can.
        slow : set of int
            Transitions that fire only when no other one can.
        """
        since, now = self._since, self.now
        limits = [start + late for t, start in since.items() if (late := self._latest[t]) is not None]
        last = min(limits, default=None)
        moments = {t: max(now, start + self._earliest[t]) for t, start in since.items()}
        ready = [t for t, moment in moments.items() if last is None or moment <= last]
        if not ready:
            return None
        ready = [t for t in ready if t not in slow] or ready
        if is_hasty:
            first = min(moments[t] for t in ready)
            ready = [t for t in ready if moments[t] == first]
        chosen = draw.choice(ready)
        moment = moments[chosen]
        if not is_hasty and draw.random() < 0.5:
            end = last if last is not None else moment + max(self._earliest, default=0) + FINE
            moment = draw.randint(moment, max(moment, end))
        return self._fire_at(chosen, moment, moments, draw)

    def step_late(self, draw: Random) -> int | None:
        """Fire a transition that has to fire first, as late as it can, and return which.

        What may wait without end never fires as long as anything has to. Returns None if nothing can fire.

        `draw`: draws one of those that have to fire at the same moment.
        """
        latest = self._latest
        limits = {t: start + late for t, start in self._since.items() if (late := latest[t]) is not None}
        if not limits:
            return self.step(draw, is_hasty=True)
        last = min(limits.values())
        moments = {t: max(self.now, start + self._earliest[t]) for t, start in self._since.items()}
        ready = [t for t, limit in limits.items() if limit == last and moments[t] <= last]
        return self._fire_at(draw.choice(ready), last, moments, draw) if ready else None

    def _fire_at(self, chosen: int, moment: int, moments: dict[int, int], draw: Random) -> int:
        """Fire a transition, or one with priority over it that can fire at the same moment; return which."""
        since = self._since
        while above := [t for t in self._net.above[chosen] if t in since and moments[t] <= moment]:
            chosen = draw.choice(above)
        self._fire(chosen)
        self.now = moment
        self._restart(chosen)
        return chosen

    def _fire(self, chosen: int) -> None:
        net, marking = self._net, self.marking
        touched = dict.fromkeys(place for place, _ in net.take.row(chosen))
        for place, weight in net.take.row(chosen):
            marking[place] -= weight
        looked = {t for place in touched for t in self._lookers[place]}
        for transition in looked:
            if transition in self._since and not net.untimed.is_enabled(transition, marking):
                del self._since[transition]
        for place, weight in net.put.row(chosen):
            marking[place] += weight
            touched[place] = None
        self._looked = {t for place in touched for t in self._lookers[place]}

    def _restart(self, fired: int) -> None:
        self._since.pop(fired, None)
        for transition in (*self._looked, fired):
            if not self._net.untimed.is_enabled(transition, self.marking):
                self._since.pop(transition, None)
            elif transition not in self._since:
                self._since[transition] = self.now


@dataclass
class Walked:
    """What runs have met."""

    runs: list[Trace] = field(default_factory=list)
    """The runs, as firing sequences."""
    ways: dict[int, Trace] = field(default_factory=dict)
    """By transition that fired: the shortest of the runs that end with it."""
    ends: list[Trace] = field(default_factory=list)
    """The runs after which nothing can fire any more."""

    def add(self, run: Trace, is_end: bool) -> None:
        """Note a run, and whether nothing can fire after it."""
        self.runs.append(run)
        if is_end:
            self.ends.append(run)
        for transition, length in _first(run):
            known = self.ways.get(transition)
            if known is None or length < len(known):
                self.ways[transition] = run[:length]


def walk_in_time(net: TimedNet, budget: Budget, runs: int = RUNS, steps: int = STEPS) -> Walked:
    """Draw runs of a net; the same ones for the same net.

    Parameters
    ----------
    budget : Budget
        Its time; the runs that are complete then are returned.
    runs, steps : int
        How many runs, and the most firings of each.
    """
    found = Walked()
    for number in range(runs):
        run = TimedRun(net)
        trace = _drawn(partial(run.step, Random(number), number % 2 == 1), steps, budget)
        if budget.is_over:
            return found
        found.add(trace, run.is_over)
    return found


def walk_late(net: TimedNet, found: Walked, budget: Budget) -> None:
    """Draw long runs in which each transition fires as late as it can: what is overloaded falls behind.

    `found`: where the runs are put.
    """
    for number in range(LATE_RUNS):
        run = TimedRun(net)
        found.add(_drawn(partial(run.step_late, Random(number)), LATE_STEPS, budget), run.is_over)


def walk_towards(net: TimedNet, wanted: Collection[int], found: Walked, budget: Budget) -> None:
    """Draw runs for transitions that no run has fired yet: others that take away what they need are slow.

    `found`: where the runs are put.
    """
    for transition in wanted:
        if budget.is_over:
            return
        slow = _rivals(net, transition)
        for number in range(TRIES):
            if transition in found.ways or not slow or budget.is_over:
                break
            run = TimedRun(net)
            draw = Random(transition + number * len(net.intervals))
            # Time hardly passes in a hasty run if something can always fire at once, such as a signal.
            trace = _drawn(partial(run.step, draw, number == 0, slow), STEPS, budget, transition)
            found.add(trace, run.is_over)


def _rivals(net: TimedNet, wanted: int) -> set[int]:
    """Return transitions that keep another one from firing, and may wait as long as they like.

    A rival takes tokens from a place that the other one needs. If it cannot wait, those are rivals that give
    it what else it needs.
    """
    rivals: set[int] = set()
    needed = {place for place, _ in net.untimed.pre.row(wanted)}
    takers = {t for t in range(len(net.intervals)) for place, _ in net.take.row(t) if place in needed}
    seen = {wanted}
    for _ in range(RIVAL_STEPS):
        takers -= seen
        seen |= takers
        rivals |= {t for t in takers if net.intervals[t].latest is None}
        needs = {p for t in takers - rivals for p, _ in net.untimed.pre.row(t)} - needed
        takers = {t for t in range(len(net.intervals)) for place, _ in net.put.row(t) if place in needs}
    return rivals


def _drawn(step: Callable[[], int | None], steps: int, budget: Budget, last: int | None = None) -> Trace:
    """Draw a run until its last transition has fired, nothing can fire any more, or it is long enough."""
    trace: list[int] = []
    while len(trace) < steps and not (len(trace) % 100 == 0 and budget.is_over):
        fired = step()
        if fired is None:
            break
        trace.append(fired)
        if fired == last:
            break
    return tuple(trace)


def _first(trace: Sequence[int]) -> Iterator[tuple[int, int]]:
    """Yield the transitions of a sequence, each with the firings up to its first one."""
    seen: set[int] = set()
    for number, transition in enumerate(trace, 1):
        if transition not in seen:
            seen.add(transition)
            yield transition, number
