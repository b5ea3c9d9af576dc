"""Tables of the explicit engine: a net, goals and conflicts as flat arrays over the cells of a layout."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.explicit.layout import Layout, signed
from dineros.analysis.nets.compiled import ArcTable, CompiledNet

Int64Array = NDArray[np.int64]

SET_BITS = 64


class NetTables(NamedTuple):
    """A net over the cells of a layout. Transitions are in the engine's own order."""

    word: Any  #: by cell
    shift: Any  #: by cell
    mask: Any  #: by cell
    is_wide: Any  #: by cell
    threshold_start: Any  #: by cell: rows of `threshold`, for wide cells
    threshold: Any  #: ascending numbers of tokens at which something changes
    lookup_start: Any  #: by cell: rows of the two following
    lookup_word: Any  #: word of the enabled set
    lookup_offset: Any  #: where in `allowed` its row of masks starts
    allowed: Any  #: sets of transitions
    fired: Any  #: the set of transitions that are fired: all, unless a search is led
    delta: Any  #: transition x word: what firing adds
    moves: Any  #: by transition: whether it changes the marking
    guards: Any  #: by word of a marking


class Goals(NamedTuple):
    """Conjunctions of linear constraints: sums over cells that must reach a number."""

    constraint_start: Any  #: by conjunction
    term_start: Any  #: by constraint
    least: Any  #: by constraint
    term_cell: Any
    term_offset: Any  #: where in `table` the cell's contributions start; -1: tokens times `term_factor`
    term_factor: Any
    table: Any
    is_open: Any  #: by conjunction


class Markings(NamedTuple):
    """All markings found, in a part of the store for each worker, and the table that finds them again."""

    store: Any  #: marking x word
    parents: Any  #: row of the predecessor, -1 for the initial marking; empty when not wanted
    table: Any  #: open addressing: tag and row plus one
    rows: int  #: rows of each worker's part


class Notes(NamedTuple):
    """What one worker noted."""

    control: Any
    ever: Any  #: transitions that were enabled somewhere
    wanted: Any  #: transitions whose first marking is to be noted
    transition_row: Any  #: first marking that enables it, or -1
    goal_row: Any  #: first marking of a conjunction, or -1


class StubbornTables(NamedTuple):
    """The tables for closing a set; rows of CSR tables, transitions in the engine's order."""

    is_used: bool
    keeps_deadlocks: bool
    places: int
    cell_start: Any  #: by cell: rows of the two following
    cell_place: Any
    value_offset: Any  #: where in `values` the tokens by code start; -1 for a wide cell
    values: Any
    pre_start: Any
    pre_place: Any
    pre_weight: Any
    inhibitor_start: Any
    inhibitor_place: Any
    inhibitor_weight: Any
    raising_start: Any  #: by place: transitions that add tokens
    raising: Any
    lowering_start: Any  #: by place: transitions that take tokens
    lowering: Any
    conflict_start: Any  #: by transition: those that it could disable or be disabled by
    conflict: Any
    helping_start: Any  #: by linear constraint of the goals: transitions that raise its sum
    helping: Any


def transition_order(net: CompiledNet, layout: Layout) -> list[int]:
    """Order transitions that test the same cells next to each other: a cell's tables then span few words."""
    home = {place: k for k, cell in enumerate(layout.cells) for place in cell.places}
    cells = [
        sorted({home[p] for p, _ in [*net.pre.row(t), *net.inhibitor.row(t)]})
        for t in range(len(net.transitions))
    ]
    return sorted(range(len(net.transitions)), key=lambda t: cells[t])


