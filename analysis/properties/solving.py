"""What satisfiability solvers answer: ways to goals, and proofs that there is none.

Nets whose places are proved to hold few tokens are asked by k-induction first, then by property directed
reachability, which takes longer to begin and often knows where no few steps do.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.language.atoms import BoundAtoms, Condition, NoneEnabled
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.syntax import Atom, Deadlock, Formula
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import replay
from dineros.analysis.proofs.encoding import Sums
from dineros.analysis.proofs.induction import by_induction, sums_of
from dineros.analysis.proofs.pdr import by_clauses
from dineros.analysis.properties.engines import Clock, part_of_graph
from dineros.analysis.properties.global_properties import GlobalQuestions
from dineros.analysis.properties.predicates import MarkingMatrix, satisfied
from dineros.analysis.properties.reduced import Reduced, reduced
from dineros.analysis.properties.sheet import Sheet
from dineros.analysis.properties.walking import Walker

STUCK = Deadlock()

Solver = Callable[[CompiledNet, Formula, Mapping[Atom, Condition], Budget, Sums], Outcome]
SOLVERS: tuple[tuple[Solver, float], ...] = ((by_induction, 0.5), (by_clauses, 1.0))
"""Who is asked, with a part of the time that is left then."""


def ask_solvers(sheet: Sheet, whole: GlobalQuestions, clock: Clock) -> None:
    """Ask for ways to open goals, and to a deadlock where one is asked for, or for proofs."""
    net = sheet.net
    can_stop = bool(sheet.open_globals()) and whole.is_open("ReachabilityDeadlock")
    known = sums_of(net) if can_stop or sheet.open_goals() else None
    if known is None:
        return
    for solver, share in SOLVERS:
        own, goals = Clock(share * clock.left), sheet.open_goals()
        for number, (part, condition, value) in enumerate(goals):
            seconds = own.left / (len(goals) - number + can_stop)
            answer = solver(net, condition, sheet.conditions, Budget(seconds=seconds), known)
            if answer.trace is not None:
                sheet.look(_end(net, answer), answer.by)
            elif answer.status == "unreachable":
                sheet.known[part] = not value
                if answer.evidence is not None:
                    sheet.evidence[part] = answer.evidence
                sheet.settle(answer.by)
        if can_stop and whole.is_open("ReachabilityDeadlock"):
            met = _value(net, STUCK, {STUCK: NoneEnabled()}, own, known, solver)
            if met is not None:
                whole.tell("ReachabilityDeadlock", met[0], met[1])


def search_reduced(sheet: Sheet, clock: Clock, seconds: float, memory: int) -> None:
    """Look for goals in nets reduced for each of them: by solvers, all markings where few, random walks.

    Parameters
    ----------
    sheet : Sheet
        The questions.
    clock : Clock
        The time of all goals.
    seconds : float
        For each goal, at most.
    memory : int
        Bytes that the markings may take.
    """
    goals = sheet.open_goals()
    for number, (part, condition, value) in enumerate(goals):
        own = Clock(min(seconds, clock.left / (len(goals) - number)))
        smaller = reduced(sheet.net, condition, sheet.names)
        if smaller is not None and not own.is_over():
            met = _is_met(smaller, memory, own)
            if met is not None:
                sheet.known[part] = value == met
                sheet.settle("reduced net")


def _is_met(smaller: Reduced, memory: int, clock: Clock) -> bool | None:
    """Decide whether some reachable marking fulfils a condition; None where time does not suffice."""
    net, condition = smaller.net, smaller.formula
    conditions = BoundAtoms(net, condition, NetNames(net)).conditions
    own, known = Clock(clock.left / 4), sums_of(net)
    for solver, share in SOLVERS if known is not None else ():
        assert known is not None
        met = _value(net, condition, conditions, Clock(share * own.left), known, solver)
        if met is not None:
            return met[0]
    graph = part_of_graph(net, None, memory, clock.left / 2)
    if graph is None:
        return None
    found = bool(satisfied(graph, condition, conditions).any())
    walker = Walker(net)
    while not (found or graph.is_complete or clock.is_over()):
        found = bool(satisfied(walker.walk(), condition, conditions).any())
    return found if found or graph.is_complete else None


def _value(
    net: CompiledNet,
    condition: Formula,
    conditions: Mapping[Atom, Condition],
    clock: Clock,
    known: Sums,
    solver: Solver,
) -> tuple[bool, str] | None:
    answer = solver(net, condition, conditions, Budget(seconds=clock.left), known)
    if answer.trace is not None:
        if not satisfied(_end(net, answer), condition, conditions).all():
            raise AssertionError(f"{answer.by}: its way does not lead to {condition}")
        return True, answer.by
    return (False, answer.by) if answer.status == "unreachable" else None


def _end(net: CompiledNet, answer: Outcome) -> MarkingMatrix:
    """Return where a way leads, by the plain firing rule."""
    return MarkingMatrix(net, np.array(replay(net, answer.trace or ())[-1:], dtype=np.int64))
