"""Whether two nets are equal but for names, decided exactly: individualisation and refinement of colours."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable
from typing import TypeAlias

from tests.support.references.flattening import PlainNet

Vertex: TypeAlias = tuple[int, Hashable]
Colours: TypeAlias = dict[Vertex, int]
Graph: TypeAlias = dict[Vertex, list[tuple[Hashable, Vertex]]]


def are_isomorphic(first: PlainNet, second: PlainNet) -> bool:
    """Tell whether a renaming of places and transitions makes two nets the same."""
    graph: Graph = {}
    labels: dict[Vertex, Hashable] = {}
    for side, net in enumerate((first, second)):
        labels |= {(side, ("place", name)): ("place", tokens) for name, tokens in net.places.items()}
        labels |= {(side, ("transition", name)): ("transition", 0) for name in net.transitions}
        graph |= {vertex: [] for vertex in labels if vertex[0] == side}
        joined = Counter((source, target, weight, kind) for source, target, weight, kind in net.arcs)
        joined.update((higher, lower, 0, "overrides") for higher, lower in net.overrides)
        for (source, target, weight, kind), times in joined.items():
            start, end = (
                (side, ("place" if node in net.places else "transition", node)) for node in (source, target)
            )
            graph[start].append((("to", weight, kind, times), end))
            graph[end].append((("from", weight, kind, times), start))
    return _match(graph, _refine(graph, _numbered(labels)))


def _numbered(labels: dict[Vertex, Hashable]) -> Colours:
    numbers: dict[Hashable, int] = {}
    return {vertex: numbers.setdefault(label, len(numbers)) for vertex, label in labels.items()}


def _refine(graph: Graph, colours: Colours) -> Colours:
    """Split colours until vertices of one colour have neighbours of the same colours."""
    count = len(set(colours.values()))
    while True:
        colours = _numbered(
            {
                vertex: (
                    colours[vertex],
                    frozenset(Counter((label, colours[other]) for label, other in neighbours).items()),
                )
                for vertex, neighbours in graph.items()
            }
        )
        refined = len(set(colours.values()))
        if refined == count:
            return colours
        count = refined


def _match(graph: Graph, colours: Colours) -> bool:
    cells: dict[int, tuple[list[Vertex], list[Vertex]]] = {}
    for vertex, colour in colours.items():
        cells.setdefault(colour, ([], []))[vertex[0]].append(vertex)
    if any(len(left) != len(right) for left, right in cells.values()):
        return False
    open_cells = [cell for cell in cells.values() if len(cell[0]) > 1]
    if not open_cells:  # every vertex has its partner, and refinement has compared their neighbours
        return True
    left, right = min(open_cells, key=lambda cell: len(cell[0]))
    fresh = max(colours.values()) + 1
    return any(
        _match(graph, _refine(graph, {**colours, left[0]: fresh, candidate: fresh})) for candidate in right
    )
