"""The branches of a callback as a graph: steps, assignments and tests of variables.

A *variable* is an attribute of a node with few values, whose assignments are all known to the code reader
(`dineros.sources.branches`). Each edge of a flow is one step: a test reads one variable, and an assignment
sets one, so that callbacks on several threads interleave as they do in Python.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace

from dineros.observation.importing.flows.labels import Ask, Edge, Flow, Label, Mark, Set, Step

_End = 0
"""The final state of a callback."""


@dataclass
class Graph:
    """A graph under construction: states are numbers, the first of them is the end."""

    edges: dict[int, list[tuple[Label, int]]] = field(default_factory=lambda: defaultdict(list))
    """Labels and targets, by the state from which they begin."""
    count: int = 1
    """The number of states."""

    def state(self) -> int:
        """Return a new state."""
        self.count += 1
        return self.count - 1

    def edge(self, source: int, label: Label, target: int) -> None:
        """Add an edge."""
        if (label, target) not in self.edges[source]:
            self.edges[source].append((label, target))


def either(flows: Iterable[Flow], *, is_perhaps: bool = False) -> Flow:
    """Return a flow that behaves like one of several, or does nothing."""
    graph = Graph()
    start = graph.state()
    for flow in flows:
        moved: dict[int, int] = {flow.end: _End}
        for edge in flow.edges:
            source, target = (
                moved[each] if each in moved else moved.setdefault(each, graph.state())
                for each in (edge.source, edge.target)
            )
            graph.edge(source, edge.label, target)
        graph.edge(start, None, moved.get(flow.start, _End))
    if is_perhaps:
        graph.edge(start, None, _End)
    return simplified(graph, start, {})


def from_edges(edges: Iterable[Edge], flow: Flow) -> tuple[Graph, int]:
    """Return a graph of some edges between the states of a flow, and its first state."""
    graph = Graph()
    moved: dict[int, int] = {flow.end: _End}
    for edge in edges:
        for state in (edge.source, edge.target):
            if state not in moved:
                moved[state] = graph.state()
        graph.edge(moved[edge.source], edge.label, moved[edge.target])
    return graph, moved.get(flow.start, _End)


def without_marks(flow: Flow) -> Flow:
    """Return a flow in which marked places have no effect."""
    return either([relabelled(flow, lambda label: None if isinstance(label, Mark) else label)])


def simplified(graph: Graph, start: int, values: Mapping[str, tuple[str, ...]]) -> Flow:
    """Return a graph as a flow, without steps that change nothing.

    Parameters
    ----------
    start : int
        Its first state.
    values : mapping of str to tuple of str
        All values of the variables: a test without influence is omitted.
    """
    edges = {source: list(found) for source, found in graph.edges.items()}
    while True:
        edges, start = _merged(_without_silence(edges, start), start)
        left = _without_tests(edges, values)
        if left == edges:
            return _numbered(edges, start)
        edges = left


_Edges = dict[int, list[tuple[Label, int]]]


def _without_silence(edges: _Edges, start: int) -> _Edges:
    """Remove edges without effect: a state gets the edges of the states that it reaches by them."""
    found: _Edges = {}
    todo = [start]
    while todo:
        state = todo.pop()
        if state in found or state == _End:
            continue
        kept: dict[tuple[Label, int], None] = {}
        near, seen = [state], {state}
        while near:
            for label, target in edges.get(near.pop(), ()):
                if label is not None:
                    kept[label, target] = None
                elif target == _End:
                    kept[None, _End] = None
                elif target not in seen:
                    seen.add(target)
                    near.append(target)
        found[state] = list(kept)
        todo += [target for _, target in kept]
    return found


def _merged(edges: _Edges, start: int) -> tuple[_Edges, int]:
    """Merge equivalent states (R. Paige, R. E. Tarjan, SIAM J. Comput. 16(6), 1987)."""
    states = [_End, *edges]
    block = {state: int(state != _End) for state in states}
    count = len(set(block.values()))
    while True:
        signs: dict[tuple[object, ...], int] = {}
        after = {}
        for state in states:
            does = frozenset((label, block[target]) for label, target in edges.get(state, ()))
            after[state] = signs.setdefault((block[state], does), len(signs))
        block = after
        if len(signs) == count:
            break
        count = len(signs)
    first: dict[int, int] = {}
    for state in states:
        first.setdefault(block[state], state)
    found = {
        state: list(dict.fromkeys((label, first[block[target]]) for label, target in edges[state]))
        for state in edges
        if first[block[state]] == state
    }
    return found, first[block[start]]


def _without_tests(edges: _Edges, values: Mapping[str, tuple[str, ...]]) -> _Edges:
    """Remove tests whose outcomes all lead to one state."""
    found: _Edges = {}
    for state, outgoing in edges.items():
        asked: dict[tuple[str, int], set[str]] = defaultdict(set)
        for label, target in outgoing:
            if isinstance(label, Ask):
                asked[label.variable, target] |= label.values
        idle = {key for key, known in asked.items() if known >= set(values.get(key[0], ("",)))}
        kept: dict[tuple[Label, int], None] = {}
        for label, target in outgoing:
            is_idle = isinstance(label, Ask) and (label.variable, target) in idle
            kept[None if is_idle else label, target] = None
        found[state] = [each for each in kept if each != (None, state)]
    return found


def _numbered(edges: _Edges, start: int) -> Flow:
    listed = [Edge(source, label, target) for source, outgoing in edges.items() for label, target in outgoing]
    return Flow(tuple(listed), start, _End)


# ------------------------------------------------------------------------------------------- asked of flows


def passes(flow: Flow, is_mark: Callable[[Label], bool]) -> bool:
    """Return whether each path through a flow has an edge with a mark."""
    todo, seen = [flow.start], {flow.start}
    while todo:
        state = todo.pop()
        if state == flow.end:
            return False
        for edge in flow.edges:
            if edge.source == state and not is_mark(edge.label) and edge.target not in seen:
                seen.add(edge.target)
                todo.append(edge.target)
    return True


def variables_of(flow: Flow, *kinds: type[Set] | type[Ask]) -> set[str]:
    """Return the variables that a flow sets or tests."""
    wanted = kinds or (Set, Ask)
    return {edge.label.variable for edge in flow.edges if isinstance(edge.label, wanted)}


def steps_of(flow: Flow) -> Iterator[Step]:
    """Yield the steps of a flow."""
    return (edge.label for edge in flow.edges if isinstance(edge.label, Step))


def relabelled(flow: Flow, change: Callable[[Label], Label]) -> Flow:
    """Return a flow with other labels."""
    return replace(flow, edges=tuple(replace(edge, label=change(edge.label)) for edge in flow.edges))
