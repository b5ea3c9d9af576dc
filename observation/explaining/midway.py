"""Where a run may be when a recorder is started in the middle of it.

Any marking that the model can reach, and no other. For a small model these are known exactly. For a large
one, the markings of each part are those that it can reach if the other parts may show any message at any
time. That is more than there is: two parts may be taken to be in markings that they never have at the same
time, and a recording may conform that no run shows. What an invariant of the net connects, such as a
request, its callback and its answer, is followed as one part, so that no call is answered twice or without
a request.
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
"""Seconds that finding all markings of a model may take, and the part of a time budget."""
WHOLE_NODES = 20_000
"""Nodes of the decision diagram of all markings, up to which they are followed exactly."""


def follower_midway(net: ShownNet, budget: Budget) -> Follower:
    """Return what follows messages from any marking, as exactly as the model's size allows.

    Raises
    ------
    BudgetError
        The time or the memory is not enough even where each part is followed by itself.
    """
    if _is_small(net, budget):
        return Follower(net, budget, "all")
    try:
        return Follower(net, budget, "invariants")
    except BudgetError:
        return Follower(net, budget)


def untold(follower: Follower) -> tuple[str, ...]:
    """Return the topics and events over which parts depend on each other that begin independently.

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
    """Tell whether all markings of a model are found soon, and are not too many to be followed."""
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
