"""Which runs take infinite time, and which stop time.

See `dineros.analysis.timed.linear_time` for the runs that count.

References
----------
S. Tripakis, *Verifying progress in timed systems*, ARTS 1999, LNCS 1601.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from dineros.analysis.logic.graphs.predicates import Flags
from dineros.analysis.nets.compiled import Int64Array, Transition, unused
from dineros.analysis.timed.graph import WAITING, TimedGraph
from dineros.analysis.timed.nets import Interval, TimedNet


def passing(graph: TimedGraph) -> Flags:
    """Return by edge whether a run that takes it infinitely often can take infinite time.

    Three kinds of edges do that. The run waits forever. The transition has an earliest bound above 0: its
    clock starts again each time it fires. Nothing has to fire in the class: the run can wait there, and then
    do the same, unless another transition gets its turn by priority meanwhile.
    """
    late = [t for t, interval in enumerate(graph.net.intervals) if interval.earliest > 0]
    may_wait = np.zeros(graph.classes, dtype=np.bool_)
    if not graph.net.has_priorities:
        may_wait[graph.source[graph.label == WAITING]] = True
    return np.isin(graph.label, [WAITING, *late]) | may_wait[graph.source]


def stopping(graph: TimedGraph) -> Flags:
    """Return by edge whether its transition may keep time from passing.

    It has the interval ``[0,0]``, or has priority over another one.
    """
    net = graph.net
    above = {high for row in net.above for high in row}
    stops = [t for t, interval in enumerate(net.intervals) if interval.latest == 0 or t in above]
    return np.isin(graph.label, stops)


def all_take_finite_time(graph: TimedGraph, edges: Int64Array, part: Int64Array) -> bool:
    """Return whether no run that stays in one of some parts of the graph can take infinite time, for sure.

    That is so if a transition with a latest bound stays enabled in the part, never fires there, and its clock
    never starts again.

    Parameters
    ----------
    edges, part
        Edges of the graph, and by edge the number of its part.
    """
    parts = int(part.max(initial=-1)) + 1
    decided = np.zeros(parts, dtype=np.bool_)
    for t, interval in enumerate(graph.net.intervals):
        if interval.latest is not None and not decided.all():
            stays = np.ones(parts, dtype=np.bool_)
            stays[part[~keeps_clock(graph, edges, t)]] = False
            decided |= stays
    return bool(decided.all())


def keeps_clock(graph: TimedGraph, edges: Int64Array, transition: int) -> Flags:
    """Return by edge whether a transition is enabled before and after it, and its clock continues."""
    net, label = graph.net, graph.label[edges]
    keeps = (label != WAITING) & (label != transition)
    at, after = (graph.markings[graph.marking_of[ends[edges]]] for ends in (graph.source, graph.target))
    count = len(net.untimed.transitions)
    for place, weight in net.untimed.pre.row(transition):
        taken = np.array([dict(net.take.row(t)).get(place, 0) for t in range(count)], dtype=np.int64)
        keeps &= at[:, place] - taken[label] >= weight
    for place, weight in net.untimed.inhibitor.row(transition):
        keeps &= (at[:, place] < weight) & (after[:, place] < weight)
    return np.asarray(keeps)


def with_ticks(net: TimedNet) -> tuple[TimedNet, int]:
    """Return a net with one more transition, which can fire infinitely often in infinite time only.

    It is the last one, has a place of its own, and an earliest bound. Each bound above 0 serves; one that is
    not small against the others makes the fewest classes. All numbers of places and transitions stay.
    """
    tokens, rows = net.by_names()
    place, name = unused("tick", tokens), unused("tick", net.untimed.transitions)
    intervals = dict(zip(net.untimed.transitions, net.intervals, strict=True))
    bounds = [bound for each in net.intervals for bound in (each.earliest, each.latest) if bound]
    longest = max(bounds, default=Fraction(1))
    priorities = [
        (net.untimed.transitions[high], net.untimed.transitions[low])
        for low, above in enumerate(net.above)
        for high in above
    ]
    made = TimedNet.build(
        {**tokens, place: 1},
        [*rows, Transition(name, {place: 1}, {place: 1})],
        {**intervals, name: Interval(longest)},
        priorities,
    )
    return made, len(rows)
