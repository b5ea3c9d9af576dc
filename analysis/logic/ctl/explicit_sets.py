"""CTL's sets of states as one flag per state of a stored graph, and paths that show why a formula is true."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping

import numpy as np

from dineros.analysis.logic.ctl.state_sets import Run
from dineros.analysis.logic.graphs.stored import Arcs, StateGraph, StateSet
from dineros.analysis.logic.language.syntax import Atom, Exists, Formula, Globally, Next, Until
from dineros.analysis.logic.verdicts.verdict import ReplayError, replayed
from dineros.analysis.nets.graph_parts import numbered_parts


class FlaggedSets(ABC):
    """The `StateSets` of numbered states; atoms and runs depend on the graph.

    Parameters
    ----------
    arcs : Arcs
        Each state has a successor. State 0 is the initial one.
    """

    def __init__(self, arcs: Arcs) -> None:
        self.arcs = arcs

    @abstractmethod
    def atom(self, atom: Atom) -> StateSet:
        """Return the states in which an atom is true."""

    @abstractmethod
    def path(self, path: Formula, found: Mapping[Formula, StateSet]) -> Run:
        """Return a replayed run from the initial state that shows a basic path formula; a shortest path."""

    def constant(self, value: bool) -> StateSet:
        """Return all states or none."""
        return np.full(self.arcs.pointer.size - 1, value)

    def complement(self, states: StateSet) -> StateSet:
        """Return the other states."""
        return ~states

    def intersection(self, left: StateSet, right: StateSet) -> StateSet:
        """Return the states in both sets."""
        return left & right

    def union(self, left: StateSet, right: StateSet) -> StateSet:
        """Return the states in at least one of the sets."""
        return left | right

    def some_next(self, states: StateSet) -> StateSet:
        """EX: return the states with a successor in a set."""
        return self.arcs.some_next(states)

    def some_until(self, stay: StateSet, goal: StateSet) -> StateSet:
        """EU: return the states from which some run stays in one set until it is in the other."""
        return self.arcs.some_until(stay, goal)

    def some_globally(self, states: StateSet) -> StateSet:
        """EG: return the states from which some run never leaves a set."""
        return self.arcs.some_globally(states)

    def initially(self, states: StateSet) -> bool:
        """Whether the initial state is in a set."""
        return bool(states[0])


class ExplicitSets(FlaggedSets):
    """The `StateSets` of a stored graph."""

    def __init__(self, graph: StateGraph) -> None:
        super().__init__(graph.arcs)
        self.graph = graph

    def atom(self, atom: Atom) -> StateSet:
        """Return the states in which an atom is true."""
        return self.graph.where(atom)

    def path(self, path: Formula, found: Mapping[Formula, StateSet]) -> Run:
        """Return a replayed run from the initial state that shows a basic path formula; a shortest path."""
        graph = self.graph
        states, back = states_of_run(graph.arcs, path, found)
        stem = graph.transitions(states if back is None else states[: back + 1])
        loop = () if back is None else graph.transitions([*states[back:], states[back]])
        _check(graph, stem, loop, states if back is None else states[: back + 1])
        return stem, loop


def states_of_run(
    arcs: Arcs, path: Formula, found: Mapping[Formula, StateSet]
) -> tuple[list[int], int | None]:
    """Return the states of a run from state 0 that shows a basic path formula, which some run must satisfy.

    For a lasso, also return the position to which its last state returns.
    """
    none = np.zeros(arcs.pointer.size - 1, dtype=np.bool_)
    match path:
        case Next(operand):
            return arcs.path(0, none, found[operand]), None
        case Until(left, right):
            if found[right][0]:
                return [0], None
            return arcs.path(0, found[left], found[right]), None
        case Globally(operand):
            lasting = found[Exists(path)]
            assert lasting[0] and found[operand][0]
            on_cycle = _on_cycles(arcs, lasting)
            states = [0] if on_cycle[0] else arcs.path(0, lasting, on_cycle)
            home = none.copy()
            home[states[-1]] = True
            return [*states, *arcs.path(states[-1], lasting, home)[1:-1]], len(states) - 1
    raise TypeError(f"no basic path formula: {path}")


def _on_cycles(arcs: Arcs, states: StateSet) -> StateSet:
    """Return the states of a set that lie on a cycle within it."""
    sources, targets = arcs.tails(), arcs.targets
    inside = states[sources] & states[targets]
    sources, targets = sources[inside], targets[inside]
    _, component = numbered_parts(states.size, sources, targets)
    result = np.zeros_like(states)
    result[sources[component[sources] == component[targets]]] = True
    return result


def _check(graph: StateGraph, stem: tuple[int, ...], loop: tuple[int, ...], states: list[int]) -> None:
    """Replay a witness by the plain firing rule."""
    first, again = replayed(graph.net, stem, loop, must_loop=False)
    markings = [step.marking for step in first] + [again[0].marking]
    if markings[-1] != graph.product.marking(states[-1]):
        raise ReplayError("a witness ends in another marking than it should")
