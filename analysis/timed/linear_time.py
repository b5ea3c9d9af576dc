"""LTL on nets with time: every run satisfies a formula, or here is one that does not, with its schedule.

Runs are those of the state class graph: infinite firing sequences that some schedule has, and runs that stay
in a marking forever, because nothing has to fire there; such a run never fires again. A run in which
infinitely many firings take no time is a run like others.

References
----------
B. Berthomieu, F. Vernadat, *State class constructions for branching analysis of time Petri nets*, TACAS
2003, LNCS 2619 (linear classes keep markings and firing sequences).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from dineros.analysis.answers.budget import RAN_OUT, UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.automata.automaton import Automaton
from dineros.analysis.logic.automata.translation import translate
from dineros.analysis.logic.graphs.predicates import Flags
from dineros.analysis.logic.language.atoms import BoundAtoms, SomeFired, Step
from dineros.analysis.logic.language.names import Names, NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.rewriting import negated
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.logic.language.syntax import (
    TEMPORAL,
    Atom,
    Deadlock,
    Exists,
    Fired,
    ForAll,
    Formula,
    Globally,
    Not,
)
from dineros.analysis.logic.verdicts.verdict import ReplayError
from dineros.analysis.nets.compiled import Int64Array
from dineros.analysis.nets.graph_parts import numbered_parts
from dineros.analysis.timed.classes import Kind
from dineros.analysis.timed.goals import find_timed
from dineros.analysis.timed.graph import WAITING, EdgePaths, TimedGraph, timed_graph
from dineros.analysis.timed.nets import TimedNet

MOST_ATOMS = 62
"""Letters are bits of one word."""


def verify_timed_ltl(
    net: TimedNet,
    formula: str | Formula,
    names: Names | None = None,
    budget: Budget = UNLIMITED,
    kind: Kind | None = None,
) -> Outcome:
    """Decide whether all runs of a net with its times satisfy an LTL formula.

    Parameters
    ----------
    net
        The net; with priorities, strong classes are built, else linear ones.
    formula
        ``enabled(t)`` says that the tokens are there, ``fired(t)`` that the next step is this transition,
        ``deadlock`` that nothing can fire any more.
    names
        What names stand for; by default places and transitions of the net.
    kind
        Which state classes; by default linear ones if there are no priorities.

    Returns
    -------
    Outcome
        ``violated`` comes with a run that has a schedule and on which the formula is false by definition.

    Raises
    ------
    FormulaError
        The formula is invalid, names something unknown, or is too large.
    """
    names = names or NetNames(net.untimed)
    budget = budget.begun()
    tree = parse(formula) if isinstance(formula, str) else formula
    atoms = BoundAtoms(net.untimed, tree, names)
    if isinstance(tree, Globally) and is_condition(tree.operand):
        return _never(net, tree.operand, names, budget)
    budget.stage("the automaton of the formula")
    automaton = translate(negated(tree))
    classes: int | None = None
    try:
        if len(automaton.atoms) > MOST_ATOMS:
            raise BudgetExceededError(f"the formula has more than {MOST_ATOMS} atoms")
        graph = timed_graph(net, kind or ("S" if net.has_priorities else "W"), budget)
        classes = graph.classes
        budget.stage("the product with the automaton")
        run = _Product(graph, automaton, atoms, budget).accepted()
    except BudgetExceededError as limit:
        reason = RAN_OUT.get(str(limit), str(limit))
        return Outcome("unknown", states=classes, seconds=budget.spent, reason=reason)
    if run is None:
        return Outcome("holds", states=classes, seconds=budget.spent, by="state classes")
    _check(graph, tree, atoms, run)
    stem, loop = _transitions(run.stem), _transitions(run.loop)
    return Outcome("violated", stem, loop, classes, budget.spent, by="state classes")


def is_condition(tree: Formula) -> bool:
    """Whether a formula is about one marking only."""
    return not any(isinstance(part, (*TEMPORAL, ForAll, Exists, Fired)) for part in tree.subformulas())


def _never(net: TimedNet, condition: Formula, names: Names, budget: Budget) -> Outcome:
    """Decide ``G condition`` by the markings: the largest classes are enough for those."""
    found = find_timed(net, Not(condition), names, budget)
    if found.status == "unknown":
        return found
    if found.status == "unreachable":
        return replace(found, status="holds")
    return replace(found, status="violated", reason="shown up to the marking that violates it")


@dataclass(frozen=True)
class _LassoRun:
    """Edges of the graph: those of the stem, and those of the loop."""

    graph: TimedGraph
    stem_edges: tuple[int, ...]
    loop_edges: tuple[int, ...]

    @property
    def stem(self) -> list[int]:
        return [int(self.graph.label[edge]) for edge in self.stem_edges]

    @property
    def loop(self) -> list[int]:
        return [int(self.graph.label[edge]) for edge in self.loop_edges]


def _transitions(labels: Sequence[int]) -> tuple[int, ...]:
    return tuple(label for label in labels if label != WAITING)


class _Product:
    """The product of a graph and an automaton: states are class * states + state of the automaton.

    A run that waits forever never fires again. So waiting leads to a copy of the class, which is never left:
    else *next*, and ``fired(t)``, could tell a run that waits for a while from one that does not.
    """

    def __init__(self, graph: TimedGraph, automaton: Automaton, atoms: BoundAtoms, budget: Budget) -> None:
        self._graph, self._automaton, self._budget = graph, automaton, budget
        self._states = len(automaton.edges)
        letters = np.zeros(len(graph.source), dtype=np.int64)
        for bit, atom in enumerate(automaton.atoms):
            condition = atoms.conditions[atom]
            if isinstance(condition, SomeFired):
                held = graph.fired(condition)
            else:
                held = graph.where(condition)[graph.source]
            letters |= held.astype(np.int64) << bit
        waiting = np.flatnonzero(graph.label == WAITING)
        copies = graph.classes + np.arange(len(waiting))
        target = graph.target.copy()
        target[waiting] = copies
        self._classes = graph.classes + len(waiting)
        self._original = np.concatenate([np.arange(len(graph.source)), waiting])
        self._join(
            np.concatenate([graph.source, copies]),
            np.concatenate([target, copies]),
            letters[self._original],
        )

    def _join(self, source: Int64Array, target: Int64Array, letters: Int64Array) -> None:
        """Make the edges of the product."""
        states = self._states
        parts: list[tuple[Int64Array, Int64Array, Int64Array, Int64Array]] = []
        total = 0
        for state, edges in enumerate(self._automaton.edges):
            for edge in edges:
                reads = (letters & edge.positive == edge.positive) & (letters & edge.negative == 0)
                chosen = np.flatnonzero(reads)
                total += len(chosen)
                self._budget.check_memory(4 * 8 * total)
                self._budget.check_time()
                parts.append(
                    (
                        source[chosen] * states + state,
                        target[chosen] * states + edge.target,
                        self._original[chosen],
                        np.full(len(chosen), edge.marks),
                    )
                )
        self.source, self.target, self.edge, self.marks = (
            np.concatenate(column) if parts else np.zeros(0, dtype=np.int64)
            for column in (zip(*parts, strict=True) if parts else [[]] * 4)
        )
        self._ways = EdgePaths(self._classes * states, self.source, self.target)

    def accepted(self) -> _LassoRun | None:
        """Return an accepted run, or None if there is none."""
        size = self._classes * self._states
        _, component = numbered_parts(size, self.source.astype(np.int32), self.target.astype(np.int32))
        inside = component[self.source] == component[self.target]
        found = np.zeros(int(component.max(initial=0)) + 1, dtype=np.int64)
        has_edge = np.zeros(len(found), dtype=np.bool_)
        np.bitwise_or.at(found, component[self.source[inside]], self.marks[inside])
        has_edge[component[self.source[inside]]] = True
        accepting = has_edge & (found == self._automaton.all_marks)
        way = self._ways.to(accepting[component], self._automaton.initial, np.ones(size, dtype=np.bool_))
        if way is None:
            return None
        stem, start = way
        loop = self._loop(start, component == component[start])
        return _LassoRun(self._graph, *(tuple(self.edge[edges].tolist()) for edges in (stem, loop)))

    def _loop(self, start: int, allowed: Flags) -> list[int]:
        """Return edges from a state of an accepting component back to it that carry all marks."""
        inside = allowed[self.source] & allowed[self.target]
        edges: list[int] = []
        missing, at = self._automaton.all_marks, start
        while missing or not edges:
            # A shortest way to an edge with a mark that is missing, and over it.
            wanted = np.flatnonzero(inside & ((self.marks & missing) != 0) if missing else inside)
            way, at = self._way(self.source[wanted], at, allowed)
            over = int(next(edge for edge in wanted if self.source[edge] == at))
            edges += [*way, over]
            missing &= ~int(self.marks[over])
            at = int(self.target[over])
        return edges + self._way(start, at, allowed)[0]

    def _way(self, goals: int | Int64Array, start: int, allowed: Flags) -> tuple[list[int], int]:
        """Return the edges of a shortest way to one of some states of the same component, and that state."""
        is_goal = np.zeros(len(allowed), dtype=np.bool_)
        is_goal[goals] = True
        way = self._ways.to(is_goal, start, allowed)
        if way is None:
            raise ReplayError("a goal that can be reached is not reached")
        return way


def _check(graph: TimedGraph, tree: Formula, atoms: BoundAtoms, run: _LassoRun) -> None:
    """Replay a counterexample: it has a schedule, and the formula is false on it by definition.

    Raises
    ------
    ReplayError
        The run is not a counterexample: an error of this program.
    """
    from dineros.analysis.nets.witness import WitnessError
    from dineros.analysis.timed.schedules import schedule

    deadlocks = graph.where(atoms.conditions[Deadlock()]) if Deadlock() in atoms.conditions else None
    steps: list[tuple[Step, bool]] = []
    for edge in (*run.stem_edges, *run.loop_edges):
        source, label = int(graph.source[edge]), int(graph.label[edge])
        marking = tuple(graph.markings[graph.marking_of[source]].tolist())
        steps.append(
            (
                Step(marking, None if label == WAITING else label),
                deadlocks is not None and bool(deadlocks[source]),
            )
        )

    def is_true(atom: Atom, step: tuple[Step, bool]) -> bool:
        return step[1] if isinstance(atom, Deadlock) else atoms.is_true(atom, step[0])

    cut = len(run.stem_edges)
    if holds_on_lasso(tree, steps[:cut], steps[cut:], is_true):
        raise ReplayError("the formula holds on its counterexample")
    try:
        schedule(graph.net, [*_transitions(run.stem), *_transitions(run.loop)])
    except WitnessError as error:
        raise ReplayError(str(error)) from error
