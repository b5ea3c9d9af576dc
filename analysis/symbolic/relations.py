"""Events as chains of local tables under an order of the levels; equal tails are shared."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.symbolic.kernels.relations import chain
from dineros.analysis.symbolic.levels import Encoding
from dineros.analysis.symbolic.merging import merged

Int64Array = NDArray[np.int64]


@dataclass(frozen=True)
class EventTables:
    """The events of an encoding as flat arrays, before any order of the levels.

    Attributes
    ----------
    tables : int64 array
        All local tables one after another; table n is ``tables[start[n]:start[n + 1]]``.
    pair_start, pair_source, pair_target : int64 arrays
        The enabled entries of each table, in the order in which firing one can feed the next.
    event_start, event_level, event_table : int64 arrays
        Event e touches the levels ``event_level[event_start[e]:event_start[e + 1]]`` with those tables.
    """

    tables: Int64Array
    start: Int64Array
    pair_start: Int64Array
    pair_source: Int64Array
    pair_target: Int64Array
    event_start: Int64Array
    event_level: Int64Array
    event_table: Int64Array

    @classmethod
    def of(cls, encoding: Encoding) -> EventTables:
        """Flatten the events that change something; equal and similar ones become one."""
        changing = (event.tables for event in encoding.events if event.is_change)
        distinct = {tuple(sorted(tables.items())): tables for tables in changing}
        number: dict[tuple[int, ...], int] = {}
        rows: dict[tuple[tuple[int, int], ...], None] = {}
        for tables in merged(distinct.values()):
            steps = ((level, number.setdefault(table, len(number))) for level, table in tables.items())
            rows[tuple(sorted(steps))] = None
        pairs = [_sweep(table) for table in number]
        flat_pairs = [pair for entries in pairs for pair in entries]
        flat_rows = [step for row in rows for step in row]
        return cls(
            _array([j for table in number for j in table]),
            _pointer([len(table) for table in number]),
            _pointer([len(entries) for entries in pairs]),
            _array([i for i, _ in flat_pairs]),
            _array([j for _, j in flat_pairs]),
            _pointer([len(row) for row in rows]),
            _array([level for level, _ in flat_rows]),
            _array([table for _, table in flat_rows]),
        )

    def reversed(self) -> EventTables:
        """Return the reversed events; each is injective, because it moves fixed numbers of tokens."""
        tables = np.full_like(self.tables, -1)
        source, target = self.pair_source.copy(), self.pair_target.copy()
        for n in range(self.start.size - 1):
            first = int(self.start[n])
            table = self.tables[first : int(self.start[n + 1])]
            enabled = np.flatnonzero(table >= 0)
            tables[first + table[enabled]] = enabled
            pairs = _sweep(tuple(tables[first : int(self.start[n + 1])].tolist()))
            part = slice(int(self.pair_start[n]), int(self.pair_start[n + 1]))
            source[part], target[part] = zip(*pairs, strict=True)
        return replace(self, tables=tables, pair_source=source, pair_target=target)

    @cached_property
    def levels_of_events(self) -> list[list[int]]:
        """By event: the levels it touches."""
        return [part.tolist() for part in np.split(self.event_level, self.event_start[1:-1])]


@dataclass(frozen=True)
class Relations:
    """Events under one order: relation r applies a table at its level, then ``next[r]`` further down.

    Relation 0 is the identity; a table begins at ``tables[table[r]]``. ``event_start[k]:event_start[k + 1]``
    are the events with top level k; their first tables' enabled entries are ``pair_source``/``pair_target``,
    delimited by ``pair_start``.
    """

    tables: Int64Array
    level: Int64Array
    table: Int64Array
    next: Int64Array
    event_start: Int64Array
    event_relation: Int64Array
    pair_start: Int64Array
    pair_source: Int64Array
    pair_target: Int64Array
    fired: Int64Array

    @classmethod
    def under(cls, tables: EventTables, position: Int64Array) -> Relations:
        """Chain the events where encoding level n sits at diagram level ``position[n]`` (1 is the bottom)."""
        steps = tables.event_level.size
        events = tables.event_start.size - 1
        level, table, below = (np.zeros(steps + 1, dtype=np.int64) for _ in range(3))
        event_start = np.zeros(position.size + 2, dtype=np.int64)
        event_relation = np.zeros(events + 1, dtype=np.int64)
        pair_start = np.zeros(events + 2, dtype=np.int64)
        entries = np.diff(tables.pair_start)
        room = int(entries[tables.event_table].sum()) + 1
        source, target = np.zeros(room, dtype=np.int64), np.zeros(room, dtype=np.int64)
        chain(
            position, tables.start, tables.pair_start, tables.pair_source, tables.pair_target,
            tables.event_start, tables.event_level, tables.event_table, level, table, below, event_start,
            event_relation, pair_start, source, target,
        )  # fmt: skip
        fired = np.zeros(room, dtype=np.int64)
        return cls(
            tables.tables, level, table, below, event_start, event_relation, pair_start, source, target, fired
        )


def _sweep(table: tuple[int, ...]) -> list[tuple[int, int]]:
    pairs = [(i, j) for i, j in enumerate(table) if j >= 0]
    return pairs[::-1] if sum(j < i for i, j in pairs) * 2 > len(pairs) else pairs


def _array(values: list[int]) -> Int64Array:
    return np.array(values, dtype=np.int64)


def _pointer(lengths: list[int]) -> Int64Array:
    return np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
