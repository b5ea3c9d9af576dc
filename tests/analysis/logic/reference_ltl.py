"""Reference model checking: plain sets and dictionaries, components by networkx, fairness by the textbook."""

from __future__ import annotations

from collections.abc import Sequence

import networkx as nx

from dineros.analysis.logic.automata.automaton import Automaton
from dineros.analysis.logic.language.atoms import BoundAtoms, Step
from dineros.analysis.logic.language.syntax import Atom
from dineros.analysis.nets.compiled import CompiledNet

Marking = tuple[int, ...]


def reachability_graph(
    net: CompiledNet, limit: int = 400
) -> dict[Marking, list[tuple[int | None, Marking]]] | None:
    """Successors by marking, deadlocks with an edge to themselves; None beyond `limit` markings."""
    start = tuple(net.initial.tolist())
    graph: dict[Marking, list[tuple[int | None, Marking]]] = {}
    todo = [start]
    while todo:
        marking = todo.pop()
        if marking in graph:
            continue
        if len(graph) >= limit:
            return None
        enabled = [t for t in range(len(net.transitions)) if net.is_enabled(t, marking)]
        row: list[tuple[int | None, Marking]] = [(t, tuple(net.fire(t, marking))) for t in enabled]
        graph[marking] = row or [(None, marking)]
        todo.extend(target for _, target in graph[marking])
    return graph


def accepts_word(
    automaton: Automaton, stem: Sequence[frozenset[Atom]], loop: Sequence[frozenset[Atom]]
) -> bool:
    """Whether an automaton accepts an ultimately periodic word."""
    letters = [sum(1 << i for i, atom in enumerate(automaton.atoms) if atom in x) for x in (*stem, *loop)]
    graph: nx.MultiDiGraph[tuple[int, int]] = nx.MultiDiGraph()
    start = (automaton.initial, 0)
    graph.add_node(start)
    todo, seen = [start], {start}
    while todo:
        q, i = todo.pop()
        for edge in automaton.edges[q]:
            if edge.reads(letters[i]):
                target = (edge.target, i + 1 if i + 1 < len(letters) else len(stem))
                graph.add_edge((q, i), target, marks=edge.marks)
                if target not in seen:
                    seen.add(target)
                    todo.append(target)
    return _has_accepting(graph, automaton.all_marks, (), (), None)


def has_counterexample(
    net: CompiledNet,
    graph: dict[Marking, list[tuple[int | None, Marking]]],
    automaton: Automaton,
    atoms: BoundAtoms,
    weak: Sequence[int],
    strong: Sequence[int],
) -> bool:
    """Whether some fair run is accepted by an automaton."""
    product: nx.MultiDiGraph[tuple[Marking, int]] = nx.MultiDiGraph()
    start = (tuple(net.initial.tolist()), automaton.initial)
    product.add_node(start)
    todo, seen = [start], {start}
    while todo:
        marking, q = todo.pop()
        for transition, successor in graph[marking]:
            step = Step(marking, transition)
            letter = sum(1 << i for i, atom in enumerate(automaton.atoms) if atoms.is_true(atom, step))
            for edge in automaton.edges[q]:
                if edge.reads(letter):
                    target = (successor, edge.target)
                    product.add_edge((marking, q), target, marks=edge.marks, fired=transition)
                    if target not in seen:
                        seen.add(target)
                        todo.append(target)
    return _has_accepting(product, automaton.all_marks, weak, strong, net)


def _has_accepting(
    graph: nx.MultiDiGraph,  # type: ignore[type-arg]
    all_marks: int,
    weak: Sequence[int],
    strong: Sequence[int],
    net: CompiledNet | None,
) -> bool:
    for component in nx.strongly_connected_components(graph):
        part = graph.subgraph(component)
        edges = [data for _, _, data in part.edges(data=True)]
        marks = 0
        for data in edges:
            marks |= data["marks"]
        if not edges or marks != all_marks:
            continue
        fired = {data.get("fired") for data in edges}

        def enabled(t: int, node: tuple[Marking, int]) -> bool:
            assert net is not None
            return net.is_enabled(t, node[0])

        if any(t not in fired and all(enabled(t, node) for node in component) for t in weak):
            continue
        unfair = [t for t in strong if t not in fired and any(enabled(t, node) for node in component)]
        if not unfair:
            return True
        rest = [node for node in component if not any(enabled(t, node) for t in unfair)]
        if _has_accepting(graph.subgraph(rest), all_marks, weak, strong, net):
            return True
    return False
