"""Exact counts on a finished decision diagram: markings, arcs, deadlocks, largest token counts."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from math import prod

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.symbolic.kernels import counting as kernels
from dineros.analysis.symbolic.levels import Weights
from dineros.analysis.symbolic.saturation import Diagram, DiagramMemoryError

Int64Array = NDArray[np.int64]
LARGEST_PRIME = 1 << 30
#: Bytes per node, including temporary copies, and a constant number of bytes.
NODE_BYTES = 72
SMALLEST_ROOM = 1 << 22


class DiagramCounts:
    """The vectors of a diagram's node, renumbered for counting.

    Parameters
    ----------
    diagram
        A diagram whose run is complete.
    root
        Node to count below; the diagram's root by default.

    Raises
    ------
    DiagramMemoryError
        If there is no memory for the tables in addition to the diagram.
    """

    def __init__(self, diagram: Diagram, root: int | None = None) -> None:
        self.diagram = diagram
        target = diagram.root if root is None else root
        mem = diagram.mem
        ids = np.empty(diagram.nodes + 1, dtype=np.int32)
        ids = np.sort(ids[: kernels.find_nodes(mem, target, ids)])
        bits = sum(int(width).bit_length() for width in diagram.width) + 32
        self.primes: Int64Array = np.array(_primes(bits // 29 + 1), dtype=np.int64)
        children = int(mem[ids + 3].sum())
        self._batch = self._primes_at_once(ids.size, NODE_BYTES * ids.size + 4 * children)
        levels = mem[ids + 1]
        order = np.argsort(levels, kind="stable").astype(np.int64)
        rank = np.empty(ids.size, dtype=np.int64)
        rank[order] = np.arange(1, ids.size + 1)
        self.start: Int64Array = np.zeros(ids.size + 2, dtype=np.int64)
        self.first: Int64Array = np.zeros(ids.size + 1, dtype=np.int64)
        self.child: NDArray[np.int32] = np.zeros(children, dtype=np.int32)
        kernels.child_indices(mem, ids, order, rank, self.start, self.first, self.child)
        self.level_of = np.concatenate([[0], levels[order]]).astype(np.int64)
        self.levels: Int64Array = np.searchsorted(self.level_of, np.arange(diagram.top + 2)).astype(np.int64)
        self.root = int(rank[np.searchsorted(ids, target)]) if target > 1 else 0
        self._tables: tuple[int, Int64Array, Int64Array, Int64Array] | None = None
        self._vectors: int | None = None

    @property
    def nodes(self) -> int:
        """Number of nodes below the root, including the root but not the terminal."""
        return self.level_of.size - 1

    def vectors(self) -> int:
        """Number of vectors below the root."""
        if self._vectors is None:
            residues = [below[self.root] for _, below, _, _ in map(self._counted, self._batches())]
            self._vectors = _exact(np.concatenate(residues), self.primes)
        return self._vectors

    def in_boxes(self, boxes: Sequence[dict[int, Sequence[bool]]]) -> int:
        """Sum over boxes (encoding level -> allowed local states) of the number of vectors in each."""
        flat = [flat_box(self.diagram, box) for box in boxes if box]
        residues = []
        for first in self._batches():
            _, below, above, ways = self._counted(first)
            primes = self.primes[first : first + self._batch]
            answer = np.zeros(primes.size, dtype=np.int64)
            for masks, mask_start, top, bottom in flat:
                kernels.count_box(
                    self.start, self.first, self.child, self.levels, masks, mask_start, top, bottom, primes,
                    above, below, ways, answer,
                )  # fmt: skip
            residues.append(answer)
        return _exact(np.concatenate(residues), self.primes) + (len(boxes) - len(flat)) * self.vectors()

    def weighted(self, weights: Sequence[Sequence[int]]) -> int:
        """Sum over the vectors below the root of the product of ``weights[encoding level][local state]``."""
        below = np.zeros(self.nodes + 1, dtype=object)
        below[0] = 1
        for k, level in enumerate(self.diagram.order, start=1):
            nodes = np.arange(self.levels[k], self.levels[k + 1])
            if not nodes.size:
                continue
            first = int(self.start[nodes[0]])
            child = self.child[first : int(self.start[nodes[-1] + 1])]
            width = self.start[nodes + 1] - self.start[nodes]
            state = np.arange(first, first + child.size) + np.repeat(
                self.first[nodes] - self.start[nodes], width
            )
            ways = np.array(weights[level], dtype=object)[state] * below[np.maximum(child, 0)]
            ways[child < 0] = 0
            below[nodes] = np.add.reduceat(ways, self.start[nodes] - first)
        return int(below[self.root])

    def _primes_at_once(self, nodes: int, fixed: int) -> int:
        """Number of primes that fit in memory next to the diagram; a grown cache is reduced if necessary."""
        each = 3 * 8 * (nodes + 1)
        if self.diagram.bytes + fixed + each * self.primes.size > self.diagram.memory:
            self.diagram.shrink_cache()
        room = max(self.diagram.memory - self.diagram.bytes, SMALLEST_ROOM) - fixed
        if room < each:
            raise DiagramMemoryError("memory ran out while counting")
        return min(room // each, int(self.primes.size))

    def _batches(self) -> range:
        return range(0, self.primes.size, self._batch)

    def _counted(self, first: int) -> tuple[int, Int64Array, Int64Array, Int64Array]:
        """Return the ways below and above each node and a buffer, modulo the primes of a batch."""
        if self._tables is None or self._tables[0] != first:
            self._tables = None
            primes = self.primes[first : first + self._batch]
            below, above, ways = (np.zeros((self.nodes + 1, primes.size), dtype=np.int64) for _ in range(3))
            kernels.count_below(self.start, self.child, primes, below)
            kernels.count_above(self.start, self.child, self.root, primes, above)
            self._tables = (first, below, above, ways)
        return self._tables

    def largest(self, weights: Weights) -> int:
        """Largest sum, over the vectors below the root, of ``weights[encoding level][local state]``.

        Levels without weights do not count; only the nodes from the lowest to the highest level with weights
        are visited.
        """
        if not weights:
            return 0
        diagram = self.diagram
        at = sorted((int(diagram.position[level]), level) for level in weights)
        bottom, top = at[0][0], at[-1][0]
        begin = int(diagram.base[bottom])
        flat = np.zeros(int(diagram.base[top + 1]) - begin, dtype=np.int64)
        for k, level in at:
            flat[int(diagram.base[k]) - begin :][: len(weights[level])] = weights[level]
        return int(
            kernels.heaviest(
                self.start, self.first, self.child, flat, diagram.base - begin, self.level_of,
                int(self.levels[bottom]), int(self.levels[top]), int(self.levels[top + 1]), self._best,
            )
        )  # fmt: skip

    @cached_property
    def _best(self) -> Int64Array:
        return np.empty(self.nodes + 1, dtype=np.int64)

    def seen(self) -> list[list[int]]:
        """By encoding level: the local states that occur."""
        flags = np.zeros(int(self.diagram.base[-1]), dtype=np.uint8)
        kernels.local_states(self.start, self.first, self.child, self.level_of, self.diagram.base, flags)
        answer: list[list[int]] = [[] for _ in self.diagram.order]
        for k, level in enumerate(self.diagram.order, start=1):
            part = flags[int(self.diagram.base[k]) : int(self.diagram.base[k + 1])]
            answer[level] = np.flatnonzero(part).tolist()
        return answer


def flat_box(
    diagram: Diagram, box: dict[int, Sequence[bool]]
) -> tuple[NDArray[np.uint8], Int64Array, int, int]:
    """Return a box under the diagram's order: flags, start by level (-1: free), top and bottom level."""
    mask_start = np.full(diagram.top + 2, -1, dtype=np.int64)
    flags: list[bool] = []
    touched = sorted(int(diagram.position[level]) for level in box)
    for level, mask in box.items():
        mask_start[int(diagram.position[level])] = len(flags)
        flags.extend(mask)
    return np.array(flags, dtype=np.uint8), mask_start, touched[-1], touched[0]


def _primes(count: int) -> list[int]:
    primes: list[int] = []
    candidate = LARGEST_PRIME - 1
    while len(primes) < count:
        if _is_prime(candidate):
            primes.append(candidate)
        candidate -= 2
    return primes


def _is_prime(candidate: int) -> bool:
    """Test an odd number by Miller and Rabin; four bases decide below 3 215 031 751 (OEIS A014233)."""
    twos = (candidate - 1 & 1 - candidate).bit_length() - 1
    for base in (2, 3, 5, 7):
        power = pow(base, candidate - 1 >> twos, candidate)
        if power not in (1, candidate - 1) and all(
            (power := power * power % candidate) != candidate - 1 for _ in range(twos - 1)
        ):
            return False
    return True


def _exact(residues: Int64Array, primes: Int64Array) -> int:
    modulus = prod(int(p) for p in primes)
    total = 0
    for residue, prime in zip(residues.tolist(), primes.tolist(), strict=True):
        part = modulus // prime
        total += residue * part * pow(part, -1, prime)
    return total % modulus
