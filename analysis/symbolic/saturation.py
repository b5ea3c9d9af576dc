"""Saturation runs: compute the diagram of the reachable markings from an encoding and an order of levels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.answers.budget import Progress, ProgressCallback
from dineros.analysis.symbolic.kernels import diagrams as store
from dineros.analysis.symbolic.kernels import saturation as machine
from dineros.analysis.symbolic.levels import Encoding
from dineros.analysis.symbolic.relations import EventTables, Relations

Int32Array = NDArray[np.int32]
Int64Array = NDArray[np.int64]

FIRST_CACHE = 1 << 18
FIRST_BUCKETS = 1 << 16
SMALLEST_STORE = 1 << 12
EFFORT_PER_CALL = 200_000
#: Cache misses per entry of the cache above which the cache grows.
FULL_CACHE = 0.5
#: Shares of the memory: nodes; hash table; cache. The rest is for the stack of the garbage collector: one
#: word for each node, and a node has at least six words.
STORE_SHARE, BUCKET_SHARE, CACHE_SHARE = 1 / 2, 1 / 6, 1 / 4
#: Key of closures of nodes in the cache, distinct from operations; smaller keys are for other kinds of runs.
FIRST_CLOSED_KEY = -8


class Diagram:
    """A node store with the arrays of one saturation run; `restart` reuses it with another order.

    Parameters
    ----------
    order
        Indices of the encoding's levels, bottom first.
    memory
        Bytes that store, hash table, cache and garbage-collector stack may take together.
    first_cache, first_buckets
        Initial entries of the cache and of the hash table (powers of two); both grow with the diagram.
    most_cache
        Entries that the cache may grow to; None: as many as the memory allows.

    Attributes
    ----------
    root : int
        Node of the reachable markings, once the run is complete.
    pinned : list of int
        Further nodes that garbage collection keeps.
    out_of_memory : bool
        Whether memory ended the last run.
    saturated : int
        Number of levels, from the bottom, that the run has finished.
    """

    def __init__(
        self,
        encoding: Encoding,
        order: Sequence[int],
        memory: int,
        first_cache: int = FIRST_CACHE,
        first_buckets: int = FIRST_BUCKETS,
        most_cache: int | None = None,
    ) -> None:
        self.encoding = encoding
        self._most_cache: int | None = most_cache
        self.top = len(encoding.levels)
        self.memory = memory
        self.events = EventTables.of(encoding)
        # Fewer events may be merged less, so a restriction may have more relations than all events.
        self.most_relations = 2 + sum(len(event.tables) for event in encoding.events)
        self.control = np.zeros(store.CONTROL_SIZE, dtype=np.int64)
        # Untouched pages of the store cost nothing.
        words = min(max(int(memory * STORE_SHARE) // 4, SMALLEST_STORE), 2**31 - 1)
        self.mem: Int32Array = np.empty(words, dtype=np.int32)
        self.mem[: store.FIRST_NODE] = 0
        widest = max((len(level.states) for level in encoding.levels), default=1)
        total = 1 + sum(len(level.states) for level in encoding.levels)
        self.free: Int32Array = np.zeros(widest + 1, dtype=np.int32)
        self.heads: Int32Array = np.zeros(first_buckets, dtype=np.int32)
        self.cache: Int32Array = np.zeros(first_cache * 4, dtype=np.int32)
        self.scratch: Int32Array = np.zeros(total, dtype=np.int32)
        self.pending: Int64Array = np.zeros((self.top + 2, 4), dtype=np.int64)
        self.work: Int32Array = np.zeros(total, dtype=np.int32)
        self.changed: Int64Array = np.zeros(total, dtype=np.int64)
        self.frame: Int64Array = np.zeros((self.top + 2, machine.FRAME_SIZE), dtype=np.int64)
        self._set_order(order)

    def restart(self, order: Sequence[int]) -> None:
        """Discard all results and set another order."""
        for array in (self.control, self.free, self.heads, self.cache, self.work, self.frame):
            array[:] = 0
        self._set_order(order)

    def _set_order(self, order: Sequence[int]) -> None:
        """Begin with an order; the arrays are empty, and their untouched pages cost nothing."""
        self.order = tuple(order)
        position = np.zeros(self.top, dtype=np.int64)
        position[list(self.order)] = np.arange(1, self.top + 1)
        self.position = position
        self.relations = Relations.under(self.events, position)
        widths = [len(self.encoding.levels[k].states) for k in self.order]
        self.width = np.array([1, *widths], dtype=np.int64)
        self.base = np.concatenate([[0], np.cumsum(self.width)]).astype(np.int64)
        self.control[store.POOL_TOP] = store.FIRST_NODE
        self.control[store.POOL_LIMIT] = self.mem.size
        self.control[store.BUCKET_MASK] = self.heads.size - 1
        self.control[store.CACHE_MASK] = self.cache.size // 4 - 1
        self.control[store.CLOSED_KEY] = FIRST_CLOSED_KEY
        self.root = 0
        self.saturated = 0
        self._below, self._is_begun = 1, False
        self.pinned: list[int] = []
        self.sets_of_boxes = 0
        self.collections = 0
        self.peak_nodes = 0
        self.complete = False
        self.out_of_memory = False

    def run(
        self,
        progress: ProgressCallback | None = None,
        effort_limit: int | None = None,
    ) -> bool:
        """Make the diagram of the reachable markings; False if a limit or the memory ended the run early.

        After a limit, another call continues the run.

        Parameters
        ----------
        progress
            Called regularly, and at the end.
        effort_limit
            Number of cache misses (firings and unions actually computed) since the restart, after which the
            run is ended.
        """
        while self.saturated < self.top:
            level = self.saturated + 1
            if not self._is_begun:
                self._start(level, self._below)
                self._is_begun = True
            if not self.drive(level, self.relations, progress, effort_limit):
                return False
            self._below, self._is_begun = int(self.control[store.RESULT]), False
            self.control[store.HAVE] = 0
            self.saturated = level
        self.root = self._below
        self.complete = True
        if progress is not None:
            progress(self.progress)
        return True

    def finish(self, root: int) -> None:
        """End a run that was made by other means than `run`: discard its cached results, keep its set."""
        self.cache[:] = 0
        self.frame[:] = 0
        self.control[[store.LOWEST, store.HAVE, store.FIRED_KEY]] = 0
        self.control[store.CLOSED_KEY] = FIRST_CLOSED_KEY
        self._most_cache = None
        self.root, self.saturated, self.complete = root, self.top, True

    def drive(
        self,
        top: int,
        relations: Relations,
        progress: ProgressCallback | None = None,
        effort_limit: int | None = None,
    ) -> bool:
        """Run the machine until the frame of a level is finished; False if a limit or the memory ended it.

        Parameters
        ----------
        top
            The level; its frame must be set up, and no frame of a level above.
        relations
            Events to fire.
        """
        while True:
            room = int(self.heads.size) * 2 if self._may_grow() else int(self.mem.size)
            pause = self.effort + EFFORT_PER_CALL
            limit = pause if effort_limit is None else min(pause, effort_limit)
            status = self._saturate(top, relations, limit, room)
            self.peak_nodes = max(self.peak_nodes, self.nodes)
            if status == machine.DONE:
                return True
            if status == machine.STORE_FULL:
                if not self._collect():
                    self.out_of_memory = True
                    return False
            elif self.nodes > room:
                self._grow()
            elif effort_limit is not None and self.effort >= effort_limit:
                return False
            elif self.effort > FULL_CACHE * (self.cache.size // 4):
                # There are more results than entries: results that were evicted are computed again.
                self._grow_cache(self.cache.size)
            if progress is not None:
                progress(self.progress)

    @property
    def progress(self) -> Progress:
        """Return the progress of the run."""
        return Progress("nodes", self.nodes, self.bytes)

    @property
    def effort(self) -> int:
        """Number of firings and unions computed so far; orders are compared by it."""
        return int(self.control[store.MISSES])

    @property
    def nodes(self) -> int:
        """Number of nodes in the store, including unreachable ones that were not collected yet."""
        return int(self.control[store.NODES])

    @property
    def bytes(self) -> int:
        """Bytes of memory used by store, hash table and cache."""
        return int(self.control[store.POOL_TOP]) * 4 + self.heads.nbytes + self.cache.nbytes

    def collect(self, roots: Sequence[int]) -> None:
        """Free every node that neither the pinned nodes nor one of the roots reaches."""
        stack = np.empty(int(self.control[store.NODES]) + 1, dtype=np.int32)
        for root in {*roots, *self.pinned, self.root}:
            store.mark(self.mem, root, stack)
        store.sweep(self.mem, self.heads, self.cache, self.control, self.free)
        self.collections += 1

    def shrink_cache(self) -> None:
        """Discard the cached results and free the memory of a cache that has grown."""
        if self.cache.size > FIRST_CACHE * 4:
            self.cache = np.zeros(FIRST_CACHE * 4, dtype=np.int32)
            self.control[store.CACHE_MASK] = FIRST_CACHE - 1

    def combine(self, left: int, right: int, operation: int) -> int:
        """Union, intersection or difference of two sets, by the code of the operation.

        Raises
        ------
        DiagramMemoryError
            If memory runs out.
        """
        while True:
            result = int(
                store.combine(
                    left, right, operation, self.mem, self.heads, self.cache, self.control, self.free,
                    self.base, self.scratch, self.pending,
                )
            )  # fmt: skip
            if not self.control[store.FAILED]:
                return result
            self.make_room([left, right])

    def node(self, level: int, children: Sequence[int]) -> int:
        """Node of a level with these children, one per local state.

        Raises
        ------
        DiagramMemoryError
            If memory runs out.
        """
        start = int(self.base[level])
        self.scratch[start : start + len(children)] = children
        while True:
            result = int(
                store.make_node(
                    self.mem, self.heads, self.control, self.free, level, self.scratch, start, 0,
                    len(children),
                )
            )  # fmt: skip
            if not self.control[store.FAILED]:
                return result
            self.make_room(children)

    def make_room(self, roots: Sequence[int]) -> None:
        """Collect garbage after the store was found full.

        Raises
        ------
        DiagramMemoryError
            If garbage collection frees too little.
        """
        if self.control[store.FAILED] == store.UNFINISHED:
            roots = [*roots, *self.scratch.tolist()]
        self.control[store.FAILED] = 0
        before = self.nodes
        self.collect(roots)
        if self.nodes >= before * 9 // 10:
            raise DiagramMemoryError("memory ran out")

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

    def _saturate(self, top: int, r: Relations, effort: int, nodes: int) -> int:
        return int(
            machine.saturate(
                self.mem, self.heads, self.cache, self.control, self.free, self.base, self.width,
                self.scratch, self.pending, self.work, self.changed, self.frame, r.level, r.table, r.next,
                r.tables, r.event_start, r.event_relation, r.pair_start, r.pair_source,
                r.pair_target, r.fired, top, effort, nodes,
            )
        )  # fmt: skip

    def _collect(self) -> bool:
        stack_level = int(self.control[store.STACK])
        roots = self.work[int(self.base[stack_level]) :].tolist()
        roots += self.frame[stack_level:, machine.NODE].tolist()
        roots += self.frame[stack_level:, machine.OPENED].tolist()
        roots += self.frame[stack_level:, machine.CONSTRAINT].tolist()
        if self.control[store.HAVE]:
            roots.append(int(self.control[store.RESULT]))
        try:
            self.make_room(roots)
        except DiagramMemoryError:
            return False
        return True

    def _may_grow(self) -> bool:
        return self.heads.nbytes * 4 <= self.memory * BUCKET_SHARE

    def _grow(self) -> None:
        size = int(self.heads.size) * 4
        self.heads = np.zeros(size, dtype=np.int32)
        self.control[store.BUCKET_MASK] = size - 1
        store.rehash(self.mem, self.heads, self.control, self.free, False)
        self._grow_cache(size * 4)

    def _grow_cache(self, entries: int) -> None:
        """Grow the cache to a number of entries if there is enough memory."""
        entries = min(entries, self._most_cache or entries)
        # While entries are copied, both caches exist.
        if entries * 16 * 5 // 4 <= self.memory * CACHE_SHARE and entries * 4 > self.cache.size:
            old, self.cache = self.cache, np.zeros(entries * 4, dtype=np.int32)
            self.control[store.CACHE_MASK] = entries - 1
            machine.transfer(old, self.cache, self.control)


class DiagramMemoryError(Exception):
    """The memory of a diagram ran out. Never leaves the analysis: answers become ``unknown``."""
