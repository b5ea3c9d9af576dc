"""Clauses that can never be true, with a minimal unsatisfiable core (paper, Sect. 7.2).

A clause is already in conjunctive normal form, so it goes to a SAT solver as it is. The core is made minimal
by deletion: a disjunction stays only if the others are satisfiable without it (Marques-Silva, ISMVL 2010).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from dineros.metamodel import sym
from dineros.metamodel.clauses import LiteralVariables, literal_text, value_names
from dineros.metamodel.elements import node_net_of, transitions


@dataclass(frozen=True)
class Unsatisfiable:
    """A clause that no values of its signals make true."""

    transition: sym.Transition
    """The transition it guards, which can therefore never fire."""
    core: tuple[sym.Disjunction, ...]
    """A minimal set of its disjunctions that exclude each other."""

    def __str__(self) -> str:
        node = node_net_of(self.transition)
        clause = self.transition.clause
        text = clause.text if clause is not None else ""
        core = " and ".join(disjunction_text(disjunction) for disjunction in self.core)
        where = f" of {node.id}" if node is not None else ""
        return f"clause {text!r} of {self.transition.id}{where} can never be true: {core or 'false'}"


def unsatisfiable_clauses(model: sym.SystemModel) -> list[Unsatisfiable]:
    """Return the clauses of a system model that can never be true, in model order."""
    found = []
    for transition in transitions(model):
        if isinstance(transition, sym.Transition) and transition.clause is not None:
            core = _minimal_core(transition.clause)
            if core is not None:
                found.append(Unsatisfiable(transition, core))
    return found


def _minimal_core(clause: sym.InputClause) -> tuple[sym.Disjunction, ...] | None:
    """Return a minimal unsatisfiable subset of the disjunctions, or None for a satisfiable clause."""
    disjunctions = list(clause.disjunctions)
    if _has_pure_literals(disjunctions):
        return None
    from pysat.solvers import Cadical153

    variables = LiteralVariables(value_names)
    literals = [
        [variables.number(each.signal, each.value, each.negated) for each in disjunction.literals]
        for disjunction in disjunctions
    ]
    selectors = {len(variables) + number: disjunction for number, disjunction in enumerate(disjunctions, 1)}
    with Cadical153(bootstrap_with=variables.rules()) as solver:
        for selector, numbers in zip(selectors, literals, strict=True):
            solver.add_clause([-selector, *numbers])
        if solver.solve(assumptions=list(selectors)):
            return None
        core = sorted(solver.get_core() or [])
        for selector in list(core):
            others = [kept for kept in core if kept != selector]
            if not solver.solve(assumptions=others):
                core = others
    return tuple(selectors[selector] for selector in core)


def _has_pure_literals(disjunctions: Sequence[sym.Disjunction]) -> bool:
    """Return whether each signal is true or false and has one sign throughout: that satisfies them all."""
    literals = [literal for disjunction in disjunctions for literal in disjunction.literals]
    signs = {(literal.signal, literal.negated) for literal in literals}
    return (
        all(disjunction.literals for disjunction in disjunctions)
        and all(literal.value is None for literal in literals)
        and len(signs) == len({signal for signal, _ in signs})
    )


def disjunction_text(disjunction: sym.Disjunction) -> str:
    """Return a disjunction as text, such as ``(Idle | !Busy)``."""
    literals = [
        f"{'!' if literal.negated else ''}{literal.signal.name or literal.signal.id}"
        if literal.value is None
        else literal_text(literal)
        for literal in disjunction.literals
    ]
    return literals[0] if len(literals) == 1 else f"({' | '.join(literals) or 'false'})"