def transition_set(positions: Iterable[int], size: int) -> Int64Array:
    """A set of positions as words of bits."""
    words = [0] * -(-max(size, 1) // SET_BITS)
    for position in positions:
        words[position // SET_BITS] |= 1 << position % SET_BITS
    return signed(words)


def net_tables(net: CompiledNet, layout: Layout, order: Sequence[int]) -> NetTables:
    """The net with its transitions in the given order."""
    home = {place: (k, i) for k, cell in enumerate(layout.cells) for i, place in enumerate(cell.places)}
    tests: list[dict[int, list[tuple[int, int, bool]]]] = [{} for _ in layout.cells]
    for position, t in enumerate(order):
        for table, is_inhibitor in ((net.pre, False), (net.inhibitor, True)):
            for place, weight in table.row(t):
                k, i = home[place]
                tests[k].setdefault(position, []).append((i, weight, is_inhibitor))
    threshold_start, thresholds, lookup_start = [0], list[int](), [0]
    lookup_word: list[int] = []
    lookup_offset: list[int] = []
    allowed: list[Int64Array] = []
    length = 0
    for k, cell in enumerate(layout.cells):
        if cell.values is None:
            own = sorted({weight for conditions in tests[k].values() for _, weight, _ in conditions})
            thresholds += own
            values = np.array([0, *own], dtype=np.int64)[:, None]
        else:
            values = cell.values
        threshold_start.append(len(thresholds))
        for word in sorted({position // SET_BITS for position in tests[k]}):
            row = np.full(len(values), -1, dtype=np.int64).view(np.uint64)
            for position, conditions in tests[k].items():
                if position // SET_BITS == word:
                    fails = np.zeros(len(values), dtype=bool)
                    for i, weight, is_inhibitor in conditions:
                        fails |= (values[:, i] >= weight) == is_inhibitor
                    row[fails] &= ~np.uint64(1 << position % SET_BITS)
            lookup_word.append(word)
            lookup_offset.append(length)
            allowed.append(row.view(np.int64))
            length += len(row)
        lookup_start.append(len(lookup_word))
    changes = [layout.pack(net.delta[t]) for t in order]
    return NetTables(
        word=layout.word,
        shift=layout.shift,
        mask=layout.masks,
        is_wide=np.array([cell.values is None for cell in layout.cells], dtype=np.bool_),
        threshold_start=ints(threshold_start),
        threshold=ints(thresholds),
        lookup_start=ints(lookup_start),
        lookup_word=ints(lookup_word),
        lookup_offset=ints(lookup_offset),
        allowed=np.concatenate([*allowed, ints([])]),
        fired=transition_set(range(len(order)), len(order)),
        delta=np.array(changes, dtype=np.int64).reshape(len(order), layout.words),
        moves=np.array([bool(net.delta[t]) for t in order], dtype=np.bool_),
        guards=layout.guards,
    )


def stubborn_tables(
    net: CompiledNet,
    layout: Layout,
    order: Sequence[int],
    constraints: Sequence[dict[int, int]],
    is_used: bool,
    keeps_deadlocks: bool,
) -> StubbornTables:
    """Return the tables for stubborn sets; empty tables if they are not used.

    Parameters
    ----------
    constraints
        Weights (place -> factor) of the linear constraints of all goals.
    """
    values, offsets = list[Int64Array](), list[int]()
    for cell in layout.cells:
        offsets.append(-1 if cell.values is None else sum(map(len, values)))
        if cell.values is not None:
            values.append(cell.values.ravel())
    raising: list[list[int]] = [[] for _ in net.places]
    lowering: list[list[int]] = [[] for _ in net.places]
    needing: list[list[int]] = [[] for _ in net.places]
    inhibited: list[list[int]] = [[] for _ in net.places]
    for position, t in enumerate(order):
        for place, tokens in net.delta[t].items():
            (raising if tokens > 0 else lowering)[place].append(position)
        for place, _ in net.pre.row(t):
            needing[place].append(position)
        for place, _ in net.inhibitor.row(t):
            inhibited[place].append(position)
    conflicts: list[set[int]] = [set() for _ in order]
    if is_used:
        for place in range(len(net.places)):
            for changing, testing in ((lowering, needing), (raising, inhibited)):
                for one in changing[place]:
                    for other in testing[place]:
                        if one != other:
                            conflicts[one].add(other)
                            conflicts[other].add(one)
    helping = [
        [
            position
            for position, t in enumerate(order)
            if sum(weights.get(p, 0) * tokens for p, tokens in net.delta[t].items()) > 0
        ]
        for weights in (constraints if is_used else [])
    ]
    return StubbornTables(
        is_used,
        keeps_deadlocks,
        len(net.places),
        *_rows([cell.places for cell in layout.cells]),
        ints(offsets),
        np.concatenate([*values, ints([])]),
        *_arcs(net.pre, order),
        *_arcs(net.inhibitor, order),
        *_rows(raising),
        *_rows(lowering),
        *_rows([sorted(row) for row in conflicts]),
        *_rows(helping),
    )


def ints(values: Iterable[int]) -> Int64Array:
    """Return an array of 64-bit integers."""
    return np.array(list(values), dtype=np.int64)


def _rows(rows: Sequence[Sequence[int]]) -> tuple[Int64Array, Int64Array]:
    start = np.zeros(len(rows) + 1, dtype=np.int64)
    start[1:] = np.cumsum([len(row) for row in rows])
    return start, ints(item for row in rows for item in row)


def _arcs(table: ArcTable, order: Sequence[int]) -> tuple[Int64Array, Int64Array, Int64Array]:
    rows = [table.row(t) for t in order]
    start, place = _rows([[p for p, _ in row] for row in rows])
    return start, place, ints(weight for row in rows for _, weight in row)
