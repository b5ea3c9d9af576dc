"""A net and an automaton as flat tables for the kernels, for one layout of markings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.explicit.layout import Layout
from dineros.analysis.explicit.tables import NetTables, ints, net_tables
from dineros.analysis.logic.automata.automaton import Automaton
from dineros.analysis.logic.kernels.product import BITS, Edges
from dineros.analysis.nets.compiled import CompiledNet

Int64Array = NDArray[np.int64]
Matrix = np.ndarray[tuple[int, int], np.dtype[np.int64]]


def step_tables(net: CompiledNet, layout: Layout) -> NetTables:
    """Return the steps of a net for a layout, in the net's order; the last one is staying in a deadlock."""
    tables = net_tables(net, layout, range(len(net.transitions)))
    nothing = np.zeros((1, layout.words), dtype=np.int64)
    return tables._replace(delta=np.concatenate([tables.delta, nothing]))


def bit_words(values: Sequence[int], words: int) -> Matrix:
    """Return sets of bits as rows of words of `BITS` bits each."""
    low = (1 << BITS) - 1
    rows = [[value >> (BITS * word) & low for word in range(words)] for value in values]
    return np.array(rows, dtype=np.int64).reshape(len(rows), words)


def edge_tables(automaton: Automaton, layout: Layout, letter_words: int, mark_words: int) -> Edges:
    """Sort edges such that those to components in which acceptance is decided are tried first."""
    depth = {state: number for number, component in enumerate(automaton.components()) for state in component}
    rows = [sorted(edges, key=lambda edge: -depth[edge.target]) for edges in automaton.edges]
    flat = [edge for row in rows for edge in row]
    return Edges(
        ints(np.cumsum([0, *map(len, rows)])),
        bit_words([edge.positive for edge in flat], letter_words),
        bit_words([edge.negative for edge in flat], letter_words),
        bit_words([edge.marks for edge in flat], mark_words),
        ints(edge.target for edge in flat),
        int(layout.word[-1]),
        int(layout.shift[-1]),
        int(layout.masks[-1]),
    )
