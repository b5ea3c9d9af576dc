"""Local states that only an unguarded move reaches, contracted with the local state before them.

A process often takes steps that no other process can observe or prevent. Let b be a local state that is not
initial. If each event that moves the level to b comes from the local state a and changes no other level, if
one of these events touches no other level, and if each event that b allows to stay is also allowed by a, then
b is reachable together with exactly those local states of the other levels with which a is: the unguarded
event leads from a to b, and the latest move to b can be delayed for as long as b stays. So a and b can be one
local state of a smaller encoding, and so can all local states that follow each other in this way. The diagram
of the given encoding has the same nodes, with equal children for contracted local states.

References
----------
B. Berthomieu, D. Le Botlan, S. Dal Zilio, *Petri net reductions for counting markings*, SPIN 2018, LNCS
10869: places in a chain are one place whose tokens may be distributed in every way. Here it is done on local
states, and undone once the diagram is made.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from dineros.analysis.symbolic.counting import DiagramCounts
from dineros.analysis.symbolic.kernels import diagrams as store
from dineros.analysis.symbolic.kernels.contraction import expand_nodes
from dineros.analysis.symbolic.levels import Encoding, Level, LocalEvent, changes
from dineros.analysis.symbolic.saturation import Diagram, DiagramMemoryError

#: Events that one event may become, as its local states may lead from one contracted state to several.
MOST_PARTS = 16
#: Smallest hash table of an expanded diagram.
FEWEST_BUCKETS = 1 << 10

Table = tuple[int, ...]


@dataclass(frozen=True)
class Contraction:
    """A smaller encoding, and the contracted local state of each local state.

    Attributes
    ----------
    whole, encoding : Encoding
        The given encoding, and the smaller one.
    of_state : tuple of tuple of int
        By level and local state of the given encoding: the local state of the smaller one.
    """

    whole: Encoding
    encoding: Encoding
    of_state: tuple[Table, ...]

    def weights(self) -> list[list[int]]:
        """Return by level how many local states each contracted one stands for."""
        return [
            np.bincount(states, minlength=len(level.states)).tolist()
            for states, level in zip(self.of_state, self.encoding.levels, strict=True)
        ]

    def expanded(self, diagram: Diagram) -> Diagram:
        """Return the diagram of the given encoding from a complete one of the smaller encoding.

        Raises
        ------
        DiagramMemoryError
            If memory runs out.
        """
        counts = DiagramCounts(diagram)
        buckets = max(FEWEST_BUCKETS, 1 << counts.nodes.bit_length())
        whole = Diagram(self.whole, diagram.order, diagram.memory, first_buckets=buckets)
        of_state = np.array([0, *(i for k in diagram.order for i in self.of_state[k])], dtype=np.int64)
        made = np.zeros(counts.nodes + 1, dtype=np.int32)
        is_done = expand_nodes(
            counts.level_of, counts.start, counts.first, counts.child, of_state, whole.mem, whole.heads,
            whole.control, whole.free, whole.base, whole.scratch, made,
        )  # fmt: skip
        if not is_done:
            raise DiagramMemoryError("memory ran out")
        whole.peak_nodes = max(diagram.peak_nodes, whole.nodes)
        whole.finish(int(made[counts.root]))
        whole.control[store.MISSES], whole.collections = diagram.effort, diagram.collections
        return whole


def contracted(encoding: Encoding) -> Contraction | None:
    """Contract the local states of an encoding; None if there are none to contract.

    Examples
    --------
    >>> from dineros.analysis.nets.compiled import CompiledNet
    >>> from dineros.analysis.symbolic.levels import encode
    >>> net = CompiledNet.build({"a": 1, "b": 0, "c": 0},
    ...     [("t", {"a": 1}, {"b": 1}), ("u", {"b": 1}, {"c": 1}), ("v", {"c": 1}, {"a": 1})])
    >>> contracted(encode(net)).of_state
    ((0, 1, 1, 1),)
    """
    of_state = [
        _contracted_states(level, moves, idle)
        for level, (moves, idle) in zip(encoding.levels, _moves(encoding), strict=True)
    ]
    if all(len(set(states)) == len(states) for states in of_state):
        return None
    levels = []
    for level, states in zip(encoding.levels, of_state, strict=True):
        first = {state: i for i, state in reversed(list(enumerate(states)))}
        kept = tuple(level.states[first[state]] for state in range(len(first)))
        levels.append(Level(level.places, kept, states[level.initial]))
    parts_of: dict[tuple[int, Table], list[Table]] = {}
    events: list[LocalEvent] = []
    for event in encoding.events:
        for step in event.tables.items():
            if step not in parts_of:
                parts_of[step] = _parts(step[1], of_state[step[0]])
        parts = [parts_of[step] for step in event.tables.items()]
        if np.prod([len(tables) for tables in parts], dtype=np.float64) > MOST_PARTS:
            return None
        events += (
            LocalEvent(event.transition, dict(zip(event.tables, tables, strict=True)))
            for tables in product(*parts)
        )
    smaller = replace(encoding, levels=tuple(levels), events=tuple(events))
    return Contraction(encoding, smaller, tuple(of_state))


@dataclass
class _Moves:
    """How events move one level.

    Attributes
    ----------
    sources : dict of set of int
        By target: the local states from which some event leads there.
    observed : set of int
        Targets of events that change another level, too.
    unguarded : set of (int, int)
        Moves of events that touch no other level.
    """

    sources: defaultdict[int, set[int]]
    observed: set[int]
    unguarded: set[tuple[int, int]]


def _moves(encoding: Encoding) -> list[tuple[_Moves, set[Table]]]:
    """Return by level its moves, and the tables of its events."""
    found = [(_Moves(defaultdict(set), set(), set()), set[Table]()) for _ in encoding.levels]
    for event in encoding.events:
        changed = {k for k, table in event.tables.items() if changes(table)}
        for k, table in event.tables.items():
            moves, tables = found[k]
            tables.add(table)
            if k not in changed:
                continue
            for i, j in enumerate(table):
                if j not in (-1, i):
                    moves.sources[j].add(i)
                    if len(changed) > 1:
                        moves.observed.add(j)
                    if len(event.tables) == 1:
                        moves.unguarded.add((i, j))
    return found


def _contracted_states(level: Level, moves: _Moves, tables: Iterable[Table]) -> Table:
    """Return by local state the number of its contracted one."""
    before: dict[int, int] = {}
    for state, sources in moves.sources.items():
        if state != level.initial and len(sources) == 1 and state not in moves.observed:
            (source,) = sources
            if (source, state) in moves.unguarded:
                before[state] = source
    for table in tables if before else ():
        for state in [state for state in before if table[state] == state]:
            if table[before[state]] != before[state]:
                del before[state]
    roots: dict[int, int] = {}
    return tuple(roots.setdefault(_root(state, before), len(roots)) for state in range(len(level.states)))


def _root(state: int, before: dict[int, int]) -> int:
    """Return the first local state of a chain; of a loop, which is never reached, the smallest."""
    chain = [state]
    while (state := before.get(state, -1)) >= 0:
        if state in chain:
            return min(chain[chain.index(state) :])
        chain.append(state)
    return chain[-1]


def _parts(table: Table, of_state: Sequence[int]) -> list[Table]:
    """Return a table over contracted local states; it is split if it is not an injective function."""
    size = max(of_state) + 1
    parts: list[list[int]] = []
    for i, j in enumerate(table):
        if j < 0:
            continue
        source, target = of_state[i], of_state[j]
        for part in parts:
            if part[source] == target or (part[source] < 0 and target not in part):
                part[source] = target
                break
        else:
            parts.append([-1] * size)
            parts[-1][source] = target
    return [tuple(part) for part in parts]
