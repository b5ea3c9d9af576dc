"""Order of places and transitions that depends neither on their names nor on their order in the file.

Colours are refined until all elements of a colour have the same arcs to each other colour. If several
elements still share a colour, one of them gets a colour of its own, and refinement continues. Two nets that
differ only in names and order become the same net if the elements of one colour are images of each other
under a symmetry. This holds for nearly all nets; in the others, the choice of the first element is arbitrary.

References
----------
B. D. McKay, A. Piperno, *Practical graph isomorphism, II*, Journal of Symbolic Computation 60, 2014.
R. Paige, R. E. Tarjan, *Three partition refinement algorithms*, SIAM Journal on Computing 16(6), 1987.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dineros.analysis.nets.compiled import ArcTable, CompiledNet


@dataclass(frozen=True)
class Arrangement:
    """A net in canonical order, with the original numbers of its elements.

    Attributes
    ----------
    net : CompiledNet
        The same net, its elements in canonical order.
    places, transitions : tuple of int
        By canonical number: the number in the original net.
    """

    net: CompiledNet
    places: tuple[int, ...]
    transitions: tuple[int, ...]


def arranged(net: CompiledNet) -> Arrangement:
    """Return a net with places and transitions in canonical order.

    Examples
    --------
    >>> net = CompiledNet.build({"b": 0, "a": 1}, [("t", {"a": 1}, {"b": 1})])
    >>> arranged(net).net.places
    ('b', 'a')
    >>> net = CompiledNet.build({"x": 1, "y": 0}, [("t", {"x": 1}, {"y": 1})])
    >>> arranged(net).net.places
    ('y', 'x')
    """
    size = len(net.places)
    order = _Refinement(net).order()
    places, transitions = order[:size], [element - size for element in order[size:]]
    return Arrangement(_permuted(net, places, transitions), tuple(places), tuple(transitions))


def _permuted(net: CompiledNet, places: Sequence[int], transitions: Sequence[int]) -> CompiledNet:
    position = np.empty(len(places), dtype=np.int64)
    position[np.array(places, dtype=np.int64)] = np.arange(len(places))
    at = np.array(transitions, dtype=np.int64)

    def permuted(arcs: ArcTable) -> ArcTable:
        lengths = np.diff(arcs.pointer)[at]
        pointer = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
        # Arc n of the new table is arc `source[n]` of the old one, except for the order within a row.
        source = np.repeat(arcs.pointer[at] - pointer[:-1], lengths) + np.arange(pointer[-1])
        place, weight = position[arcs.place[source]], arcs.weight[source]
        within = np.lexsort((place, np.repeat(np.arange(at.size), lengths)))
        table = ArcTable(pointer, place[within], weight[within])
        for array in (table.pointer, table.place, table.weight):
            array.setflags(write=False)
        return table

    initial = net.initial[np.array(places, dtype=np.int64)]
    initial.setflags(write=False)
    return CompiledNet(
        tuple(net.places[p] for p in places),
        tuple(net.transitions[t] for t in transitions),
        initial,
        permuted(net.pre),
        permuted(net.post),
        permuted(net.inhibitor),
    )


class _Refinement:
    """An ordered partition of the elements of a net into cells; the elements of a cell have one colour.

    Places are numbered first, then transitions. A cell is ``[start, start + size)`` of `_order`.
    """

    def __init__(self, net: CompiledNet) -> None:
        places, transitions = len(net.places), len(net.transitions)
        #: By element: (neighbour, kind of the arc) of each arc.
        self._arcs: list[list[tuple[int, int]]] = [[] for _ in range(places + transitions)]
        tables = (net.pre, net.post, net.inhibitor)
        used = sorted({(k, w) for k, arcs in enumerate(tables) for w in set(arcs.weight.tolist())})
        kinds = {kind: number for number, kind in enumerate(used)}
        for k, arcs in enumerate(tables):
            source = np.repeat(np.arange(transitions) + places, np.diff(arcs.pointer)).tolist()
            for t, p, w in zip(source, arcs.place.tolist(), arcs.weight.tolist(), strict=True):
                kind = kinds[k, w]
                self._arcs[t].append((p, kind))
                self._arcs[p].append((t, kind))
        colour: defaultdict[tuple[bool, int], list[int]] = defaultdict(list)
        for p, tokens in enumerate(net.initial.tolist()):
            colour[False, tokens].append(p)
        if transitions:
            colour[True, 0] = list(range(places, places + transitions))
        self._order: list[int] = []
        self._cell = [0] * (places + transitions)
        self._position = [0] * (places + transitions)
        self._size: dict[int, int] = {}
        for key in sorted(colour):
            start = len(self._order)
            for element in colour[key]:
                self._cell[element] = start
                self._position[element] = len(self._order)
                self._order.append(element)
            self._size[start] = len(colour[key])
        self._queue = deque(self._size)
        self._queued = set(self._size)

    def order(self) -> list[int]:
        """Refine until each element has its own cell; return the elements in the order of their cells."""
        self._refine()
        for start in range(len(self._order)):
            while self._size[start] > 1:
                self._split(start, {self._order[start]: ()})
                self._refine()
        return self._order

    def _refine(self) -> None:
        """Split cells until all elements of a cell have the same arcs to each other cell."""
        arcs, cell_of, size = self._arcs, self._cell, self._size
        while self._queue:
            start = self._queue.popleft()
            self._queued.discard(start)
            found: defaultdict[int, list[int]] = defaultdict(list)
            for element in self._order[start : start + self._size[start]]:
                for other, kind in arcs[element]:
                    if size[cell_of[other]] > 1:
                        found[other].append(kind)
            touched: defaultdict[int, dict[int, tuple[int, ...]]] = defaultdict(dict)
            for other, kinds in found.items():
                touched[cell_of[other]][other] = tuple(sorted(kinds)) if len(kinds) > 1 else (kinds[0],)
            for cell in sorted(touched):
                self._split(cell, touched[cell])

    def _split(self, cell: int, keys: dict[int, tuple[int, ...]]) -> None:
        """Split a cell by keys, in the order of the keys; elements without a key stay in front."""
        groups: defaultdict[tuple[int, ...], list[int]] = defaultdict(list)
        for element, key in keys.items():
            groups[key].append(element)
        rest = self._size[cell] - len(keys)
        if rest == 0 and len(groups) == 1:
            return
        order, position = self._order, self._position
        parts = []
        start = cell + self._size[cell]
        for key in sorted(groups, reverse=True):
            for element in groups[key]:
                start -= 1
                here, other = position[element], order[start]
                order[here], order[start] = other, element
                position[other], position[element] = here, start
            self._size[start] = len(groups[key])
            parts.append(start)
            for element in groups[key]:
                self._cell[element] = start
        if rest:
            self._size[cell] = rest
            parts.append(cell)
        if cell not in self._queued:
            # The arcs to one part follow from the arcs to the others, so the largest part is skipped.
            parts.remove(max(parts, key=lambda part: (self._size[part], part)))
        for part in sorted(parts):
            if part not in self._queued:
                self._queued.add(part)
                self._queue.append(part)
