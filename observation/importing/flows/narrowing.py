"""Propagates the values of variables within a callback if no other callback sets them in the meantime."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from dineros.observation.importing.flows.graphs import from_edges, simplified
from dineros.observation.importing.flows.labels import WAITS, Ask, Edge, Flow, Label, Set, Step

Known = dict[str, frozenset[str]]
"""The possible values of variables in a state."""


def narrowed(
    flow: Flow, values: Mapping[str, tuple[str, ...]], own: Iterable[str], *, keeps_waiting: bool
) -> Flow:
    """Return a flow in which tests and assignments use earlier ones of the same run.

    Parameters
    ----------
    values : mapping of str to tuple of str
        All values of the variables.
    own : iterable of str
        Variables that no other run sets during this one.
    keeps_waiting : bool
        Whether that holds while it waits for a response, too.
    """
    every: Known = {name: frozenset(values[name]) for name in own}
    if not every:
        return flow
    known: dict[int, Known] = {flow.start: every}
    todo = [flow.start]
    leaving: dict[int, list[Edge]] = {}
    for edge in flow.edges:
        leaving.setdefault(edge.source, []).append(edge)
    while todo:
        state = todo.pop()
        for edge in leaving.get(state, ()):
            after = _after(edge.label, known[state], every, keeps_waiting)
            if after is None:
                continue
            before = known.get(edge.target)
            both = after if before is None else {name: before[name] | after[name] for name in every}
            if both != before:
                known[edge.target] = both
                todo.append(edge.target)
    found = [
        replace(edge, label=_label(edge.label, known[edge.source]))
        for edge in flow.edges
        if edge.source in known and _after(edge.label, known[edge.source], every, keeps_waiting) is not None
    ]
    graph, start = from_edges(found, flow)
    return simplified(graph, start, values)


def _after(label: Label, known: Known, every: Known, keeps_waiting: bool) -> Known | None:
    """Return the known values after an edge; None: it is not taken."""
    if isinstance(label, Ask) and label.variable in known:
        left = known[label.variable] & label.values
        return {**known, label.variable: left} if left else None
    if isinstance(label, Set) and label.variable in known:
        return {**known, label.variable: frozenset((label.value,))}
    waits = isinstance(label, Step) and label.verb in WAITS
    return every if waits and not keeps_waiting else known


def _label(label: Label, known: Known) -> Label:
    if isinstance(label, Ask) and label.variable in known:
        is_certain = known[label.variable] <= label.values
        return None if is_certain else replace(label, values=label.values & known[label.variable])
    if isinstance(label, Set) and label.variable in known:
        before = known[label.variable]
        return None if before == {label.value} else replace(label, before=before)
    return label
