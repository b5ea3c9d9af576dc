"""Levels of one component joined to one level: a process, its program counter and its own variables.

A level is *owned* by another one if every event that changes it touches the other one, too: a process tests
or moves its program counter whenever it writes a variable of its own. A level and its owner, the owner of the
owner, and so on, are a component. A variable that several processes write has no owner, and stays alone.

Clients that share counters of free room own nothing without them: an event takes a request of a client, and
does not touch the client itself. There, the levels that the most events touch are taken out; levels that
events connect without them are a component.

The local states of a component are those that its events reach if all other levels allow all that they are
asked. They are far fewer than the product of the local states of its levels.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from dineros.analysis.nets.graph_parts import representatives
from dineros.analysis.symbolic.levels import Encoding, Level, LocalEvent, changes

#: Local states that a component may have: the work of a node grows with them.
MOST_STATES = 512
#: Numbers of events above which levels are taken out, at most: a client, a server and shared counters differ.
MOST_CUTS = 8

Vector = tuple[int, ...]
#: Part of an event on a component: (position of a level in the component, table).
Part = tuple[tuple[int, tuple[int, ...]], ...]


@dataclass(frozen=True)
class Joined:
    """An encoding with a level for each component.

    Attributes
    ----------
    components : tuple of int
        Its levels that several levels were joined to.
    """

    encoding: Encoding
    components: tuple[int, ...]


def joined(encoding: Encoding, groups: Sequence[Sequence[int]]) -> Joined | None:
    """Return the encoding with groups of levels joined; None if one of them has too many local states."""
    at = {level: (number, i) for number, group in enumerate(groups) for i, level in enumerate(group)}
    parts: list[dict[int, Part]] = []
    for event in encoding.events:
        by_group: defaultdict[int, list[tuple[int, tuple[int, ...]]]] = defaultdict(list)
        for level, table in sorted(event.tables.items()):
            number, i = at[level]
            by_group[number].append((i, table))
        parts.append({number: tuple(part) for number, part in by_group.items()})
    asked: list[set[Part]] = [set() for _ in groups]
    for event_parts in parts:
        for number, part in event_parts.items():
            asked[number].add(part)
    made: list[tuple[dict[Vector, int], Vector]] = []
    for group, moves in zip(groups, asked, strict=True):
        initial = tuple(encoding.levels[level].initial for level in group)
        vectors: dict[Vector, int] = {(i,): i for i in range(len(encoding.levels[group[0]].states))}
        if len(group) > 1:
            reached = _reached(initial, sorted(moves))
            if reached is None:
                return None
            vectors = {vector: i for i, vector in enumerate(reached)}
        made.append((vectors, initial))
    levels = tuple(
        Level(
            tuple(place for level in group for place in encoding.levels[level].places),
            tuple(
                tuple(
                    tokens
                    for level, i in zip(group, vector, strict=True)
                    for tokens in encoding.levels[level].states[i]
                )
                for vector in vectors
            ),
            vectors[initial],
        )
        for group, (vectors, initial) in zip(groups, made, strict=True)
    )
    tables = [
        {part: _table(part, vectors) for part in moves}
        for moves, (vectors, _) in zip(asked, made, strict=True)
    ]
    events = []
    for event, event_parts in zip(encoding.events, parts, strict=True):
        own = {number: tables[number][part] for number, part in event_parts.items()}
        if all(max(table) >= 0 for table in own.values()):
            events.append(LocalEvent(event.transition, own))
    flows = (tuple(sorted({at[level][0] for level in flow})) for flow in encoding.flows)
    return Joined(
        Encoding(
            encoding.boxes, levels, tuple(events), encoding.bounds, tuple(f for f in flows if len(f) > 1)
        ),
        tuple(number for number, group in enumerate(groups) if len(group) > 1),
    )


def components(encoding: Encoding) -> list[tuple[int, ...]]:
    """Return groups of levels: those of each component, and each other level alone.

    Of several owners, that which the most events touch counts.
    """
    touching = [0] * len(encoding.levels)
    owners: dict[int, set[int]] = {}
    for event in encoding.events:
        for level in event.tables:
            touching[level] += 1
        for level, table in event.tables.items():
            if changes(table):
                owners.setdefault(level, set(event.tables)).intersection_update(event.tables)
    pairs = [
        (level, max(others, key=lambda other: (touching[other], -other)))
        for level, found in sorted(owners.items())
        if (others := found - {level})
    ]
    return _connected(len(encoding.levels), pairs)


def components_without_shared(encoding: Encoding, fewest: int) -> list[tuple[int, ...]] | None:
    """Return groups of levels: those that events connect if the levels that most events touch are taken out.

    As few levels as possible are taken out, so that at least some number of groups have several levels. The
    answer is None if that does not succeed.
    """
    events = [sorted(event.tables) for event in encoding.events]
    touching = [0] * len(encoding.levels)
    for levels in events:
        for level in levels:
            touching[level] += 1
    for most in sorted(set(touching), reverse=True)[1 : MOST_CUTS + 1]:
        left = ([level for level in levels if touching[level] <= most] for levels in events)
        pairs = sorted({pair for levels in left for pair in pairwise(levels)})
        groups = _connected(len(encoding.levels), pairs)
        if sum(len(group) > 1 for group in groups) >= fewest:
            return groups
    return None


def _connected(size: int, pairs: Iterable[tuple[int, int]]) -> list[tuple[int, ...]]:
    """Return the groups of levels that pairs connect."""
    groups: defaultdict[int, list[int]] = defaultdict(list)
    for level, first in representatives(range(size), pairs).items():
        groups[first].append(level)
    return sorted(map(tuple, groups.values()))


def _reached(initial: Vector, moves: Sequence[Part]) -> list[Vector] | None:
    """Return the local states that moves reach; None if there are too many."""
    found = {initial: None}
    pending = [initial]
    while pending:
        vector = pending.pop()
        for part in moves:
            moved = _moved(vector, part)
            if moved is not None and moved not in found:
                if len(found) == MOST_STATES:
                    return None
                found[moved] = None
                pending.append(moved)
    return list(found)


def _moved(vector: Vector, part: Part) -> Vector | None:
    moved = list(vector)
    for i, table in part:
        j = table[vector[i]]
        if j < 0:
            return None
        moved[i] = j
    return tuple(moved)


def _table(part: Part, vectors: Mapping[Vector, int]) -> tuple[int, ...]:
    table = []
    for vector in vectors:
        moved = _moved(vector, part)
        table.append(-1 if moved is None else vectors[moved])
    return tuple(table)
