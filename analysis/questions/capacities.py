"""The smallest capacity at which a queue loses no message (beyond the paper).

A queue of capacity l loses a message when one arrives while it holds l. So where the queue is large enough
for ever, the smallest sufficient capacity is the largest load at which a message arrives, plus one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from dineros.analysis.answers.budget import UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.model.queues import Queue, queues
from dineros.analysis.model.subject import Subject, base_subject
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.coverability import coverability
from dineros.analysis.questions.reachability import find_firing
from dineros.analysis.symbolic.engine import SymbolicStateSpace, symbolic_state_space
from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError
from dineros.analysis.witnesses.findings import Witness, pumping_witness, witness_of
from dineros.metamodel import sym

LARGEST = 1 << 12
"""Capacity at which the search gives up."""


@dataclass(frozen=True)
class Capacity:
    """What capacity a queue needs.

    Attributes
    ----------
    queue : Queue
        The queue.
    limit : int
        Its capacity in the model.
    needed : int or None
        The smallest capacity at which no message is lost; None where there is none, or none was found.
    reason : str
        Why there is none.
    witness : Witness or None
        How a message is lost with a capacity of one less; without any capacity that suffices, how the load
        grows without bound.
    """

    queue: Queue
    limit: int
    needed: int | None
    reason: str = ""
    witness: Witness | None = None


def suggest_capacities(
    model: sym.SystemModel, budget: Budget = UNLIMITED, found: list[Capacity] | None = None
) -> list[Capacity]:
    """Return the smallest capacity at which each queue loses no message, all others left as they are.

    Parameters
    ----------
    model : sym.SystemModel
        The model; it is not changed.
    budget : Budget, optional
        Of all searches; its memory is that of each. Where its time runs out, a queue has no number.
    found : list of Capacity, optional
        Where to put the answers as they come, for those who want them after an interruption.
    """
    found = [] if found is None else found
    # With inhibitor arcs (T5a) the capacity is an initial marking and nothing else.
    subject = base_subject(model, overflow="inhibitor")
    budget = budget.begun()
    search = _Search(subject, budget)
    for queue in queues(subject):
        try:
            budget.stage(f"the capacity of {queue}")
            found.append(search.needed(queue))
        except BudgetExceededError as limit:
            found.append(Capacity(queue, search.limit(queue), None, str(limit)))
    return found


class _Search:
    """Searches capacities on one net, whose state space with the model's own capacities is made once."""

    def __init__(self, subject: Subject, budget: Budget) -> None:
        self._subject = subject
        self._budget = budget
        self._own = self._space(subject.net)

    def _space(self, net: CompiledNet) -> SymbolicStateSpace | None:
        try:
            space = symbolic_state_space(net, self._budget)
        except (UnknownBoundError, LevelSizeError, BudgetExceededError):
            return None
        return space if space.complete else None

    def needed(self, queue: Queue) -> Capacity:
        """Find the smallest sufficient capacity of one queue."""
        net = self._subject.net
        if not queue.drops:  # a publisher on a server page without instances
            return Capacity(queue, self.limit(queue), 1)
        limit = self.limit(queue)
        if self._own is not None and _never_loses(self._own, queue):
            return self._least(queue, limit, self._own)
        growth = coverability(_without_limit(net, queue.drops, queue.capacity))
        load = net.places.index(queue.load)
        if growth.pumping is not None and load in growth.pumping.places:
            lasso = pumping_witness(self._subject, growth.pumping)
            return Capacity(queue, limit, None, "its load grows without bound", lasso)
        large = limit
        while large < LARGEST:
            large *= 2
            space = self._space(net.with_initial({queue.capacity: large}))
            if space is None:
                return Capacity(queue, limit, None, "memory ran out, or another place is unbounded")
            if _never_loses(space, queue):
                return self._least(queue, limit, space)
        return Capacity(queue, limit, None, f"a capacity of {large} is not enough")

    def limit(self, queue: Queue) -> int:
        """Return the capacity that a queue has in the model."""
        net = self._subject.net
        return int(net.initial[net.places.index(queue.capacity)])

    def _least(self, queue: Queue, limit: int, space: SymbolicStateSpace) -> Capacity:
        # A full queue has no capacity, by which its drop is inhibited, and drops what stands at its source.
        net = self._subject.net
        drops = [self._subject.transition_index[drop] for drop in queue.drops]
        sources = [net.places[place] for drop in drops for place, _ in net.pre.row(drop)]
        needed = 1
        while any(space.satisfying({queue.load: (needed, None), source: (1, None)}) for source in sources):
            needed += 1
        witness = None
        if needed > 1:
            smaller = replace(self._subject, net=net.with_initial({queue.capacity: needed - 1}))
            for drop in drops:
                trace = find_firing(smaller.net, drop, self._budget).trace
                if trace is not None:
                    witness = witness_of(smaller, trace)
                    break
        return Capacity(queue, limit, needed, witness=witness)


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
