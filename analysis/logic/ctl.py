"""CTL on nets: the states that satisfy a formula, by fixpoints over any representation of sets of states.

Runs are infinite; one that reaches a deadlock stays there for ever, so a deadlock is its own successor.

References
----------
E. M. Clarke, E. A. Emerson, A. P. Sistla, *Automatic verification of finite-state concurrent systems using
temporal logic specifications*, TOPLAS 8(2), 1986.
"""

from __future__ import annotations

from functools import reduce
from typing import Protocol, TypeVar

from dineros.analysis.compiled import CompiledNet
from dineros.analysis.logic.atoms import BoundAtoms
from dineros.analysis.logic.budget import Budget, BudgetExceededError, Meter, ProgressCallback
from dineros.analysis.logic.names import Names, NetNames
from dineros.analysis.logic.parser import parse
from dineros.analysis.logic.syntax import (
    TRUE,
    And,
    Atom,
    Constant,
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
from dineros.analysis.logic.verdict import Verdict

States = TypeVar("States")


class StateSets(Protocol[States]):
    """What an engine offers to CTL: sets of reachable states and the three basic operators."""

    def constant(self, value: bool) -> States:
        """Return all states or none."""

    def atom(self, atom: Atom) -> States:
        """Return the states in which an atom is true."""

    def complement(self, states: States) -> States:
        """Return the other states."""

    def intersection(self, left: States, right: States) -> States:
        """Return the states in both sets."""

    def union(self, left: States, right: States) -> States:
        """Return the states in one of the sets."""

    def some_next(self, states: States) -> States:
        """EX: return the states with a successor in a set."""

    def some_until(self, stay: States, goal: States) -> States:
        """EU: return the states from which some run stays in one set until it is in the other."""

    def some_globally(self, states: States) -> States:
        """EG: return the states from which some run never leaves a set."""


def basic(formula: Formula) -> Formula:
    """Return an equivalent CTL formula over ``! & |`` and the three operators ``EX``, ``EU``, ``EG`` only."""
    match formula:
        case Exists(path):
            return _some(type(path), [basic(operand) for operand in path.operands])
        case ForAll(path):
            return Not(_some_not(type(path), [basic(operand) for operand in path.operands]))
    parts = tuple(basic(operand) for operand in formula.operands)
    match formula:
        case Atom() | Not() | And() | Or():
            return formula.with_operands(parts)
        case Implies():
            return Or((Not(parts[0]), parts[1]))
        case Equivalent():
            return Or((And(parts), And((Not(parts[0]), Not(parts[1])))))
    raise TypeError(f"no CTL formula: {formula}")


def _some(kind: type[Formula], parts: list[Formula]) -> Formula:
    """Some run satisfies the temporal operator."""
    if kind is Finally:
        return Exists(Until(TRUE, parts[0]))
    if kind is Release:
        left, right = parts
        return Or((Exists(Until(right, And((left, right)))), Exists(Globally(right))))
    if kind is WeakUntil:
        return Or((Exists(Until(*parts)), Exists(Globally(parts[0]))))
    return Exists(kind(*parts))


def _some_not(kind: type[Formula], parts: list[Formula]) -> Formula:
    """Some run violates the temporal operator."""
    no = [Not(part) for part in parts]
    if kind is Next:
        return Exists(Next(no[0]))
    if kind is Finally:
        return Exists(Globally(no[0]))
    if kind is Globally:
        return Exists(Until(TRUE, no[0]))
    if kind is Release:
        return Exists(Until(no[0], no[1]))
    never = Exists(Until(no[1], And((no[0], no[1]))))
    return never if kind is WeakUntil else Or((never, Exists(Globally(no[1]))))


def satisfying(formula: Formula, sets: StateSets[States]) -> dict[Formula, States]:
    """Return for every state formula in a `basic` CTL formula the states that satisfy it."""
    found: dict[Formula, States] = {}
    for part in formula.subformulas():
        match part:
            case Constant(value):
                found[part] = sets.constant(value)
            case Atom():
                found[part] = sets.atom(part)
            case Not(operand):
                found[part] = sets.complement(found[operand])
            case And(operands):
                found[part] = reduce(sets.intersection, [found[operand] for operand in operands])
            case Or(operands):
                found[part] = reduce(sets.union, [found[operand] for operand in operands])
            case Exists(Next(operand)):
                found[part] = sets.some_next(found[operand])
            case Exists(Until(left, right)):
                found[part] = sets.some_until(found[left], found[right])
            case Exists(Globally(operand)):
                found[part] = sets.some_globally(found[operand])
    return found


def check_ctl(
    net: CompiledNet,
    formula: str | Formula,
    names: Names | None = None,
    budget: Budget | None = None,
    progress: ProgressCallback | None = None,
) -> Verdict:
    """Decide whether the initial marking of a net satisfies a CTL formula.

    Parameters
    ----------
    net : CompiledNet
        The net; if it is unbounded the answer is ``unknown`` when a limit is hit.
    formula : str or Formula
        The formula.
    names : Names, optional
        What names stand for; by default places and transitions of the net.
    budget : Budget, optional
        Limits; by default there are none.
    progress : callable, optional
        Told a few times a second how many states are known.

    Returns
    -------
    Verdict
        With a replayed path or lasso for the outermost operator where one shows the answer: a counterexample
        to ``AG``, a witness of ``EF``, and so on.

    Raises
    ------
    FormulaError
        If the formula is none or names something unknown.

    Examples
    --------
    >>> net = CompiledNet.build({"idle": 1, "busy": 0}, [("start", {"idle": 1}, {"busy": 1})])
    >>> check_ctl(net, "AG EF idle >= 1")
    Verdict(status='violated', stem=(0,), loop=(), states=2, ...)
    """
    from dineros.analysis.logic.explicit_sets import ExplicitSets, show
    from dineros.analysis.logic.graph import StateGraph

    meter = Meter(budget or Budget(), progress)
    tree = parse(formula, "ctl") if isinstance(formula, str) else formula
    atoms = BoundAtoms(net, tree, names or NetNames(net))
    states = 0
    try:
        graph = StateGraph(net, list(atoms.conditions.items()), meter)
        try:
            graph.explore()
        finally:
            states = graph.size
        wanted = basic(tree)
        found = satisfying(wanted, ExplicitSets(graph))
    except BudgetExceededError as limit:
        return Verdict("unknown", states=states, seconds=meter.seconds, reason=str(limit))
    holds = bool(found[wanted][0])
    stem, loop, reason = show(graph, wanted, holds, found)
    return Verdict("holds" if holds else "violated", stem, loop, states, meter.seconds, reason)
