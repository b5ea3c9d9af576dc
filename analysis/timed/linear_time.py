"""LTL on nets with time: every run satisfies a formula, or here is one that does not, with its schedule.

Runs are those of the state class graph: infinite firing sequences that some schedule has, and runs that stay
in a marking forever, because nothing has to fire there; such a run never fires again.

Of a plain net, each such sequence is a run. Of a system model, time passes without end in a run: see
`TimedNet.time_passes`. Infinitely many firings in finite time (a Zeno run), such as endless changes of a
signal while something else has to fire, are no run of a real system. One kind of them counts: runs that fire
only transitions with the interval ``[0,0]`` from some moment on. There the model itself stops time. With
priorities, transitions with priority over others belong to this kind, too.

Each beginning of a run continues as a run that counts, so no formula holds only because there are no
runs: fire what must fire at that moment, and what has priority over it. If that run is not of the kind that
stops time, then some transition with a latest bound above 0 fires infinitely often, each time after it was
enabled for as long as that bound.

A run takes infinite time if a transition with the interval ``[1, inf)``, which is always enabled, can fire in
it infinitely often. This is exact, but makes more classes. So it is asked only if all violations that were
found may be Zeno runs, and no latest bound shows that they are.

References
----------
B. Berthomieu, F. Vernadat, *State class constructions for branching analysis of time Petri nets*, TACAS
2003, LNCS 2619 (linear classes keep markings and firing sequences).
S. Tripakis, *Verifying progress in timed systems*, ARTS 1999, LNCS 1601 (runs in which time passes).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from dineros.analysis.answers.budget import RAN_OUT, UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.automata.automaton import Automaton
from dineros.analysis.logic.automata.translation import translate
from dineros.analysis.logic.language.atoms import BoundAtoms, Step
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
from dineros.analysis.timed.classes import Kind
from dineros.analysis.timed.goals import find_timed
from dineros.analysis.timed.graph import WAITING, TimedGraph, timed_graph
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.runs.infinite_time import all_take_finite_time, passing, stopping, with_ticks
from dineros.analysis.timed.runs.product import ClassProduct, LassoRun

MOST_ATOMS = 62
"""Letters are bits of one word."""

BY = "state classes"

TIME_PASSES = "infinitely many firings in finite time do not count as a run"
"""What an answer assumes if only such runs violate the formula."""


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
    reason = ""
    try:
        if len(automaton.atoms) > MOST_ATOMS:
            raise BudgetExceededError(f"the formula has more than {MOST_ATOMS} atoms")
        kind = kind or ("S" if net.has_priorities else "W")
        graph = timed_graph(net, kind, budget)
        classes = graph.classes
        budget.stage("the product with the automaton")
        product = ClassProduct(graph, automaton, atoms, budget)
        if not net.time_passes:
            run = product.accepted()
        else:
            run = product.accepted([passing(graph)]) or product.accepted(allowed=stopping(graph))
            if run is None and product.accepted() is not None:
                reason = TIME_PASSES
                if all_take_finite_time(graph, *product.accepting_parts()):
                    return Outcome("holds", states=classes, seconds=budget.spent, by=BY, reason=reason)
                found = _in_infinite_time(net, kind, automaton, atoms, budget)
                graph, run = (graph, None) if found is None else found
    except BudgetExceededError as limit:
        said = RAN_OUT.get(str(limit), str(limit))
        if reason:
            said = f"the violations that were found fire infinitely often in finite time; others: {said}"
        return Outcome("unknown", states=classes, seconds=budget.spent, reason=said)
    if run is None:
        return Outcome("holds", states=classes, seconds=budget.spent, by=BY, reason=reason)
    stem, loop = _checked(net, graph, tree, atoms, run)
    return Outcome("violated", stem, loop, classes, budget.spent, by=BY)


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


def _in_infinite_time(
    net: TimedNet, kind: Kind, automaton: Automaton, atoms: BoundAtoms, budget: Budget
) -> tuple[TimedGraph, LassoRun] | None:
    """Return an accepted run that takes infinite time and never waits forever, or None if there is none."""
    budget.stage("runs that take infinite time")
    ticking, tick = with_ticks(net)
    graph = timed_graph(ticking, kind, budget)
    ticks = graph.label == tick
    run = ClassProduct(graph, automaton, atoms, budget, [tick]).accepted([ticks, ~ticks])
    return None if run is None else (graph, run)


def _checked(
    net: TimedNet, graph: TimedGraph, tree: Formula, atoms: BoundAtoms, run: LassoRun
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Replay a counterexample, and return its firings: it has a schedule, and the formula is false on it.

    Raises
    ------
    ReplayError
        The run is not a counterexample: an error of this program.
    """
    from dineros.analysis.nets.witness import WitnessError
    from dineros.analysis.timed.schedules import schedule

    deadlocks = graph.where(atoms.conditions[Deadlock()]) if Deadlock() in atoms.conditions else None

    def read(edges: Sequence[int]) -> tuple[list[tuple[Step, bool]], tuple[int, ...]]:
        """Return the steps that the formula reads, and the firings."""
        steps: list[tuple[Step, bool]] = []
        for edge in edges:
            source, label = int(graph.source[edge]), int(graph.label[edge])
            if label < len(net.intervals):
                marking = tuple(graph.markings[graph.marking_of[source]].tolist())
                step = Step(marking, None if label == WAITING else label)
                steps.append((step, deadlocks is not None and bool(deadlocks[source])))
        return steps, tuple(step.transition for step, _ in steps if step.transition is not None)

    def is_true(atom: Atom, step: tuple[Step, bool]) -> bool:
        return step[1] if isinstance(atom, Deadlock) else atoms.is_true(atom, step[0])

    (before, stem), (repeated, loop) = read(run.stem_edges), read(run.loop_edges)
    if holds_on_lasso(tree, before, repeated, is_true):
        raise ReplayError("the formula holds on its counterexample")
    try:
        schedule(net, [*stem, *loop])
    except WitnessError as error:
        raise ReplayError(str(error)) from error
    return stem, loop
