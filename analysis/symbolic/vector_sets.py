"""Sets of markings as nodes of a finished diagram: products of local states, sums of tokens, closures.

Nodes that Python refers to during another computation must be *pinned*; otherwise garbage collection may free
them. `Scope` pins them.
"""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.symbolic.kernels import diagrams as store
from dineros.analysis.symbolic.kernels import membership
from dineros.analysis.symbolic.kernels import saturation as machine
from dineros.analysis.symbolic.levels import Weights
from dineros.analysis.symbolic.open_boxes import Masks, OpenBoxes
from dineros.analysis.symbolic.relations import EventTables, Int64Array, Relations
from dineros.analysis.symbolic.saturation import FIRST_CLOSED_KEY, Diagram, DiagramMemoryError

#: Most seconds between two calls of a callback, unless a single operation takes longer.
SECONDS_UNTOLD = 0.1
#: Sets of open boxes that one walk may meet.
MOST_SETS = 5_000

#: By diagram: numbers of the transition sets that steps were restricted to, used as keys in its cache.
_RESTRICTIONS: WeakKeyDictionary[Diagram, dict[frozenset[int], int]] = WeakKeyDictionary()


class Scope:
    """Pins nodes of a diagram while a block runs: the nodes of the last call of `hold`."""

    def __init__(self, diagram: Diagram) -> None:
        self._pinned = diagram.pinned

    def __enter__(self) -> Scope:
        self._mark = len(self._pinned)
        return self

    def hold(self, *nodes: int) -> None:
        """Pin these nodes instead of the nodes pinned so far."""
        self._pinned[self._mark :] = nodes

    def __exit__(self, *exception: object) -> None:
        del self._pinned[self._mark :]


