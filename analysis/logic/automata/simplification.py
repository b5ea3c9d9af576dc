"""Smaller automata for the same language.

The following is repeated until nothing changes: states that cannot reach an accepting component are removed;
marks outside components and marks implied by another mark are removed; edges that a better edge makes
redundant are removed, and states that simulate each other are merged.

References
----------
P. Gastin, D. Oddoux, *Fast LTL to Buchi automata translation*, CAV 2001, LNCS 2102. K. Etessami, Th. Wilke,
R. A. Schuller, *Fair simulation relations, parity games, and state space reduction for Buchi automata*, SIAM
J. Comput. 34(5), 2005 (direct simulation).
"""

from __future__ import annotations

from dataclasses import replace

from dineros.analysis.logic.automata.automaton import Automaton, Edge

LARGEST_FOR_SIMULATION = 120
"""Maximum number of states for the (quadratic) simulation relation."""


def reduced(automaton: Automaton) -> Automaton:
    """Return an automaton for the same language with at most as many states, edges and marks."""
    while True:
        smaller = _without_implied_marks(_with_marks_in_components(_pruned(automaton)))
        smaller = _merged_by_successors(smaller)
        if len(smaller.edges) <= LARGEST_FOR_SIMULATION:
            smaller = _merged_by_simulation(smaller)
        if smaller == automaton:
            return automaton
        automaton = smaller


def _renumbered(automaton: Automaton, kept: list[int], target: dict[int, int]) -> Automaton:
    """Keep some states; edges lead to `target` of their target, or are removed if there is none."""
    position = {state: i for i, state in enumerate(kept)}
    rows = []
    for state in kept:
        edges = [
            edge._replace(target=position[target[edge.target]])
            for edge in automaton.edges[state]
            if edge.target in target
        ]
        rows.append(tuple(sorted(set(edges))))
    return replace(automaton, initial=position[target[automaton.initial]], edges=tuple(rows))


def _pruned(automaton: Automaton) -> Automaton:
    """Keep only states that are reachable and from which a word is accepted."""
    reachable, todo = {automaton.initial}, [automaton.initial]
    while todo:
        for edge in automaton.edges[todo.pop()]:
            if edge.target not in reachable:
                reachable.add(edge.target)
                todo.append(edge.target)
    useful: set[int] = set()
    for component in automaton.components():
        inside = set(component)
        edges = [edge for state in component for edge in automaton.edges[state]]
        marks, has_cycle = 0, False
        for edge in edges:
            if edge.target in inside:
                has_cycle = True
                marks |= edge.marks
        # Targets come before sources, so the results for the targets are known.
        if (has_cycle and marks == automaton.all_marks) or any(edge.target in useful for edge in edges):
            useful |= inside
    kept = sorted(useful & reachable | {automaton.initial})
    target = {state: state for state in kept if state in useful or state == automaton.initial}
    result = _renumbered(automaton, kept, target)
    if automaton.initial not in useful:
        return replace(result, marks=0, edges=((),))
    return result


def _with_marks_in_components(automaton: Automaton) -> Automaton:
    """Put all marks on edges between components, and none on edges in non-accepting components.

    No run takes an edge of the former kind infinitely often, and no run is accepted in a component of the
    latter kind, so the language does not change; edges and states that differed only in these marks become
    equal.
    """
    rows = [list(edges) for edges in automaton.edges]
    for component in automaton.components():
        inside = set(component)
        found = 0
        for state in component:
            for edge in rows[state]:
                found |= edge.marks if edge.target in inside else 0
        for state in component:
            rows[state] = [
                edge._replace(marks=automaton.all_marks)
                if edge.target not in inside
                else (edge if found == automaton.all_marks else edge._replace(marks=0))
                for edge in rows[state]
            ]
    return replace(automaton, edges=tuple(map(tuple, rows)))


def _without_implied_marks(automaton: Automaton) -> Automaton:
    """Remove a mark that is on every edge with some other mark."""
    sets = {edge.marks for edges in automaton.edges for edge in edges}
    kept = list(range(automaton.marks))
    for mark in range(automaton.marks):
        others = [other for other in kept if other != mark]
        if any(all(marks >> mark & 1 or not marks >> other & 1 for marks in sets) for other in others):
            kept = others
    if len(kept) == automaton.marks:
        return automaton

    def packed(marks: int) -> int:
        return sum((marks >> mark & 1) << i for i, mark in enumerate(kept))

    rows = tuple(
        tuple(edge._replace(marks=packed(edge.marks)) for edge in edges) for edges in automaton.edges
    )
    return replace(automaton, marks=len(kept), edges=rows)


def _merged_by_successors(automaton: Automaton) -> Automaton:
    """Merge states with equal edges, repeatedly.

    For a state on no cycle, the marks of its edges do not matter: it is merged with a state that differs only
    in marks.
    """
    while True:
        on_cycle = {
            state for component in automaton.components() if len(component) > 1 for state in component
        }
        on_cycle |= {s for s, edges in enumerate(automaton.edges) if any(edge.target == s for edge in edges)}
        first: dict[tuple[Edge, ...], int] = {}
        unmarked: dict[frozenset[Edge], int] = {}
        # States on cycles first, so that the others can be merged with them.
        for state in sorted(range(len(automaton.edges)), key=lambda s: (s not in on_cycle, s)):
            edges = automaton.edges[state]
            representative = first.setdefault(tuple(sorted(set(edges))), state)
            unmarked.setdefault(frozenset(edge._replace(marks=0) for edge in edges), representative)
        target = {}
        for state, edges in enumerate(automaton.edges):
            if state in on_cycle:
                target[state] = first[tuple(sorted(set(edges)))]
            else:
                target[state] = unmarked[frozenset(edge._replace(marks=0) for edge in edges)]
        smaller = _renumbered(automaton, sorted(set(target.values())), target)
        if smaller == automaton:
            return automaton
        automaton = smaller


def _merged_by_simulation(automaton: Automaton) -> Automaton:
    """Join states that simulate each other and drop edges that a better edge simulates."""
    size = len(automaton.edges)
    # simulates[p]: the states q that can answer every edge of p forever.
    simulates = [set(range(size)) for _ in range(size)]
    changed = True
    while changed:
        changed = False
        for p in range(size):
            for q in list(simulates[p]):
                if p != q and not all(
                    any(_better(edge, other, simulates) for other in automaton.edges[q])
                    for edge in automaton.edges[p]
                ):
                    simulates[p].discard(q)
                    changed = True
    target = {p: min(q for q in simulates[p] if p in simulates[q]) for p in range(size)}
    rows = []
    for edges in automaton.edges:
        kept = [
            edge
            for i, edge in enumerate(edges)
            if not any(
                _better(edge, other, simulates) and (j < i or not _better(other, edge, simulates))
                for j, other in enumerate(edges)
                if j != i
            )
        ]
        rows.append(tuple(kept))
    return _renumbered(replace(automaton, edges=tuple(rows)), sorted(set(target.values())), target)


def _better(edge: Edge, other: Edge, simulates: list[set[int]]) -> bool:
    """Whether `other` reads what `edge` reads, has its marks, and its target simulates that of `edge`."""
    return (
        other.positive & ~edge.positive == 0
        and other.negative & ~edge.negative == 0
        and edge.marks & ~other.marks == 0
        and other.target in simulates[edge.target]
    )
