"""Saturation runs: an encoding and an order of its levels become a diagram of the reachable markings."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dineros.analysis import diagram_kernels as store
from dineros.analysis import saturation_kernels as machine
from dineros.analysis.levels import Encoding
from dineros.analysis.relations import EventTables, Relations

Int32Array = NDArray[np.int32]
Int64Array = NDArray[np.int64]

FIRST_CACHE = 1 << 18
FIRST_BUCKETS = 1 << 16
SMALLEST_STORE = 1 << 12
EFFORT_PER_CALL = 200_000


@dataclass(frozen=True)
class Progress:
    """How far a run is.

    Attributes
    ----------
    nodes : int
        Nodes of the diagram in the store.
    bytes : int
        Memory touched by store, hash table and cache.
    seconds : float
        Since the run began.
    level, levels : int
        Level whose fixed point is being made, and how many there are.
    """

    nodes: int
    bytes: int
    seconds: float
    level: int
    levels: int


class Diagram:
    """A node store with the arrays of one saturation run; `restart` uses it again under another order.

    Parameters
    ----------
    encoding
        Levels and events.
    order
        Indices of the encoding's levels, bottom first.
    memory
        Bytes that store, hash table and cache may take together.
    first_cache, first_buckets
        Entries of the cache and of the hash table to begin with (powers of two); both grow with the diagram.
    """

    def __init__(
        self,
        encoding: Encoding,
        order: Sequence[int],
        memory: int,
        first_cache: int = FIRST_CACHE,
        first_buckets: int = FIRST_BUCKETS,
    ) -> None:
        self.encoding = encoding
        self.top = len(encoding.levels)
        self.memory = memory
        self.events = EventTables.of(encoding)
        self.control = np.zeros(store.CONTROL_SIZE, dtype=np.int64)
        # Three quarters of the budget are the store; untouched pages of it cost nothing.
        words = min(max(memory * 3 // 4 // 4, SMALLEST_STORE), 2**31 - 1)
        self.mem: Int32Array = np.empty(words, dtype=np.int32)
        self.mem[: store.FIRST_NODE] = 0
        widest = max((len(level.states) for level in encoding.levels), default=1)
        total = 1 + sum(len(level.states) for level in encoding.levels)
        self.free: Int32Array = np.zeros(widest + 1, dtype=np.int32)
        self.heads: Int32Array = np.zeros(first_buckets, dtype=np.int32)
        self.cache: Int32Array = np.zeros(first_cache * 4, dtype=np.int32)
        self.scratch: Int32Array = np.zeros(total, dtype=np.int32)
        self.pending: Int64Array = np.zeros((self.top + 2, 3), dtype=np.int64)
        self.work: Int32Array = np.zeros(total, dtype=np.int32)
        self.changed: Int64Array = np.zeros(total, dtype=np.int64)
        self.frame: Int64Array = np.zeros((self.top + 2, machine.FRAME_SIZE), dtype=np.int64)
        self.restart(order)

    def restart(self, order: Sequence[int]) -> None:
        """Forget everything and take another order."""
        self.order = tuple(order)
        position = np.zeros(self.top, dtype=np.int64)
        position[list(self.order)] = np.arange(1, self.top + 1)
        self.position = position
        self.relations = Relations.under(self.events, position)
        widths = [len(self.encoding.levels[k].states) for k in self.order]
        self.width = np.array([1, *widths], dtype=np.int64)
        self.base = np.concatenate([[0], np.cumsum(self.width)]).astype(np.int64)
        self.control[:] = 0
        self.control[store.POOL_TOP] = store.FIRST_NODE
        self.control[store.POOL_LIMIT] = self.mem.size
        self.control[store.BUCKET_MASK] = self.heads.size - 1
        self.control[store.CACHE_MASK] = self.cache.size // 4 - 1
        for array in (self.free, self.heads, self.cache, self.work):
            array[:] = 0
        self.frame[:] = 0
        self.root = 0
        self.collections = 0
        self.operations = 0
        self.peak_nodes = 0
        self.complete = False

    def run(
        self,
        progress: Callable[[Progress], None] | None = None,
        effort_limit: int | None = None,
        deadline: float | None = None,
    ) -> bool:
        """Make the diagram of the reachable markings; False when a limit or the memory ended it early.

        Parameters
        ----------
        progress
            Called now and then.
        effort_limit
            Cache misses (firings and unions really computed) at which to give up.
        deadline
            Value of ``time.perf_counter()`` at which to give up.
        """
        began = time.perf_counter()
        child = 1
        for k in range(1, self.top + 1):
            self._start(k, child)
            while True:
                room = int(self.heads.size) * 2
                pause = self.effort + EFFORT_PER_CALL
                limit = pause if effort_limit is None else min(pause, effort_limit)
                status = self._saturate(k, limit, room)
                self.peak_nodes = max(self.peak_nodes, self.nodes)
                if status == machine.DONE:
                    break
                if status == machine.STORE_FULL:
                    if not self._collect():
                        return False
                elif self.nodes > room:
                    self._grow()
                elif effort_limit is not None and self.effort >= effort_limit:
                    return False
                if deadline is not None and time.perf_counter() > deadline:
                    return False
                if progress is not None:
                    progress(Progress(self.nodes, self.bytes, time.perf_counter() - began, k, self.top))
            child = int(self.control[store.RESULT])
            self.control[store.HAVE] = 0
        self.root = child
        self.complete = True
        return True

    @property
    def effort(self) -> int:
        """Firings and unions computed so far: the measure by which orders are compared."""
        return int(self.control[store.MISSES])

    @property
    def nodes(self) -> int:
        """Nodes in the store, dead ones that were not collected yet included."""
        return int(self.control[store.NODES])

    @property
    def bytes(self) -> int:
        """Memory touched by store, hash table and cache."""
        return int(self.control[store.POOL_TOP]) * 4 + self.heads.nbytes + self.cache.nbytes

    def collect(self, roots: Sequence[int]) -> None:
        """Free every node that none of the roots reaches."""
        stack = np.empty(int(self.control[store.NODES]) + 1, dtype=np.int32)
        for root in roots:
            store.mark(self.mem, root, stack)
        store.sweep(self.mem, self.heads, self.cache, self.control, self.free)
        self.collections += 1

    def _start(self, k: int, child: int) -> None:
        start, end = int(self.base[k]), int(self.base[k + 1])
        initial = self.encoding.levels[self.order[k - 1]].initial
        self.work[start:end] = 0
        self.changed[start:end] = 1
        self.work[start + initial] = child
        self.frame[k] = 0
        self.frame[k, machine.PHASE] = machine.SATURATING
        machine.begin(
            k, self.frame, self.relations.event_start, self.relations.pair_start, self.relations.fired
        )
        self.control[store.STACK] = k
        self.control[store.HAVE] = 0

    def _saturate(self, k: int, effort: int, nodes: int) -> int:
        r = self.relations
        return int(
            machine.saturate(
                self.mem, self.heads, self.cache, self.control, self.free, self.base, self.width,
                self.scratch, self.pending, self.work, self.changed, self.frame, r.level, r.table, r.next,
                self.events.tables, r.event_start, r.event_relation, r.pair_start, r.pair_source,
                r.pair_target, r.fired, k, effort, nodes,
            )
        )  # fmt: skip

    def _collect(self) -> bool:
        self.control[store.FAILED] = 0
        stack_level = int(self.control[store.STACK])
        roots = self.work[int(self.base[stack_level]) :].tolist()
        roots += self.frame[stack_level:, machine.NODE].tolist()
        if self.control[store.HAVE]:
            roots.append(int(self.control[store.RESULT]))
        before = self.nodes
        self.collect([root for root in roots if root])
        return self.nodes < before * 9 // 10

    def _grow(self) -> None:
        size = int(self.heads.size) * 4
        self.heads = np.zeros(size, dtype=np.int32)
        self.control[store.BUCKET_MASK] = size - 1
        store.rehash(self.mem, self.heads, self.control, self.free, False)
        if size * 4 * 16 <= self.memory // 4:
            old, self.cache = self.cache, np.zeros(size * 4 * 4, dtype=np.int32)
            self.control[store.CACHE_MASK] = size * 4 - 1
            machine.transfer(old, self.cache, self.control)
