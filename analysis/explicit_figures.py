"""Figures over all stored markings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.explicit_kernels import COUNT, survey
from dineros.analysis.explicit_layout import Layout
from dineros.analysis.explicit_tables import SET_BITS, Int64Array, NetTables, Worker


def members(order: Sequence[int], sets: Sequence[Int64Array]) -> NDArray[np.bool_]:
    """By transition: whether one of the sets, in the engine's order, has it."""
    flags = np.zeros(len(order), dtype=np.bool_)
    for position, t in enumerate(order):
        s, bit = divmod(position, SET_BITS)
        flags[t] = any(int(words[s]) >> bit & 1 for words in sets)
    return flags


def largest_tokens(layout: Layout, tables: NetTables, crew: Sequence[Worker]) -> tuple[tuple[int, ...], int]:
    """Largest tokens of each place, and of all places together."""
    cells = layout.cells
    sizes = [0 if cell.values is None else len(cell.values) for cell in cells]
    offset = np.concatenate([[0], np.cumsum(sizes)])[:-1].astype(np.int64)
    rows = [cell.values.sum(axis=1) for cell in cells if cell.values is not None]
    tokens = np.concatenate([*rows, np.zeros(0, dtype=np.int64)])
    seen = np.zeros(sum(sizes), dtype=np.int64)
    wide = np.zeros(len(cells), dtype=np.int64)
    total = 0
    for worker in crew:
        count = int(worker.control[COUNT])
        total = max(total, int(survey(worker.store, count, tables, offset, tokens, seen, wide)))
    places = [0] * sum(len(cell.places) for cell in cells)
    for k, cell in enumerate(cells):
        flags = seen[offset[k] : offset[k] + sizes[k]] == 1
        best = [int(wide[k])] if cell.values is None else cell.values[flags].max(axis=0).tolist()
        for place, value in zip(cell.places, best, strict=True):
            places[place] = int(value)
    return tuple(places), total
