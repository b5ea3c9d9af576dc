"""Transitions that a run of a bounded net can fire infinitely often, according to the incidence matrix.

The transitions that an infinite run of a bounded net fires infinitely often lie on a cycle of its
reachability graph, and the firings of a cycle form a *transition semiflow*: a non-negative x with C . x = 0
(C the incidence matrix). If a weighting y of the places has y . C >= 0, a transition with (y . C) > 0 is in
no semiflow.

References
----------
T. Murata, *Petri nets: properties, analysis and applications*, Proc. IEEE 77(4), 1989, Sect. VIII.
"""

from __future__ import annotations

import numpy as np

from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.linear_programs import LinearProgram, in_whole_numbers

#: Denominators with which weights of places are searched.


def repeatable_transitions(net: CompiledNet) -> frozenset[int]:
    """Return a set that contains all transitions on cycles of the reachability graph.

    A linear program proposes weights of the places whose sum no transition decreases and as many as possible
    increase; their actual effect is computed in integers. If a proposal fails this check, all transitions are
    returned.

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
    """Return integer weights of the places; zeros if none are found."""
    places, transitions = len(net.places), len(net.transitions)
    # Unknowns: the weights, and for each transition a lower bound, at most 1, of its gain.
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
