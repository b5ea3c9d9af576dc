"""The possible states of a run when a recorder is started in the middle of it.

These are exactly the markings that the model can reach. For a small model these are known exactly. For a
large
one, the markings of each part are those that it can reach if the other parts may show any message at any
time. This over-approximates: two parts may be assumed in markings that they never have at the same time, so a
recording may conform although no run shows it. Places of one invariant of the net, such as those of a
request, its callback and its answer, are followed as one part, so that no call is answered twice or without a
request.
"""

from __future__ import annotations

from dataclasses import replace

from dineros.analysis.answers.budget import Budget
from dineros.metamodel.errors import BudgetError
from dineros.observation.explaining.following import Follower
from dineros.observation.explaining.marking_sets import all_markings
from dineros.observation.explaining.parts import parts_of
from dineros.observation.explaining.shown import ShownNet

WHOLE_SECONDS, WHOLE_SHARE = 10.0, 0.2
"""Limit of the seconds for finding all markings of a model, and its share of a time budget."""
WHOLE_NODES = 20_000
"""Nodes of the decision diagram of all markings, up to which they are followed exactly."""


def follower_midway(net: ShownNet, budget: Budget) -> Follower:
    """Return a follower that starts in any marking, as exactly as the size of the model allows.

    Raises
    ------
    BudgetError
        The time or the memory does not suffice even if each part is followed separately.
    """
    if _is_small(net, budget):
        return Follower(net, budget, "all")
    try:
        return Follower(net, budget, "invariants")
    except BudgetError:
        return Follower(net, budget)


def untold(follower: Follower) -> tuple[str, ...]:
    """Return the topics and events by which parts with independent initial markings depend on each other.

    Empty if all first markings are ones that the model can reach.
    """
    if follower.joining == "all":
        return ()
    return tuple(
        sorted(
            topic
            for topic, found in follower.net.shown.items()
            if any(len(follower.touched[transition]) > 1 for transition in found)
        )
    )


def _is_small(net: ShownNet, budget: Budget) -> bool:
    """Return whether all markings of a model are found quickly, and are not too many."""
    left = budget.left
    seconds = WHOLE_SECONDS if left is None else min(WHOLE_SECONDS, left * WHOLE_SHARE)
    tried = replace(budget, seconds=seconds, started=None, deadline=None).begun()
    seen = {transition for found in net.shown.values() for transition in found}
    for part in parts_of(net.subject.net, seen, "all"):
        try:
            space = all_markings(part, tried)
        except BudgetError:
            return False
        if space.peak_nodes > WHOLE_NODES:
            return False
    return True
