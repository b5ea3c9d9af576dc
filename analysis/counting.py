"""Exact counts on a finished decision diagram: markings, arcs, deadlocks, largest tokens."""

from __future__ import annotations

from collections.abc import Sequence
from math import isqrt, prod

import numpy as np
from numpy.typing import NDArray

from dineros.analysis import counting_kernels as kernels
from dineros.analysis import diagram_kernels as store
from dineros.analysis.box_kernels import subtract_box
from dineros.analysis.saturation import Diagram

Int64Array = NDArray[np.int64]
LARGEST_PRIME = 1 << 30


class DiagramCounts:
    """A finished diagram, renumbered for counting.

    Parameters
    ----------
    diagram
        A diagram whose run is complete. Its garbage is collected.
    root
        Node to count below; the diagram's root by default.
    """

    def __init__(self, diagram: Diagram, root: int | None = None) -> None:
        self.diagram = diagram
        target = diagram.root if root is None else root
        diagram.collect([diagram.root, target])
        mem = diagram.mem
        room = np.empty(diagram.nodes, dtype=np.int32)
        found = kernels.find_nodes(mem, int(diagram.control[store.POOL_TOP]), room)
        ids = room[:found]
        levels = mem[ids + 1]
        order = np.argsort(levels, kind="stable").astype(np.int64)
        rank = np.empty(ids.size, dtype=np.int64)
        rank[order] = np.arange(1, ids.size + 1)
        self.start: Int64Array = np.zeros(ids.size + 2, dtype=np.int64)
        self.first: Int64Array = np.zeros(ids.size + 1, dtype=np.int64)
        self.child: NDArray[np.int32] = np.zeros(int(mem[ids + 3].sum()), dtype=np.int32)
        kernels.child_indices(mem, ids, order, rank, self.start, self.first, self.child)
        self.level_of = np.concatenate([[0], levels[order]]).astype(np.int64)
        self.levels: Int64Array = np.searchsorted(self.level_of, np.arange(diagram.top + 2)).astype(np.int64)
        self.root = int(rank[np.searchsorted(ids, target)]) if target > 1 else 0
        bits = sum(int(width).bit_length() for width in diagram.width) + 32
        self.primes: Int64Array = np.array(_primes(bits // 29 + 1), dtype=np.int64)
        self._below: Int64Array = np.zeros((ids.size + 1, self.primes.size), dtype=np.int64)
        kernels.count_below(self.start, self.child, self.primes, self._below)
        self._above: Int64Array | None = None

    @property
    def nodes(self) -> int:
        """Nodes of the diagram, the terminal not counted."""
        return self.level_of.size - 1

    def vectors(self) -> int:
        """Number of vectors below the root."""
        return _exact(self._below[self.root], self.primes)

    def in_boxes(self, boxes: Sequence[dict[int, Sequence[bool]]]) -> int:
        """Sum over boxes (encoding level -> allowed local states) of the number of vectors in each."""
        if self._above is None:
            self._above = np.zeros_like(self._below)
            kernels.count_above(self.start, self.child, self.root, self.primes, self._above)
        answer = np.zeros(self.primes.size, dtype=np.int64)
        ways = np.zeros_like(self._below)
        free = 0
        for box in boxes:
            if not box:
                free += 1
                continue
            masks, mask_start, top, bottom = flat_box(self.diagram, box)
            kernels.count_box(
                self.start, self.first, self.child, self.levels, masks, mask_start, top, bottom, self.primes,
                self._above, self._below, ways, answer,
            )  # fmt: skip
        return _exact(answer, self.primes) + free * self.vectors()

    def largest(self, weights: Sequence[Sequence[int]]) -> int:
        """Largest sum, over the vectors below the root, of ``weights[encoding level][local state]``."""
        flat = np.array([w for k in self.diagram.order for w in weights[k]], dtype=np.int64)
        best = np.zeros(self.nodes + 1, dtype=np.int64)
        kernels.heaviest(self.start, self.first, self.child, self.level_of, flat, self.diagram.base - 1, best)
        return int(best[self.root])

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


def subtract_boxes(diagram: Diagram, boxes: Sequence[dict[int, Sequence[bool]]]) -> int | None:
    """Node of the reachable vectors that lie in none of the boxes; None when memory runs out.

    Boxes with the fewest levels come first: they cut away most.
    """
    node = diagram.root
    ordered = sorted(boxes, key=lambda box: (len(box), sorted(int(diagram.position[k]) for k in box)))
    for box in ordered:
        if node == 0 or not box:
            return 0
        masks, mask_start, _, bottom = flat_box(diagram, box)
        diagram.operations += 1
        while True:
            result = int(
                subtract_box(
                    node, diagram.operations, diagram.mem, diagram.heads, diagram.cache, diagram.control,
                    diagram.free, diagram.base, diagram.scratch, diagram.pending, masks, mask_start, bottom,
                )
            )  # fmt: skip
            if not diagram.control[store.FAILED]:
                break
            before = diagram.nodes
            diagram.control[store.FAILED] = 0
            diagram.collect([diagram.root, node])
            if diagram.nodes > before * 9 // 10:
                return None
        node = result
    return node


def _primes(count: int) -> list[int]:
    primes: list[int] = []
    candidate = LARGEST_PRIME - 1
    while len(primes) < count:
        if all(candidate % divisor for divisor in range(3, isqrt(candidate) + 1, 2)):
            primes.append(candidate)
        candidate -= 2
    return primes


def _exact(residues: Int64Array, primes: Int64Array) -> int:
    modulus = prod(int(p) for p in primes)
    total = 0
    for residue, prime in zip(residues.tolist(), primes.tolist(), strict=True):
        part = modulus // prime
        total += residue * part * pow(part, -1, prime)
    return total % modulus