class VectorSets:
    """Operations on the sets of vectors of one finished diagram. Every set is identified by a node number.

    All methods raise `DiagramMemoryError` when memory runs out.

    Parameters
    ----------
    diagram : Diagram
        Its run is complete.
    budget : Budget, optional
        Receives regular progress reports; when its time runs out, the current operation ends.
    """

    def __init__(self, diagram: Diagram, budget: Budget = UNLIMITED) -> None:
        self.diagram = diagram
        self.budget = budget.begun()
        self._told = time.perf_counter()
        self._restriction = 0
        self._free = [1]
        for level in range(1, diagram.top + 1):
            self._free.append(diagram.node(level, [self._free[-1]] * int(diagram.width[level])))
            diagram.pinned.append(self._free[-1])

    def restricted(self, transitions: frozenset[int]) -> VectorSets:
        """Return the same sets with steps restricted to some transitions."""
        diagram = self.diagram
        events = tuple(event for event in diagram.encoding.events if event.transition in transitions)
        tables = EventTables.of(replace(diagram.encoding, events=events))
        numbers = _RESTRICTIONS.setdefault(diagram, {})
        part = copy(self)
        for hangs_on_steps in ("neighbours", "_relations"):
            part.__dict__.pop(hangs_on_steps, None)
        part._restriction = numbers.setdefault(transitions, len(numbers) + 1)
        part._relations = _kinds(Relations.under(tables, diagram.position), tables, diagram)
        return part

    @cached_property
    def _relations(self) -> dict[tuple[bool, bool], Relations]:
        """Events by (backwards, one event only)."""
        return _kinds(self.diagram.relations, self.diagram.events, self.diagram)

    def union(self, *sets: int) -> int:
        """Return the union of sets."""
        return self._fold(store.UNION, sets)

    def intersection(self, left: int, right: int) -> int:
        """Return the intersection of two sets."""
        return self._combine(left, right, store.INTERSECTION)

    def difference(self, left: int, right: int) -> int:
        """Return the first set without the second one."""
        return self._combine(left, right, store.DIFFERENCE)

    def box(self, masks: Masks) -> int:
        """Return all vectors of a product of sets of local states, reachable or not."""
        diagram = self.diagram
        if not masks:
            return self._free[-1]
        bottom = min(int(diagram.position[level]) for level in masks)
        node = self._free[bottom - 1]
        for at in range(bottom, diagram.top + 1):
            mask = masks.get(diagram.order[at - 1])
            width = int(diagram.width[at])
            node = diagram.node(at, [node] * width if mask is None else [node if m else 0 for m in mask])
        return node

    def sums(self, weights: Weights, low: int | None, high: int | None) -> int:
        """Return all vectors whose sum of ``weights[encoding level][local state]`` is in an interval."""
        diagram = self.diagram
        rows = [weights.get(level) or [0] * int(diagram.width[k]) for k, level in enumerate(diagram.order, 1)]
        least, most = [0], [0]
        for row in rows:
            least.append(least[-1] + min(row))
            most.append(most[-1] + max(row))

        def decided(at: int, above: int) -> int | None:
            fewest, largest = above + least[at], above + most[at]
            if (low is not None and largest < low) or (high is not None and fewest > high):
                return 0
            if (low is None or fewest >= low) and (high is None or largest <= high):
                return self._free[at]
            return None

        # Undecided sums of the levels above, from the top down; then nodes from the bottom up.
        pending: list[set[int]] = [{0}]
        for at in range(diagram.top, 0, -1):
            self._tell()
            open_sums = {above for above in pending[-1] if decided(at, above) is None}
            pending[-1] = open_sums
            pending.append({above + w for above in open_sums for w in rows[at - 1]})
        pending.reverse()
        below: dict[int, int] = {}
        with Scope(diagram) as scope:
            for at in range(1, diagram.top + 1):

                def child(above: int, at: int = at, below: dict[int, int] = below) -> int:
                    known = decided(at - 1, above)
                    return below[above] if known is None else known

                nodes: dict[int, int] = {}
                for above in pending[at]:
                    self._tell()
                    nodes[above] = diagram.node(at, [child(above + w) for w in rows[at - 1]])
                    scope.hold(*nodes.values(), *below.values())
                below = nodes
        known = decided(diagram.top, 0)
        return below[0] if known is None else known

    def without_boxes(self, states: int, boxes: Sequence[Masks]) -> int:
        """Return the set without the boxes.

        Boxes of one level are removed first, then those of two levels, and so on: what small boxes leave is
        often so small that many large ones together cost little. Those of one size are removed in one walk
        (see `open_boxes`).
        """
        if not all(boxes):
            return 0
        by_size: defaultdict[int, list[Masks]] = defaultdict(list)
        for box in boxes:
            by_size[len(box)].append(box)
        left = states
        for size in sorted(by_size):
            if left:
                left = self._without(left, by_size[size], states)
        return left

    def _without(self, states: int, boxes: Sequence[Masks], kept: int) -> int:
        """Return a set, which is not empty, without boxes, all removed in one walk; another set is kept.

        If boxes are open in too many combinations, each half of them is removed in a walk of its own. Most
        such combinations exist only because a walk does not see which boxes are empty below a node: if many
        clients wait and a server works for one of them, only the boxes of that client matter.
        """
        diagram = self.diagram
        boxes_left = OpenBoxes(diagram, boxes)
        try:
            while len(boxes_left) <= MOST_SETS or len(boxes) == 1:
                self._tell()
                result = int(
                    store.exclude(
                        states, 1, diagram.mem, diagram.heads, diagram.cache, diagram.control, diagram.free,
                        diagram.base, diagram.scratch, diagram.pending, boxes_left.state_class,
                        boxes_left.row, boxes_left.following, diagram.sets_of_boxes,
                    )
                )  # fmt: skip
                if not diagram.control[store.FAILED]:
                    return result
                if diagram.control[store.FAILED] == store.UNKNOWN:
                    diagram.control[store.FAILED] = 0
                    boxes_left.learn(result)
                else:
                    diagram.make_room([states, kept])
        finally:
            diagram.sets_of_boxes += len(boxes_left)
        half = len(boxes) // 2
        left = self._without(states, boxes[:half], kept)
        return self._without(left, boxes[half:], kept) if left else 0

    def single(self, vector: Sequence[int]) -> int:
        """Return the set of one vector, given by its local states in the order of the encoding's levels."""
        diagram = self.diagram
        node = 1
        for at in range(1, diagram.top + 1):
            children = [0] * int(diagram.width[at])
            children[vector[diagram.order[at - 1]]] = node
            node = diagram.node(at, children)
        return node

    def some(self, states: int) -> int:
        """Return a set of one vector from a set that is not empty."""
        return self.single(self.some_vector(states))

    def some_vector(self, states: int) -> list[int]:
        """Return a vector of a set that is not empty: local states in the order of the encoding's levels."""
        mem = self.diagram.mem
        vector = [0] * self.diagram.top
        for at in range(self.diagram.top, 0, -1):
            first, size = int(mem[states + 2]), int(mem[states + 3])
            children = mem[states + store.HEADER : states + store.HEADER + size]
            chosen = int(np.flatnonzero(children)[-1])
            vector[self.diagram.order[at - 1]] = first + chosen
            states = int(children[chosen])
        return vector

    def contains(self, states: int, vector: Sequence[int]) -> bool:
        """Return whether a set contains a vector (local states in the order of the encoding's levels)."""
        self._tell()
        at = np.array(vector, dtype=np.int64)
        return bool(membership.holds(self.diagram.mem, states, self._order, at))

    def descent(self, vector: Sequence[int], growing: Sequence[int]) -> list[int]:
        """Return numbers of encoding events that lead from a vector into the first of growing sets.

        Each step leads to the earliest set that an event reaches, and this must be an earlier set than
        before. The last set contains the vector.
        """
        mem, order, sets = self.diagram.mem, self._order, np.array(growing, dtype=np.int64)
        here = np.array(vector, dtype=np.int64)
        at = int(membership.first_with(mem, sets, sets.size, order, here))
        route: list[int] = []
        while at:
            self._tell()
            event, at = membership.earliest_step(mem, sets, at, order, here, *self._flat_events)
            if event < 0:
                raise ValueError("no step leads to an earlier set")
            for level, table in self.diagram.encoding.events[event].tables.items():
                here[level] = table[here[level]]
            route.append(int(event))
        return route

    @cached_property
    def _order(self) -> Int64Array:
        return np.array(self.diagram.order, dtype=np.int64)

    @cached_property
    def _flat_events(self) -> tuple[Int64Array, Int64Array, Int64Array, Int64Array]:
        """All events in the form for `membership.earliest_step`; events of one shape share their tables."""
        events = [event.tables for event in self.diagram.encoding.events]
        begins: dict[tuple[int, ...], int] = {}
        flat: list[int] = []
        for table in (table for tables in events for table in tables.values()):
            if table not in begins:
                begins[table] = len(flat)
                flat += table
        start = np.concatenate([[0], np.cumsum([len(tables) for tables in events])]).astype(np.int64)
        level = np.array([k for tables in events for k in tables], dtype=np.int64)
        table_begin = np.array([begins[t] for tables in events for t in tables.values()], dtype=np.int64)
        return start, level, table_begin, np.array(flat, dtype=np.int64)

    def closure(self, states: int, within: int, backwards: bool) -> int:
        """Return all vectors reachable from a set, or from which it is reachable, within another set."""
        with Scope(self.diagram) as scope:
            scope.hold(within)
            states = self.intersection(states, within)
            if states == 0 or self.diagram.top == 0:
                return states
            return self._drive(states, within, (backwards, False), 0)

    def last_part(self, states: int) -> tuple[int, bool]:
        """Return a strongly connected part that no step within the set leaves, and whether it is one marking.

        The set must not be empty.
        """
        with Scope(self.diagram) as scope:
            while True:
                scope.hold(states)
                start = self.some(states)
                scope.hold(states, start)
                ahead = self.closure(start, states, backwards=False)
                scope.hold(ahead, start)
                back = self.closure(start, ahead, backwards=True)
                scope.hold(ahead, start, back)
                states = self.difference(ahead, back)
                if states == 0:
                    return back, back == start

    def image(self, states: int, within: int, backwards: bool) -> int:
        """Return the successors, or predecessors, of a set within another set."""
        found = 0
        with Scope(self.diagram) as scope:
            for event in range(self.events):
                scope.hold(states, within, found)
                found = self.union(found, self.event_image(states, within, event, backwards))
        return found

    @property
    def events(self) -> int:
        """Number of events; events with the lowest top level come first."""
        return self._relations[False, False].event_relation.size - 1

    @cached_property
    def neighbours(self) -> list[list[int]]:
        """By event: the events that share a level with it."""
        relations = self._relations[False, False]
        levels = []
        for event in range(self.events):
            relation, touched = int(relations.event_relation[event]), set()
            while relation:
                touched.add(int(relations.level[relation]))
                relation = int(relations.next[relation])
            levels.append(touched)
        return [[e for e, there in enumerate(levels) if there & here] for here in levels]

    def event_image(self, states: int, within: int, event: int, backwards: bool) -> int:
        """Return the image of a set under one event, or under its reverse, within another set."""
        if states == 0 or within == 0:
            return 0
        relation = int(self._relations[backwards, True].event_relation[event])
        return self._drive(states, within, (backwards, True), relation)

    def _drive(self, states: int, within: int, kind: tuple[bool, bool], relation: int) -> int:
        self._tell()
        diagram, relations = self.diagram, self._relations[kind]
        top, control, frame = diagram.top, diagram.control, diagram.frame
        frame[:] = 0
        frame[top, machine.PHASE] = machine.FIRING if relation else machine.CLOSING
        frame[top, machine.NODE] = states
        frame[top, machine.CONSTRAINT] = within
        frame[top, machine.RELATION] = relation
        diagram.work[int(diagram.base[top]) :] = 0
        number = 1 + 4 * self._restriction + 2 * kind[0] + kind[1]
        control[store.FIRED_KEY] = number * diagram.most_relations
        control[store.CLOSED_KEY] = FIRST_CLOSED_KEY - number
        control[store.STILL] = kind[1]
        control[store.STACK] = top
        control[store.HAVE] = 0
        try:
            if not diagram.drive(top, relations, self.budget.report):
                raise DiagramMemoryError("memory ran out")
            return int(control[store.RESULT])
        finally:
            frame[:] = 0
            control[store.HAVE] = 0

    def _fold(self, operation: int, sets: Sequence[int]) -> int:
        result, *others = sets
        with Scope(self.diagram) as scope:
            for other in others:
                scope.hold(result, *others)
                result = self._combine(result, other, operation)
        return result

    def _combine(self, left: int, right: int, operation: int) -> int:
        self._tell()
        return self.diagram.combine(left, right, operation)

    def _tell(self) -> None:
        """Report progress if some time has passed: many short operations may take as long as one long one."""
        now = time.perf_counter()
        if now - self._told > SECONDS_UNTOLD:
            self._told = now
            self.budget.report(self.diagram.progress)


def _kinds(forward: Relations, tables: EventTables, diagram: Diagram) -> dict[tuple[bool, bool], Relations]:
    """Return events by (backwards, one event only); firing a single event makes no fixed points."""
    backward = Relations.under(tables.reversed(), diagram.position)
    nothing = np.zeros_like(forward.event_start)
    return {
        (False, False): forward,
        (True, False): backward,
        (False, True): replace(forward, event_start=nothing),
        (True, True): replace(backward, event_start=nothing),
    }
