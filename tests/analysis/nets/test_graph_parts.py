"""Parts of graphs, compared with NetworkX."""

from __future__ import annotations

from itertools import pairwise

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.analysis.nets import graph_parts
from dineros.analysis.nets.graph_parts import (
    ends,
    has_cycle,
    numbered_parts,
    shortest_path,
    strongly_connected_parts,
)

SIZE = 8
graphs = st.lists(st.lists(st.integers(0, SIZE - 1), max_size=3), min_size=SIZE, max_size=SIZE)


@given(graphs)
def test_parts_ends_cycles_and_paths_are_those_of_networkx(rows: list[list[int]]) -> None:
    graph = dict(enumerate(rows))
    other: nx.DiGraph[int] = nx.DiGraph()
    other.add_nodes_from(graph)
    other.add_edges_from((source, target) for source, row in graph.items() for target in row)
    parts = strongly_connected_parts(graph)
    assert {frozenset(part) for part in parts} == set(map(frozenset, nx.strongly_connected_components(other)))
    place = {node: number for number, part in enumerate(parts) for node in part}
    assert all(place[target] <= place[source] for source, target in other.edges)
    assert sorted(map(sorted, ends(graph))) == sorted(map(sorted, nx.attracting_components(other)))
    assert has_cycle(graph) == (not nx.is_directed_acyclic_graph(other))
    for target, length in nx.single_source_shortest_path_length(other, 0).items():
        path = shortest_path(graph, 0, target)
        assert (path[0], path[-1], len(path)) == (0, target, length + 1)
        assert all(pair in other.edges for pair in pairwise(path))


@given(graphs)
def test_large_graphs_have_the_same_parts_in_compiled_code(rows: list[list[int]]) -> None:
    arcs = np.array([(s, t) for s, row in enumerate(rows) for t in row], dtype=np.int64).reshape(-1, 2)
    found = [numbered_parts(SIZE, arcs[:, 0], arcs[:, 1])]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(graph_parts, "FEW_ARCS", 0)
        found.append(numbered_parts(SIZE, arcs[:, 0], arcs[:, 1]))
    alike = [part[:, None] == part[None, :] for _, part in found]
    assert found[0][0] == found[1][0]
    assert np.array_equal(*alike)
