"""The smallest capacity at which a queue loses no message (beyond the paper).

A queue of capacity l loses a message when one arrives while it holds l. So where the queue is large enough
forever, the smallest sufficient capacity is the largest load at which a message arrives, plus one. Until it
first is full, a queue does what a larger one does: what is enough stays enough when it grows.

Each queue has an answer of its own, also where markings have no end: then capacities are tried, each a
question whether a transition can fire, or the tree of Karp and Miller gives the largest load.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf

from dineros.analysis.answers.budget import UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.answers.stages import Attempt, Share, fairly, first_result
from dineros.analysis.checks.remedies import remedy_text
from dineros.analysis.covering.firings import firings
from dineros.analysis.covering.growth import remedy_of
from dineros.analysis.covering.largest import largest_beside, loop_raising
from dineros.analysis.model.queues import Queue, queues
from dineros.analysis.model.subject import Subject, base_subject
from dineros.analysis.nets.bounds import place_bounds
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.coverability import Pumping, coverability
from dineros.analysis.portfolio.asking import find_firing
from dineros.analysis.symbolic.engine import SymbolicStateSpace, symbolic_state_space
from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError
from dineros.analysis.walks.first_round import first_round
from dineros.analysis.witnesses.witness import Witness, pumping_witness, witness_of
from dineros.metamodel import sym

FIRST_WORK = 4_000_000
"""Cache misses of saturation, a few seconds, that the state space may cost before it is left for last."""

SPACE, FIRST_PART = Share(time=0.3), 0.8
"""Share of the state space, and part of the time for all queues at their first analysis."""

FIRST_SECONDS = 20.0
"""Maximum seconds for the first search of one queue, if the state space was not made."""

TREE, LARGEST_LOAD, FIRINGS = Share(time=0.1), Share(time=0.3), Share(time=0.3)
"""Shares of the coverability tree, of the largest number of messages, and of each capacity that is tried."""

LARGEST = 1 << 12
"""Capacity at which the search gives up."""

LARGEST_TRIED = 1 << 6
"""The same where markings have no end, and each capacity that is tried costs a search."""

GROWS = "its load grows without bound"


@dataclass(frozen=True)
class Capacity:
    """What capacity a queue needs."""

    queue: Queue
    limit: int
    """Its capacity in the model."""
    needed: int | None
    """The smallest capacity at which no message is lost; None if there is none, or none was found."""
    reason: str = ""
    """Why there is none."""
    witness: Witness | None = None
    """How a message is lost with a capacity of one less; without any capacity that suffices, how the load
    grows without bound, where a loop is near.
    """
    grows: bool = False
    """Whether it is proved that there is none."""
    fix: str = ""
    """What would bound the load, if it grows."""


def suggest_capacities(
    model: sym.SystemModel, budget: Budget = UNLIMITED, found: list[Capacity] | None = None
) -> list[Capacity]:
    """Return the smallest capacity at which each queue loses no message, all others left as they are.

    Parameters
    ----------
    model : sym.SystemModel
        The model; it is not changed.
    budget : Budget, optional
        Of all searches; its memory is that of each. Of a queue for which it is not enough the answer is not
        known, for the reason that is given.
    found : list of Capacity, optional
        Where to put the answers as they come, for those who want them after an interruption.
    """
    found = [] if found is None else found
    budget = budget.begun()
    # With inhibitor arcs (T5a) the capacity is an initial marking and nothing else.
    subject = base_subject(model, overflow="inhibitor")
    search = _CapacitySearch(subject)
    # A state space that takes long comes last: most queues need none.
    search.make_space(SPACE.share(budget), FIRST_WORK)
    asked = list(queues(subject))
    for queue, share in fairly(asked, budget, factor=FIRST_PART):
        budget.stage(f"the capacity of {queue}")
        found.append(search.answer(queue, share if search.has_space else share.at_most(FIRST_SECONDS)))
    left = [number for number, each in enumerate(found) if each.needed is None and not each.grows]
    if left and not search.has_space:
        search.make_space(SPACE.share(budget), None)
        for number, share in fairly(left, budget):
            budget.stage(f"the capacity of {asked[number]}")
            again = search.answer(asked[number], share)
            if again.needed is not None or again.grows or not budget.is_over:
                found[number] = again
    return found


class _CapacitySearch:
    """Searches capacities on one net, whose state space with the model's own capacities is made once."""

    def __init__(self, subject: Subject) -> None:
        self._subject = subject
        self._budget = UNLIMITED
        self._own: SymbolicStateSpace | None = None

    @property
    def has_space(self) -> bool:
        """Whether there is the state space with the model's own capacities."""
        return self._own is not None

    def make_space(self, budget: Budget, most_work: int | None) -> None:
        """Make that, within a budget, and within a number of cache misses of saturation."""
        net = self._subject.net
        if most_work is not None and any(bound is None for bound in place_bounds(net)):
            return  # a tree that is large would be made first
        self._budget = budget
        self._own = self._space(net, most_work)

    def _space(self, net: CompiledNet, most_work: int | None = None) -> SymbolicStateSpace | None:
        def between(work: int) -> None:
            if most_work is not None and work > most_work:
                raise BudgetExceededError("it takes long")

        try:
            space = symbolic_state_space(net, self._budget, between=between)
        except (UnknownBoundError, LevelSizeError, BudgetExceededError):
            return None
        return space if space.complete else None

    def answer(self, queue: Queue, budget: Budget) -> Capacity:
        """Find the smallest sufficient capacity of one queue, or say why it is not known."""
        self._budget = budget
        try:
            return self.needed(queue)
        except BudgetExceededError as limit:
            return Capacity(queue, self._limit(queue), None, str(limit))

    def needed(self, queue: Queue) -> Capacity:
        """Find the smallest sufficient capacity of one queue."""
        net = self._subject.net
        if not queue.drops:  # a publisher on a server page without instances
            return Capacity(queue, self._limit(queue), 1)
        limit = self._limit(queue)
        if queue.reader_of_newest is not None:
            return Capacity(queue, limit, 1)  # the newest message is never lost
        if self._own is not None and _never_loses(self._own, queue):
            return self._least(queue, self._own)
        endless = _without_limit(net, queue.drops, queue.capacity)
        if self._own is None:
            return self._on_the_way(queue, endless)
        growth = coverability(endless, budget=TREE.share(self._budget))
        if growth.pumping is not None and net.places.index(queue.load) in growth.pumping.places:
            return self._grows(queue, endless, growth.pumping)
        large = limit
        while large < LARGEST:
            large *= 2
            space = self._space(net.with_initial({queue.capacity: large}))
            if space is None:
                return self._on_the_way(queue, endless)
            if _never_loses(space, queue):
                return self._least(queue, space)
        return Capacity(queue, limit, None, f"a capacity of {large} does not suffice")

    def _grows(self, queue: Queue, endless: CompiledNet, pumping: Pumping | None) -> Capacity:
        # In the net without the limit: a long way may have filled the queue before its loop begins.
        subject = replace(self._subject, net=endless)
        witness = None if pumping is None else pumping_witness(subject, pumping)
        remedy = remedy_of(endless)
        fix = "" if remedy is None else remedy_text(self._subject, remedy)
        return Capacity(queue, self._limit(queue), None, GROWS, witness, True, fix)

    def _on_the_way(self, queue: Queue, endless: CompiledNet) -> Capacity:
        """Find it without all markings: a loop is near as a rule, and the tree can be large."""
        net = self._subject.net
        load = net.places.index(queue.load)

        def by_walks(budget: Budget) -> Pumping | None:
            far = first_round(endless, budget, growing=[load]).pumpings
            return next((each for each in far if load in each.places), None)

        attempts = (
            Attempt(lambda budget: loop_raising(endless, load, budget), time=0.1),
            Attempt(by_walks, time=0.3),
        )
        loop = first_result(attempts, self._budget)
        if loop is not None:
            return self._grows(queue, endless, loop)
        tried = self._tried(queue)
        if tried.needed is not None:
            return tried
        # A message that arrives at a queue that holds any number is lost at any capacity.
        sources = {place for drop in self._drops(queue) for place, _ in net.pre.row(drop)}
        largest = largest_beside(endless, load, sources, LARGEST_LOAD.share(self._budget))
        if largest == inf:
            return self._grows(queue, endless, None)
        if largest is None:
            return tried
        needed = max(int(largest) + 1, 1)
        way = self._ways(queue, needed - 1)[0] if needed > 1 else None
        return replace(tried, needed=needed, reason="", witness=self._lost(queue, needed - 1, way))

    def _tried(self, queue: Queue) -> Capacity:
        """Try capacities: twice as large until one is enough, then between the two."""
        too_small, enough = 0, 0
        way: tuple[int, ...] | None = None
        while not enough or enough - too_small > 1:
            capacity = (too_small + enough) // 2 if enough else max(1, 2 * too_small)
            if capacity > LARGEST_TRIED:
                reason = f"a capacity of {too_small} does not suffice, and no larger one was tried"
                return Capacity(queue, self._limit(queue), None, reason)
            found, reason = self._ways(queue, capacity)
            if found is not None:
                too_small, way = capacity, found
            elif reason:
                return Capacity(queue, self._limit(queue), None, f"whether {capacity} suffices: {reason}")
            else:
                enough = capacity
        return Capacity(queue, self._limit(queue), enough, witness=self._lost(queue, too_small, way))

    def _ways(self, queue: Queue, capacity: int) -> tuple[tuple[int, ...] | None, str]:
        """Return a firing sequence that loses a message, or the reason why none could be excluded."""
        net = self._subject.net.with_initial({queue.capacity: capacity})
        drops = self._drops(queue)
        known = firings(net, FIRINGS.share(self._budget), drops, asks_deadlock=False)
        if not known.traces.keys().isdisjoint(drops):
            return known.way_to(drops), ""
        return None, "" if known.dead.issuperset(drops) else known.why_open or "not decided"

    def _lost(self, queue: Queue, capacity: int, way: tuple[int, ...] | None) -> Witness | None:
        if way is None:
            return None
        net = self._subject.net.with_initial({queue.capacity: capacity})
        return witness_of(replace(self._subject, net=net), way)

    def _drops(self, queue: Queue) -> list[int]:
        return [self._subject.transition_index[drop] for drop in queue.drops]

    def _limit(self, queue: Queue) -> int:
        """Return the capacity that a queue has in the model."""
        net = self._subject.net
        return int(net.initial[net.places.index(queue.capacity)])

    def _least(self, queue: Queue, space: SymbolicStateSpace) -> Capacity:
        # A full queue has no capacity, by which its drop is inhibited, and drops what is at its source.
        net, drops = self._subject.net, self._drops(queue)
        sources = [net.places[place] for drop in drops for place, _ in net.pre.row(drop)]
        needed = 1
        while any(space.satisfying({queue.load: (needed, None), source: (1, None)}) for source in sources):
            needed += 1
        smaller = net.with_initial({queue.capacity: needed - 1})
        ways = (find_firing(smaller, drop, self._budget).trace for drop in drops if needed > 1)
        way = next((way for way in ways if way is not None), None)
        return Capacity(queue, self._limit(queue), needed, witness=self._lost(queue, needed - 1, way))


def _never_loses(space: SymbolicStateSpace, queue: Queue) -> bool:
    return all(space.enabled(drop) == 0 for drop in queue.drops)


def _without_limit(net: CompiledNet, drops: Sequence[str], capacity: str) -> CompiledNet:
    """Return the net in which the queue never fills; its transitions keep their places in the order."""
    place = net.places.index(capacity)
    numbers = {net.transitions.index(drop) for drop in drops}
    names = net.places
    rows = []
    for t, name in enumerate(net.transitions):
        tables = [
            {names[p]: weight for p, weight in table.row(t) if p != place}
            for table in (net.pre, net.post, net.inhibitor)
        ]
        if t in numbers:
            tables = [{names[place]: 1}, {}, {}]  # can never fire: its place is gone dry
        rows.append(Transition(name, *tables))
    marking = {name: 0 if p == place else int(net.initial[p]) for p, name in enumerate(names)}
    return CompiledNet.build(marking, rows)
