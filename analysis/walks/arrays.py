"""The parts of a net that walks read, as arrays for their kernels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.nets.compiled import CompiledNet

Int64Array = NDArray[np.int64]


class NetArrays:
    """What walks read of a net: who asks for tokens of a place, and what firings change, in CSR form."""

    def __init__(self, net: CompiledNet) -> None:
        self.net = net
        asked = [len(net.pre.row(t)) + len(net.inhibitor.row(t)) for t in range(len(net.transitions))]
        changes = [list(change.items()) for change in net.delta]
        self.parts = (
            *_arcs_by_place(net),
            np.array(asked, dtype=np.int64),
            np.cumsum([0, *map(len, changes)]).astype(np.int64),
            np.array([p for row in changes for p, _ in row], dtype=np.int64),
            np.array([n for row in changes for _, n in row], dtype=np.int64),
        )


def _arcs_by_place(net: CompiledNet) -> tuple[Int64Array, Int64Array, Int64Array, Int64Array]:
    """Return arcs that ask for tokens of a place, in CSR form: transition, weight, whether it inhibits."""
    rows: list[list[tuple[int, int, int]]] = [[] for _ in net.places]
    for kind, table in enumerate((net.pre, net.inhibitor)):
        for t in range(len(net.transitions)):
            for place, weight in table.row(t):
                rows[place].append((t, weight, kind))
    flat = np.array([arc for row in rows for arc in row], dtype=np.int64).reshape(-1, 3)
    pointer = np.cumsum([0, *map(len, rows)]).astype(np.int64)
    return pointer, flat[:, 0].copy(), flat[:, 1].copy(), flat[:, 2].copy()
