"""Transitions that a run of a bounded net can fire again and again, as far as the incidence matrix tells.

What an infinite run of a bounded net fires infinitely often lies on a cycle of its reachability graph, and
what a cycle fires is a *transition semiflow*: a non-negative x with C . x = 0 (C the incidence matrix).
Where a weighting y of the places has y . C >= 0, every transition with (y . C) > 0 is in no semiflow.

References
----------
T. Murata, *Petri nets: properties, analysis and applications*, Proc. IEEE 77(4), 1989, Sect. VIII.
"""

from __future__ import annotations

import numpy as np

from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.linear_programs import LinearProgram, in_whole_numbers

#: Denominators that weights of places are looked for with.


def repeatable_transitions(net: CompiledNet) -> frozenset[int]:
    """Return transitions outside which none lies on a cycle of the reachability graph.

    A linear program proposes weights of the places that no transition lowers and as many as possible raise;
    what they really do is computed in integers. Where a proposal does not stand that, all are returned.

    Examples
    --------
    >>> net = CompiledNet.build({"a": 2, "b": 0, "c": 0},
    ...     [("t", {"a": 1}, {"b": 1}), ("u", {"b": 1}, {"c": 1}), ("v", {"c": 1}, {"b": 1})])
    >>> sorted(repeatable_transitions(net))
    [1, 2]
    """
    weights = _proposed_weights(net)
    gains = [sum(weights[place] * tokens for place, tokens in change.items()) for change in net.delta]
    stands = min(gains, default=0) >= 0
    return frozenset(t for t, gain in enumerate(gains) if gain == 0 or not stands)


def _proposed_weights(net: CompiledNet) -> list[int]:
    """Return integer weights of the places; zeros where none are found."""
    places, transitions = len(net.places), len(net.transitions)
    # Unknowns: the weights, and of each transition how much of 1 is sure to be gained.
    rows = [
        {**{place: -tokens for place, tokens in change.items()}, places + t: 1}
        for t, change in enumerate(net.delta)
    ]
    free, gains = np.full(places, np.inf), np.ones(transitions)
    found = LinearProgram(rows, places + transitions).solve(
        np.concatenate([np.zeros(places), -gains]),
        np.zeros(transitions),
        np.concatenate([-free, np.zeros(transitions)]),
        np.concatenate([free, gains]),
    )
    if found is None:
        return [0] * places
    whole, _ = in_whole_numbers(found[:places])
    return whole
