"""Events that differ in one level only, as one event: reads of many counters, moves through many colours.

The tables of such events on that level become one table if no local state enables two of them. If no two of
them lead to the same local state either, the event can be reversed as before. A table that changes nothing
and is enabled everywhere asks for nothing: then the event does not touch the level at all.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence

Table = tuple[int, ...]
#: Events with which an event is compared; others with the same rest have been compared before.
COMPARED = 4
#: Passes over all levels: an event that is merged on one level may be merged on another one after that.
PASSES = 3


def merged(events: Iterable[Mapping[int, Table]]) -> list[dict[int, Table]]:
    """Return events with the same steps altogether; each step belongs to as many events as before.

    Examples
    --------
    >>> merged([{0: (1, -1, -1), 1: (0, -1)}, {0: (-1, 2, -1), 1: (0, -1)}])
    [{0: (1, 2, -1), 1: (0, -1)}]
    >>> merged([{0: (0, -1), 1: (1, -1)}, {0: (-1, 1), 1: (1, -1)}])
    [{1: (1, -1)}]
    """
    return _Merging(events).events()


def masks_of(events: Iterable[Mapping[int, Table]]) -> list[dict[int, Sequence[bool]]]:
    """Return where events are enabled; levels on which they always are have no flags."""
    flags: dict[Table, tuple[bool, ...]] = {}
    masks: list[dict[int, Sequence[bool]]] = []
    for tables in events:
        for table in tables.values():
            if table not in flags:
                flags[table] = tuple(j >= 0 for j in table)
        enabled = {k: flags[table] for k, table in tables.items()}
        masks.append({k: each for k, each in enabled.items() if not all(each)})
    return masks


def masks_of_tests(events: Iterable[Mapping[int, Table]]) -> list[dict[int, Sequence[bool]]]:
    """Return where events are enabled, each marking as often as there are such events, in few products.

    The changes of an event do not matter there: events with different changes can be merged, too.
    """
    idle: dict[Table, Table] = {}  # many events share their tables
    tests: list[dict[int, Table]] = []
    for event in events:
        for table in event.values():
            if table not in idle:
                idle[table] = tuple(i if j >= 0 else -1 for i, j in enumerate(table))
        tests.append({level: idle[table] for level, table in event.items()})
    return masks_of(merged(tests))


class _Merging:
    def __init__(self, events: Iterable[Mapping[int, Table]]) -> None:
        self._tables: list[Table] = []
        self._number: dict[Table, int] = {}
        #: By table: enabled local states, and those they lead to, as bits.
        self._sources: list[int] = []
        self._targets: list[int] = []
        self._rows: list[dict[int, int] | None] = [
            {level: self._numbered(table) for level, table in sorted(event.items())} for event in events
        ]

    def events(self) -> list[dict[int, Table]]:
        """Merge, and return what is left."""
        for _ in range(PASSES):
            if not self._pass():
                break
        return [
            {level: self._tables[number] for level, number in row.items()}
            for row in self._rows
            if row is not None
        ]

    def _pass(self) -> bool:
        of_level: defaultdict[int, list[int]] = defaultdict(list)
        for number, row in enumerate(self._rows):
            for level in row or ():
                of_level[level].append(number)
        return sum(self._merge(level, rows) for level, rows in sorted(of_level.items())) > 0

    def _merge(self, level: int, numbers: Sequence[int]) -> int:
        """Merge events on one level; return how many were removed."""
        alike: defaultdict[tuple[tuple[int, int], ...], list[int]] = defaultdict(list)
        for number in numbers:
            row = self._rows[number]
            if row is not None and level in row:
                alike[tuple(step for step in row.items() if step[0] != level)].append(number)
        return sum(self._merge_alike(level, rows) for rows in alike.values() if len(rows) > 1)

    def _merge_alike(self, level: int, numbers: Sequence[int]) -> int:
        # By merged event: its number, the tables, and their sources and targets.
        parts: list[tuple[int, list[int], int, int]] = []
        for number in numbers:
            row = self._rows[number]
            assert row is not None
            table = row[level]
            sources, targets = self._sources[table], self._targets[table]
            for at in range(len(parts) - 1, max(len(parts) - COMPARED, 0) - 1, -1):
                first, tables, known, reached = parts[at]
                if not (known & sources or reached & targets):
                    tables.append(table)
                    parts[at] = first, tables, known | sources, reached | targets
                    self._rows[number] = None
                    break
            else:
                parts.append((number, [table], sources, targets))
        for number, tables, _, _ in parts:
            if len(tables) > 1:
                self._put(number, level, tables)
        return len(numbers) - len(parts)

    def _put(self, number: int, level: int, tables: Sequence[int]) -> None:
        together = list(self._tables[tables[0]])
        for table in tables[1:]:
            for i, j in enumerate(self._tables[table]):
                if j >= 0:
                    together[i] = j
        row = self._rows[number]
        assert row is not None
        if len(row) > 1 and together == list(range(len(together))):
            del row[level]
        else:
            row[level] = self._numbered(tuple(together))

    def _numbered(self, table: Table) -> int:
        number = self._number.setdefault(table, len(self._tables))
        if number == len(self._tables):
            self._tables.append(table)
            self._sources.append(sum(1 << i for i, j in enumerate(table) if j >= 0))
            self._targets.append(sum(1 << j for j in table if j >= 0))
        return number
