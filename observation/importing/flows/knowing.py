"""Follows what a run of a callback knows of responses: the field of one that it has received, or will give.

A graph under construction marks where a field becomes known and where it is tested. The product of the graph
with what is known has no such marks: a test has one outcome after a response with a known field.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace

from dineros.observation.importing.flows.graphs import Graph, from_edges, simplified
from dineros.observation.importing.flows.labels import Answers, Edge, Flow, Has, Know, Label, Step, Test

_END = 0
GIVEN = "given"
"""Key of the response that a service's callback gives."""
STARTED = "started"
"""Key of the response that has started a callback."""


def followed(graph: Graph, start: int, given: str = "") -> tuple[Graph, int]:
    """Return a graph without marks, and its first state.

    Parameters
    ----------
    graph : Graph
        The graph, with marks.
    start : int
        Its first state.
    given : str
        Field of the response that the callback gives; empty: it gives none that matters.
    """
    found = Graph()
    begin = (start, frozenset[tuple[object, frozenset[str]]]())
    states = {begin: found.state()}
    todo = [begin]
    while todo:
        here = todo.pop()
        state, known = here
        if state == _END:
            values = dict(known).get(GIVEN, (None,))
            for value in sorted(values, key=str):
                found.edge(states[here], Answers(given, value) if given else None, _END)
            continue
        for label, target in graph.edges.get(state, ()):
            after = dict(known)
            if isinstance(label, Test):
                left = after.get(label.key, label.values) & label.values
                if not left:
                    continue
                after[label.key] = left
            elif isinstance(label, Know):
                after.pop(label.key, None)
                if label.value is not None:
                    after[label.key] = frozenset((label.value,))
            there = (target, frozenset(after.items()))
            if there not in states:
                states[there] = found.state()
                todo.append(there)
            is_mark = isinstance(label, (Know, Test))
            found.edge(states[here], None if is_mark else label, states[there])
    return found, states[begin]


def decided(flow: Flow, values: dict[str, tuple[str, ...]], fields: Mapping[str, frozenset[str]]) -> Flow:
    """Return a flow without values that make no difference.

    Parameters
    ----------
    values : dict of str to tuple of str
        All values of the variables.
    fields : mapping of str to frozenset of str
        All values of the fields of responses.
    """
    while True:
        outcomes: dict[tuple[int, Label, int], set[str | None]] = defaultdict(set)
        for edge in flow.edges:
            name, value = _field(edge.label)
            found_here = outcomes[edge.source, _bare(edge.label), edge.target]
            found_here.add(value)
            if found_here >= fields.get(name, frozenset((None,))):
                found_here.add(None)
        found: dict[Edge, None] = {}
        for edge in flow.edges:
            bare = _bare(edge.label)
            is_idle = bare != edge.label and None in outcomes[edge.source, bare, edge.target]
            found[replace(edge, label=bare) if is_idle else edge] = None
        if list(found) == list(flow.edges):
            break
        flow = simplified(*from_edges(found, flow), values)
    if has_data(flow):
        return flow
    idle = [replace(e, label=None) if isinstance(e.label, Answers) else e for e in flow.edges]
    return simplified(*from_edges(idle, flow), values) if idle != list(flow.edges) else flow


def has_data(flow: Flow) -> bool:
    """Return whether a flow depends on a field of a response, or gives one."""
    return any(_bare(edge.label) != edge.label for edge in flow.edges)


def _field(label: Label) -> tuple[str, str | None]:
    """Return the field of a label, and its value; None: any."""
    if isinstance(label, Step):
        return label.answer or ("", None)
    return (label.name, label.value) if isinstance(label, (Has, Answers)) else ("", None)


def _bare(label: Label) -> Label:
    """Return a label without the value of a field."""
    if isinstance(label, Step) and label.answer is not None:
        return replace(label, answer=None)
    if isinstance(label, Answers):
        return replace(label, value=None)
    return None if isinstance(label, Has) else label
