"""CTL's sets of states as one flag per state of a stored graph, and paths that show why a formula is true."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from dineros.analysis.logic.ctl.state_sets import Run
from dineros.analysis.logic.graphs.stored import StateGraph, StateSet
from dineros.analysis.logic.language.syntax import Atom, Exists, Formula, Globally, Next, Until
from dineros.analysis.logic.verdicts.verdict import ReplayError, replayed
from dineros.analysis.nets.graph_parts import numbered_parts


class ExplicitSets:
    """The `StateSets` of a stored graph.

    Parameters
    ----------
    graph : StateGraph
        Explored.
    """

    def __init__(self, graph: StateGraph) -> None:
        self.graph = graph

    def constant(self, value: bool) -> StateSet:
        """Return all states or none."""
        return np.full(self.graph.size, value)

    def atom(self, atom: Atom) -> StateSet:
        """Return the states in which an atom is true."""
        return self.graph.where(atom)

    def complement(self, states: StateSet) -> StateSet:
        """Return the other states."""
        return ~states

    def intersection(self, left: StateSet, right: StateSet) -> StateSet:
        """Return the states in both sets."""
        return left & right

    def union(self, left: StateSet, right: StateSet) -> StateSet:
        """Return the states in one of the sets."""
        return left | right

    def some_next(self, states: StateSet) -> StateSet:
        """EX: return the states with a successor in a set."""
        return self.graph.arcs.some_next(states)

    def some_until(self, stay: StateSet, goal: StateSet) -> StateSet:
        """EU: return the states from which some run stays in one set until it is in the other."""
        return self.graph.arcs.some_until(stay, goal)

    def some_globally(self, states: StateSet) -> StateSet:
        """EG: return the states from which some run never leaves a set."""
        return self.graph.arcs.some_globally(states)

    def initially(self, states: StateSet) -> bool:
        """Whether the initial state is in a set."""
        return bool(states[0])

    def path(self, path: Formula, found: Mapping[Formula, StateSet]) -> Run:
        """Return a replayed run from the initial state that shows a basic path formula; a shortest path."""
        graph = self.graph
        states, back = _states_of_run(graph, path, found)
        stem = graph.transitions(states if back is None else states[: back + 1])
        loop = () if back is None else graph.transitions([*states[back:], states[back]])
        _check(graph, stem, loop, states if back is None else states[: back + 1])
        return stem, loop


def _states_of_run(
    graph: StateGraph, path: Formula, found: Mapping[Formula, StateSet]
) -> tuple[list[int], int | None]:
    """Return the states of a path, and where its last state goes back to, if it is a lasso."""
    none = np.zeros(graph.size, dtype=np.bool_)
    match path:
        case Next(operand):
            return graph.path(0, none, found[operand]), None
        case Until(left, right):
            if found[right][0]:
                return [0], None
            return graph.path(0, found[left], found[right]), None
        case Globally(operand):
            lasting = found[Exists(path)]
            assert lasting[0] and found[operand][0]
            on_cycle = _on_cycles(graph, lasting)
            states = [0] if on_cycle[0] else graph.path(0, lasting, on_cycle)
            home = none.copy()
            home[states[-1]] = True
            return [*states, *graph.path(states[-1], lasting, home)[1:-1]], len(states) - 1
    raise TypeError(f"no basic path formula: {path}")


def _on_cycles(graph: StateGraph, states: StateSet) -> StateSet:
    """Return the states of a set that lie on a cycle within it."""
    sources, targets = graph.arcs.tails(), graph.arcs.targets
    inside = states[sources] & states[targets]
    sources, targets = sources[inside], targets[inside]
    _, component = numbered_parts(graph.size, sources, targets)
    result = np.zeros(graph.size, dtype=np.bool_)
    result[sources[component[sources] == component[targets]]] = True
    return result


def _check(graph: StateGraph, stem: tuple[int, ...], loop: tuple[int, ...], states: list[int]) -> None:
    """Replay a witness by the plain firing rule."""
    first, again = replayed(graph.net, stem, loop, must_loop=False)
    markings = [step.marking for step in first] + [again[0].marking]
    if markings[-1] != graph.product.marking(states[-1]):
        raise ReplayError("a witness ends in another marking than it should")
