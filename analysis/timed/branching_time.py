"""CTL on nets with time, decided on atomic classes.

A state of a run is a marking right after a firing, or the initial one, with its clocks. The next state is the
one after the next firing, however long that takes. A run may also stay in a state forever where nothing has
to fire: in a deadlock, and where nothing that is enabled has a latest bound; then the state is its own next
state, too. While time passes between two firings, no formula is asked.

References
----------
B. Berthomieu, F. Vernadat, *State class constructions for branching analysis of time Petri nets*, TACAS
2003, LNCS 2619 (atomic classes keep what CTL* says of these runs).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np

from dineros.analysis.answers.budget import RAN_OUT, UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.ctl.checking import decided
from dineros.analysis.logic.ctl.explicit_sets import FlaggedSets, states_of_run
from dineros.analysis.logic.ctl.state_sets import Run
from dineros.analysis.logic.graphs.stored import Arcs, StateSet
from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.names import Names, NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.syntax import Atom, Exists, Finally, ForAll, Formula, Globally, Not
from dineros.analysis.logic.verdicts.verdict import ReplayError
from dineros.analysis.nets.witness import WitnessError
from dineros.analysis.timed.goals import find_timed
from dineros.analysis.timed.graph import WAITING, TimedGraph, timed_graph
from dineros.analysis.timed.linear_time import is_condition
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.schedules import schedule

BY = "state classes"


def check_timed_ctl(
    net: TimedNet, formula: str | Formula, names: Names | None = None, budget: Budget = UNLIMITED
) -> Outcome:
    """Decide whether the initial state of a net with its times satisfies a CTL formula.

    Parameters
    ----------
    net
        The net; it may have priorities.
    formula
        ``enabled(t)`` says that the tokens are there, ``deadlock`` that nothing can fire any more, however
        long one waits. What *next* means is defined above.
    names
        What names stand for; by default places and transitions of the net.

    Returns
    -------
    Outcome
        ``holds`` or ``violated``; where a single run shows it, with that run, which has a schedule.

    Raises
    ------
    FormulaError
        The formula is not in CTL, or has an unknown name.
    """
    names = names or NetNames(net.untimed)
    budget = budget.begun()
    tree = parse(formula, "ctl") if isinstance(formula, str) else formula
    atoms = BoundAtoms(net.untimed, tree, names)
    match tree:
        case ForAll(Globally(condition)) if is_condition(condition):
            return _by_markings(net, Not(condition), names, budget, ("violated", "holds"))
        case Exists(Finally(condition)) if is_condition(condition):
            return _by_markings(net, condition, names, budget, ("holds", "violated"))
    classes = 0
    try:
        graph = timed_graph(net, "A", budget)
        classes = graph.classes
        budget.stage("sets of classes")
        return replace(decided(tree, _TimedSets(graph, atoms), classes, budget), by=BY)
    except BudgetExceededError as limit:
        reason = RAN_OUT.get(str(limit), str(limit))
        return Outcome("unknown", states=classes, seconds=budget.spent, reason=reason)


def _by_markings(
    net: TimedNet, condition: Formula, names: Names, budget: Budget, statuses: tuple[str, str]
) -> Outcome:
    """Decide whether a marking is reached: the largest classes are enough for that."""
    found = find_timed(net, condition, names, budget)
    if found.status == "unknown":
        return found
    is_met, is_never_met = statuses
    if found.status == "unreachable":
        return replace(found, status=is_never_met)
    return replace(found, status=is_met, reason=f"shows {Exists(Finally(condition))}")


class _TimedSets(FlaggedSets):
    """The `StateSets` of atomic classes: all states of a class satisfy the same formulas."""

    def __init__(self, graph: TimedGraph, atoms: BoundAtoms) -> None:
        leaving = np.bincount(graph.source, minlength=graph.classes)
        pointer = np.concatenate([[0], np.cumsum(leaving)]).astype(np.int64)
        super().__init__(Arcs.of(pointer, graph.target.astype(np.int32)))
        self._graph, self._atoms = graph, atoms

    def atom(self, atom: Atom) -> StateSet:
        """Return the classes in which an atom is true."""
        return self._graph.where(self._atoms.conditions[atom])

    def path(self, path: Formula, found: Mapping[Formula, StateSet]) -> Run:
        """Return a run that shows a basic path formula, and find its schedule."""
        states, back = states_of_run(self.arcs, path, found)
        stem = self._labels(states if back is None else states[: back + 1])
        loop = () if back is None else self._labels([*states[back:], states[back]])
        try:
            schedule(self._graph.net, [*stem, *loop])
        except WitnessError as error:
            raise ReplayError(str(error)) from error
        return stem, loop

    def _labels(self, states: list[int]) -> tuple[int, ...]:
        """Return the transitions of a path; waiting forever has no transition."""
        found = []
        for source, target in pairwise(states):
            edges = np.arange(self.arcs.pointer[source], self.arcs.pointer[source + 1])
            labels = self._graph.label[edges[self._graph.target[edges] == target]]
            if WAITING not in labels:
                found.append(int(labels[0]))
        return tuple(found)
