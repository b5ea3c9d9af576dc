"""A net with times without some of its places: it can do all that the net can, at the same moments, and more.

An arc of a place that is left out is left out, too. A transition that needs such a place, or is inhibited by
it, is *loose*: it loses its latest bound, so it may wait for as long as it did. Every other transition is
enabled at the same moments as before, as all that it depends on is there, so its clock and its bounds are the
same. So each run of the net is a run of what is left, without the firings of transitions that change nothing
there. What holds for all runs of what is left holds for all runs of the net.

One place stands for all places of a weighted sum that are left out. If no firing increases a sum ``y . m``
with ``y >= 0``, it holds ``y . m0`` less the part of the sum that is left, which is at least the part that is
left out. Only loose transitions decrease it: by no more than the weights of what they take there. So it
disables none that the net enables, not even while another transition has taken tokens and not yet put any.

Nets with priorities are not cut: a transition that is enabled more often would hold back others.

References
----------
G. Berthelot, *Transformations and decompositions of nets*, LNCS 254, 1987 (places implied by others).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from dineros.analysis.nets.bounds import flows_and_bounds
from dineros.analysis.nets.compiled import Transition
from dineros.analysis.timed.nets import Interval, TimedNet

NEVER = "never"
"""Place without tokens, which transitions need that change nothing."""
REST = "rest"
"""Prefix of the places that stand for others."""
MOST_SUMS = 200
"""Limit of the weighted sums that are examined."""


def restricted(net: TimedNet, kept: Iterable[int]) -> TimedNet | None:
    """Return what a net does with some of its places; None for a net with priorities.

    Places and transitions keep their numbers and names; further places follow. Transitions that change
    nothing never fire.
    """
    if net.has_priorities:
        return None
    left = frozenset(kept)
    names = net.untimed.places
    tokens, rows = net.by_names()
    own, taken = {names[place] for place in left}, set(tokens)
    never = _unused(NEVER, taken)
    tokens = {name: count if place in left else 0 for place, (name, count) in enumerate(tokens.items())}
    tokens[never] = 0
    sums = [(_unused(f"{REST} {number}", taken), each) for number, each in enumerate(_sums(net, left))]
    for name, (weights, value) in sums:
        tokens[name] = value - sum(w * int(net.untimed.initial[p]) for p, w in weights.items())
    made: list[Transition] = []
    intervals: dict[str, Interval] = {}
    for t, row in enumerate(rows):
        interval = net.intervals[t]
        is_loose = not own.issuperset((*row.inputs, *row.reads, *row.inhibitors))
        if is_loose:
            interval = replace(interval, latest=None, is_open_above=False)
        inputs, outputs, reads, inhibitors = (
            {name: weight for name, weight in arcs.items() if name in own}
            for arcs in (row.inputs, row.outputs, row.reads, row.inhibitors)
        )
        if not inputs and not outputs:
            inputs, reads, inhibitors = {never: 1}, {}, {}
        for name, (weights, _) in sums:
            grows = sum(weights[p] * change for p, change in net.untimed.delta[t].items() if p in weights)
            if grows > 0:
                inputs = {**inputs, name: grows}
            elif grows < 0:
                outputs = {**outputs, name: -grows}
        intervals[row.name] = interval
        made.append(row._replace(inputs=inputs, outputs=outputs, reads=reads, inhibitors=inhibitors))
    return TimedNet.build(tokens, made, intervals)


def _sums(net: TimedNet, left: frozenset[int]) -> list[tuple[Mapping[int, int], int]]:
    """Return the weights of places that are left, and the first value, of sums that no firing increases.

    A sum counts if some of its places are left, and others are not.
    """
    flows, bounds = net.untimed.once(flows_and_bounds)
    all_weights = [flow.weights for flow in flows or ()]
    all_weights += [bound.weights for bound in bounds if bound is not None]
    initial: Sequence[int] = net.untimed.initial.tolist()
    found: dict[tuple[tuple[int, int], ...], tuple[Mapping[int, int], int]] = {}
    for weights in all_weights:
        own = {place: weight for place, weight in weights.items() if place in left}
        if not own or len(own) == len(weights):
            continue
        value = sum(weight * initial[place] for place, weight in weights.items())
        key = tuple(sorted(own.items()))
        if key not in found or value < found[key][1]:
            found[key] = own, value
    return list(found.values())[:MOST_SUMS]


def _unused(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "'"
    taken.add(name)
    return name
