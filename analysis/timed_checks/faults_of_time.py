"""Faults that only nets with times have: time that stops, and transitions that always come too late."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from dineros.analysis.answers.stages import Share
from dineros.analysis.checks.question import Checked, Question
from dineros.analysis.checks.unused import TRANSITION
from dineros.analysis.logic.graphs.predicates import MarkingMatrix, enabled
from dineros.analysis.nets.compiled import Int64Array
from dineros.analysis.nets.graph_parts import numbered_parts, shortest_path
from dineros.analysis.timed.exploring import Explored, Trace
from dineros.analysis.timed.graph import timed_graph
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed_checks import faults
from dineros.analysis.timed_checks.timed_checked import TimedChecked, with_times
from dineros.analysis.timed_checks.without_times import time_goes_on
from dineros.analysis.witnesses.witness import witness_of

GRAPH = Share(time=0.3)
"""Part of the time for the graph of strong classes, which only nets with priorities need here."""

NO_LOOP = "no loop of transitions that must fire at once, with the interval [0,0]"

Edges = tuple[Int64Array, Int64Array, Int64Array]
"""Sources, targets and transitions."""


class NeverInTime(Question):
    """Whether a transition gets its tokens, but never fires, because others always come first."""

    TOO_LATE = faults.TOO_LATE
    faults = (TOO_LATE,)
    asks = "which transitions never fire in time"

    def ask(self, checked: Checked) -> None:
        """Look for markings that enable what never fires. Such a transition is not also reported as dead."""
        known = with_times(checked)
        explored, subject = known.explored, known.timed
        if not explored.is_complete:
            return  # what never fires is undecided then, and reported so
        names = subject.net.transitions
        firing = {subject.transition_element(t) for t in explored.ways}
        found: set[str] = set()
        for t in range(len(names)):
            element, link = subject.transition_element(t), subject.link_of(names[t])
            if element in firing or element in found or (link is not None and link.maker is not None):
                continue
            rows = explored.enabled_at(t)
            if len(rows):
                found.add(element)
                witness = witness_of(subject, explored.way_to(int(rows[0])))
                words = {"transition": subject.transition_text(t), "interval": explored.net.intervals[t]}
                checked.report.findings.append(self.TOO_LATE.found(element, witness=witness, **words))
        checked.report.findings = [
            one
            for one in checked.report.findings
            if one.rule != TRANSITION.rule or found.isdisjoint(one.elements)
        ]


class TimeStops(Question):
    """Whether infinitely many firings must happen in no time, or priorities keep time from going on.

    A transition with the interval ``[0,0]`` fires before time continues. A loop of such transitions never
    lets time continue. A loop with other transitions may: each of them is enabled again in each round, and
    waits then.
    """

    STOPS, LOCKED = faults.STOPS, faults.LOCKED
    faults = (STOPS, LOCKED)
    asks = "whether time can stop"

    def ask(self, checked: Checked) -> None:
        """Look for loops of transitions that fire at once."""
        known = with_times(checked)
        explored = known.explored
        self._find_locks(known)
        if time_goes_on(explored.net):
            known.report.proved.append(NO_LOOP)
            return
        loop = _pumped(explored) or _loop(known)
        if loop is not None:
            stem, repeated = loop
            witness = witness_of(known.subject, [*stem, *repeated], len(stem))
            ids = dict.fromkeys(known.subject.transition_element(t) for t in repeated)
            words = ", ".join(dict.fromkeys(known.subject.transition_text(t) for t in repeated))
            known.report.findings.append(self.STOPS.found(*ids, witness=witness, loop=words))
        elif explored.is_complete:
            known.report.proved.append(NO_LOOP)
        else:
            checked.leave_open(self.asks, explored.reason)

    def _find_locks(self, known: TimedChecked) -> None:
        """Find ends in which transitions with priority over themselves, through others, are enabled."""
        net = known.explored.net
        circular = [t for t, above in enumerate(net.above) if t in above]
        if not circular:
            return
        for row, trace in known.explored.ends:
            held = [t for t in circular if row in known.explored.enabled_at(t)]
            if held:
                ids = [known.subject.transition_element(t) for t in held]
                words = ", ".join(known.subject.transition_text(t) for t in held)
                witness = witness_of(known.subject, trace)
                known.report.findings.append(self.LOCKED.found(*ids, witness=witness, transitions=words))
                return


def immediate(net: TimedNet) -> list[int]:
    """Return the transitions that fire as soon as they are enabled: their interval is ``[0,0]``."""
    return [t for t, interval in enumerate(net.intervals) if interval.latest == 0]


def _pumped(explored: Explored) -> tuple[Trace, Trace] | None:
    """Return a loop that makes tokens grow, if all of it happens at once."""
    growth = explored.growth
    if growth is None or not set(growth.suffix) <= set(immediate(explored.net)):
        return None
    return growth.prefix, growth.suffix


def _loop(known: TimedChecked) -> tuple[Trace, Trace] | None:
    """Return a way to a loop of firings that happen at once, and the loop."""
    explored = known.explored
    net = explored.net
    if not immediate(net):
        return None
    if net.has_priorities:
        graph = timed_graph(net, "S", GRAPH.share(known.budget))
        kept = np.isin(graph.label, immediate(net))
        edges = graph.source[kept], graph.target[kept], graph.label[kept]
        loop = _circle(graph.classes, edges)
        if loop is None:
            return None
        return explored.way_to(_row(explored, graph.markings[graph.marking_of[loop[0]]])), loop[1]
    # Without priorities, what is enabled with [0,0] can fire in each state of its marking.
    loop = _circle(len(explored.markings), _moves(net, explored.markings))
    return None if loop is None else (explored.way_to(loop[0]), loop[1])


def _row(explored: Explored, marking: Int64Array) -> int:
    return int(np.flatnonzero((explored.markings == marking).all(axis=1))[0])


def _moves(net: TimedNet, markings: Int64Array) -> Edges:
    """Return the firings that happen at once, from marking to marking."""
    row_of = {row.tobytes(): number for number, row in enumerate(np.ascontiguousarray(markings))}
    sources: list[int] = []
    targets: list[int] = []
    labels: list[int] = []
    for t in immediate(net):
        change = np.zeros(markings.shape[1], dtype=np.int64)
        for place, tokens in net.untimed.delta[t].items():
            change[place] = tokens
        for row in np.flatnonzero(enabled(MarkingMatrix(net.untimed, markings), t)).tolist():
            target = row_of.get((markings[row] + change).tobytes())
            if target is not None:  # of a search that ended early, not all are known
                sources.append(row)
                targets.append(target)
                labels.append(t)
    made = (np.array(column, dtype=np.int64) for column in (sources, targets, labels))
    return next(made), next(made), next(made)


def _circle(size: int, edges: Edges) -> tuple[int, Trace] | None:
    """Return a node of a circle, and the labels of the shortest circle from it; None if there is none."""
    source, target, label = edges
    if not len(source):
        return None
    _, part = numbered_parts(size, source.astype(np.int32), target.astype(np.int32))
    inside = np.flatnonzero(part[source] == part[target])
    if not len(inside):
        return None
    start = int(source[inside].min())
    return start, tuple(_round(start, source[inside], target[inside], label[inside]))


def _round(start: int, source: Int64Array, target: Int64Array, label: Int64Array) -> Sequence[int]:
    """Return the labels of a shortest way from a node of a circle back to it."""
    end = -1  # the node itself, as the end of the way
    labels: dict[tuple[int, int], int] = {}
    after: defaultdict[int, list[int]] = defaultdict(list)
    for a, b, t in zip(source.tolist(), target.tolist(), label.tolist(), strict=True):
        there = end if b == start else b
        if (a, there) not in labels:
            labels[a, there] = t
            after[a].append(there)
    return [labels[step] for step in pairwise(shortest_path(after, start, end))]
