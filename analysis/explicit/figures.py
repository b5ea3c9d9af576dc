"""Counts over all stored markings."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.explicit.kernels.markings import survey
from dineros.analysis.explicit.layout import Layout
from dineros.analysis.explicit.tables import SET_BITS, Int64Array, NetTables

#: Number of markings from which threads share the work.
LEAST_FOR_THREADS = 1 << 16


def members(order: Sequence[int], sets: Sequence[Int64Array]) -> NDArray[np.bool_]:
    """For each transition, whether one of the sets, in the engine's order, contains it."""
    flags = np.zeros(len(order), dtype=np.bool_)
    for position, t in enumerate(order):
        s, bit = divmod(position, SET_BITS)
        flags[t] = any(int(words[s]) >> bit & 1 for words in sets)
    return flags


def tokens_of(layout: Layout, rows: Int64Array, place: int) -> Int64Array:
    """Return the tokens of a place in packed markings, one per row."""
    k, cell = next((k, cell) for k, cell in enumerate(layout.cells) if place in cell.places)
    word, shift, mask = (int(row[k]) for row in (layout.word, layout.shift, layout.masks))
    codes: Int64Array = rows[:, word] >> shift & mask
    return codes if cell.values is None else np.asarray(cell.values[codes, cell.places.index(place)])


def largest_tokens(
    layout: Layout, tables: NetTables, store: Int64Array, parts: Sequence[tuple[int, int]]
) -> tuple[tuple[int, ...], int]:
    """Return the largest number of tokens of each place, and of all places together.

    Parameters
    ----------
    parts
        First row and number of rows of each part of the store that is in use.
    """
    cells = layout.cells
    sizes = [0 if cell.values is None else len(cell.values) for cell in cells]
    offset = np.concatenate([[0], np.cumsum(sizes)])[:-1].astype(np.int64)
    rows = [cell.values.sum(axis=1) for cell in cells if cell.values is not None]
    tokens = np.concatenate([*rows, np.zeros(0, dtype=np.int64)])

    def look(part: tuple[int, int]) -> tuple[int, Int64Array, Int64Array]:
        seen = np.zeros(sum(sizes) + 1, dtype=np.int64)
        wide = np.zeros(len(cells), dtype=np.int64)
        return int(survey(store, *part, tables, offset, tokens, seen, wide)), seen, wide

    slices = [
        (first + count * i // len(parts), count * (i + 1) // len(parts) - count * i // len(parts))
        for first, count in parts
        for i in range(len(parts))
    ]
    if len(parts) > 1 and sum(count for _, count in parts) >= LEAST_FOR_THREADS:
        with ThreadPoolExecutor(len(parts)) as pool:
            seen_by_part = list(pool.map(look, slices))
    else:
        seen_by_part = [look(part) for part in parts]
    seen = np.max([seen for _, seen, _ in seen_by_part], axis=0)
    wide = np.max([wide for _, _, wide in seen_by_part], axis=0)
    places = [0] * sum(len(cell.places) for cell in cells)
    for k, cell in enumerate(cells):
        flags = seen[offset[k] : offset[k] + sizes[k]] == 1
        best = [int(wide[k])] if cell.values is None else cell.values[flags].max(axis=0).tolist()
        for place, value in zip(cell.places, best, strict=True):
            places[place] = int(value)
    return tuple(places), max(total for total, _, _ in seen_by_part)
