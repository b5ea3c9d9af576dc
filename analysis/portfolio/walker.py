"""Walks without stored traces: they visit many reachable markings in constant memory.

Random walks start at the initial marking repeatedly. Half of their choices follow priorities drawn separately
for each walk, so that walks reach different regions, not only by different paths. Other walks follow a
solution of the state equation, which gives the number of firings of each transition. If no remaining firing
is enabled, another transition is fired.

References
----------
Y. Thierry-Mieg, *Symbolic and structural model-checking*, Fundamenta Informaticae 183(3-4), 2021 (walks along
Parikh vectors).
"""

from __future__ import annotations

import numpy as np

from dineros.analysis.logic.graphs.predicates import Flags, Int64Array, MarkingMatrix
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.walks.arrays import NetArrays
from dineros.analysis.walks.kernels.walks import follow as follow_counts
from dineros.analysis.walks.kernels.walks import walk

#: Numbers in a matrix of markings.
MATRIX_SIZE = 1 << 21
MOST_ROWS = 1 << 12
MOST_ENDS = 20
#: Walks for one solution of the state equation, and markings kept of each: the last ones.
TRIES, LAST_ROWS = 5, 1 << 10
#: Steps of a walk before it begins again: short ones at first, longer ones later.
SHORTEST_WALK, LONGEST_WALK = 1 << 6, 1 << 16


def follow(arrays: NetArrays, counts: Int64Array, seed: int) -> MarkingMatrix:
    """Return the last markings of a walk that tries to fire each transition this number of times."""
    rows = np.empty((LAST_ROWS, len(arrays.net.places)), dtype=np.int64)
    written = follow_counts(arrays.parts, arrays.net.initial, counts.copy(), rows, seed)
    return MarkingMatrix(arrays.net, rows[: min(written, LAST_ROWS)])


class Walker:
    """Walks through a net.

    Attributes
    ----------
    deadlocked : bool
        Whether some visited marking is a deadlock.
    ends : list of tuple of int
        Last markings of some walks, deadlocks first.
    """

    def __init__(self, net: CompiledNet) -> None:
        self.net = net
        self._random = np.random.default_rng(1)
        self.arrays = NetArrays(net)
        transitions = len(net.transitions)
        self._first = np.full(transitions, -1, dtype=np.int64)
        self.deadlocked = False
        self.ends: list[tuple[int, ...]] = []
        self._length = SHORTEST_WALK
        rows = max(16, min(MOST_ROWS, MATRIX_SIZE // max(1, len(net.places))))
        self._rows = np.empty((rows, len(net.places)), dtype=np.int64)

    @property
    def fired(self) -> Flags:
        """For each transition, whether it was enabled in some visited marking."""
        return self._first >= 0

    def walk(self) -> MarkingMatrix:
        """Continue walking, and return the visited markings; the next call overwrites the matrix."""
        filled = 0
        while filled < len(self._rows):
            count, dead = walk(
                self.arrays.parts,
                self.net.initial,
                self._random.random(len(self.net.transitions)),
                self._rows[filled:],
                self._first,
                self._length,
                int(self._random.integers(1 << 31)),
            )
            filled += count
            self._note_end(self._rows[filled - 1], bool(dead))
        self._length = SHORTEST_WALK if self._length >= LONGEST_WALK else 4 * self._length
        return MarkingMatrix(self.net, self._rows)

    def _note_end(self, marking: Int64Array, dead: bool) -> None:
        end = tuple(marking.tolist())
        self.deadlocked |= dead
        if end not in self.ends:
            self.ends.insert(0 if dead else len(self.ends), end)
            # Of the other ends, the latest are the most distant.
            del self.ends[MOST_ENDS // 2 : -MOST_ENDS // 2]
