"""CTL on time Petri nets by its definition, on clock regions: plain and slow, independent of the product.

A state is a region right after a firing, or the initial one. Its next states are those after the next firing,
after any time; where nothing that is enabled has a latest bound, a run may also stay where it is.
"""

from __future__ import annotations

from collections.abc import Callable

from dineros.analysis.logic.language.syntax import (
    And,
    Atom,
    Constant,
    Deadlock,
    Equivalent,
    Exists,
    Finally,
    ForAll,
    Formula,
    Globally,
    Implies,
    Next,
    Not,
    Or,
    Release,
    Until,
    WeakUntil,
)
from tests.support.references.regions import Marking, RegionGraph, State


class FiringGraph:
    """The regions right after a firing, and what follows them."""

    def __init__(self, regions: RegionGraph) -> None:
        self.start = regions.start
        self.after: dict[State, set[State]] = {}
        self.dead: set[State] = set()
        todo = [regions.start]
        while todo:
            state = todo.pop()
            if state in self.after:
                continue
            found: set[State] = set()
            later: State | None = state
            seen: set[State] = set()
            while later is not None and later not in seen:
                seen.add(later)
                found |= {after for _, after in regions.fires[later]}
                later = regions.waits.get(later)
            todo += found
            if not found:
                self.dead.add(state)
            if all(regions.transitions[t].latest is None for t, _, _ in state[1]):
                found = found | {state}
            self.after[state] = found

    def holds(self, formula: Formula, is_true: Callable[[Atom, Marking], bool]) -> bool:
        """Whether a formula holds in the initial state."""
        return self.start in self._where(formula, is_true)

    def _where(self, formula: Formula, is_true: Callable[[Atom, Marking], bool]) -> set[State]:
        every = set(self.after)
        match formula:
            case Constant(value):
                return every if value else set()
            case Deadlock():
                return set(self.dead)
            case Atom():
                return {state for state in every if is_true(formula, state[0])}
            case Exists(path) | ForAll(path):
                parts = [self._where(part, is_true) for part in path.operands]
                return self._path(type(path), parts, isinstance(formula, Exists))
        parts = [self._where(part, is_true) for part in formula.operands]
        match formula:
            case Not():
                return every - parts[0]
            case And():
                return set.intersection(*parts)
            case Or():
                return set.union(*parts)
            case Implies():
                return (every - parts[0]) | parts[1]
            case Equivalent():
                return {state for state in every if (state in parts[0]) == (state in parts[1])}
        raise TypeError(str(formula))

    def _path(self, kind: type[Formula], parts: list[set[State]], is_some: bool) -> set[State]:
        every, quantified = set(self.after), any if is_some else all

        def before(states: set[State]) -> set[State]:
            return {state for state in every if quantified(after in states for after in self.after[state])}

        def least(stay: set[State], goal: set[State]) -> set[State]:
            found: set[State] = set(goal)
            while (more := found | (stay & before(found))) != found:
                found = more
            return found

        def greatest(stay: set[State], release: set[State]) -> set[State]:
            found = set(stay)
            while (fewer := stay & (release | before(found))) != found:
                found = fewer
            return found

        if kind is Next:
            return before(parts[0])
        if kind is Finally:
            return least(every, parts[0])
        if kind is Globally:
            return greatest(parts[0], set())
        if kind is Until:
            return least(parts[0], parts[1])
        if kind is Release:
            return greatest(parts[1], parts[0])
        assert kind is WeakUntil
        return greatest(parts[0] | parts[1], parts[1])
