"""A net and an automaton as flat tables for the kernels, for one layout of markings."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.logic.automata.automaton import Automaton
from dineros.analysis.logic.graphs.packing import Layout, Words
from dineros.analysis.logic.kernels.product import BITS, DE_BRUIJN, Edges, NetTables, Triggers
from dineros.analysis.nets.compiled import ArcTable, CompiledNet

Int64Array = NDArray[np.int64]
Matrix = np.ndarray[tuple[int, int], np.dtype[np.int64]]
Pairs = list[tuple[int, int]]


def ints(values: Iterable[int]) -> Int64Array:
    """Return an array of 64-bit integers."""
    return np.array(list(values), dtype=np.int64)


def net_tables(net: CompiledNet, layout: Layout) -> NetTables:
    """Return the arcs of a net for a layout."""
    transitions = range(len(net.transitions))

    def by_word(table: ArcTable) -> tuple[list[Pairs], list[Pairs]]:
        values, guards = [], []
        for t in transitions:
            row = dict(table.row(t))
            values.append(layout.sum_by_word(row))
            guards.append(layout.sum_by_word({p: 1 << layout.bits[p] for p in row}))
        return values, guards

    pre, _ = by_word(net.pre)
    inhibitors, inhibitor_guards = by_word(net.inhibitor)
    changes = [layout.sum_by_word(change) for change in net.delta]
    # Odd constants that differ in every word; any fixed odd ones would do.
    multipliers = [pow(0x9E3779B97F4A7C15, 2 * i + 1, 2**64) | 1 for i in range(layout.words)]
    hash_change = [sum(value * multipliers[word] for word, value in row) % 2**64 for row in (*changes, ())]
    return NetTables(
        *_columns(pre),
        *_columns(inhibitors),
        _columns(inhibitor_guards)[2],
        *_columns(changes),
        np.array(hash_change, dtype=np.uint64),
        layout.guards,
        np.array(multipliers, dtype=np.uint64),
        _triggers(net, layout),
    )


def _triggers(net: CompiledNet, layout: Layout) -> Triggers:
    """Return the transitions by the input place whose tokens make the kernel look at them.

    That is the input place that is probably marked least often: not initially, and wanted by few. Transitions
    without an input place stand on their own.
    """
    users = [0] * len(net.places)
    for place in net.pre.place.tolist():
        users[place] += 1
    groups: dict[int, list[int]] = {}
    always = []
    for t in range(len(net.transitions)):
        inputs = [place for place, _ in net.pre.row(t)]
        if inputs:
            rarest = min(inputs, key=lambda place: (int(net.initial[place]) > 0, users[place], place))
            groups.setdefault(rarest, []).append(t)
        else:
            always.append(t)
    masks = [0] * layout.words
    group_of_bit = np.zeros((layout.words, 64), dtype=np.int32)
    others = []
    for group, place in enumerate(groups):
        word, shift = layout.fields[place]
        field = ((1 << layout.bits[place]) - 1) << shift
        masks[word] |= field
        others.append(2**64 - 1 - field)
        for bit in range(shift, shift + layout.bits[place]):
            group_of_bit[word, ((1 << bit) * DE_BRUIJN % 2**64) >> 58] = group
    return Triggers(
        np.array(masks, dtype=np.uint64),
        group_of_bit,
        np.array(others, dtype=np.uint64),
        ints(np.cumsum([0, *map(len, groups.values())])),
        ints(t for group in groups.values() for t in group),
        ints(always),
    )


def _columns(
    rows: list[Pairs],
) -> tuple[Int64Array, Int64Array, Words]:
    return (
        ints(np.cumsum([0, *map(len, rows)])),
        ints(word for row in rows for word, _ in row),
        np.array([value for row in rows for _, value in row], dtype=np.uint64),
    )


def bit_words(values: Sequence[int], words: int) -> Matrix:
    """Return sets of bits as rows of words of `BITS` bits each."""
    low = (1 << BITS) - 1
    rows = [[value >> (BITS * word) & low for word in range(words)] for value in values]
    return np.array(rows, dtype=np.int64).reshape(len(rows), words)


def edge_tables(automaton: Automaton, layout: Layout, letter_words: int, mark_words: int) -> Edges:
    """Edges sorted so that those towards components where acceptance is decided are tried first."""
    depth = {state: number for number, component in enumerate(automaton.components()) for state in component}
    rows = [sorted(edges, key=lambda edge: -depth[edge.target]) for edges in automaton.edges]
    flat = [edge for row in rows for edge in row]
    word, shift = layout.fields[-1]
    return Edges(
        ints(np.cumsum([0, *map(len, rows)])),
        bit_words([edge.positive for edge in flat], letter_words),
        bit_words([edge.negative for edge in flat], letter_words),
        bit_words([edge.marks for edge in flat], mark_words),
        ints(edge.target for edge in flat),
        word,
        shift,
    )
