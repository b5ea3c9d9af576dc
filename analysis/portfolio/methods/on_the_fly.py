"""LTL model checking with an automaton, on the fly."""

from __future__ import annotations

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.stages import fairly
from dineros.analysis.explicit.layout import Layout
from dineros.analysis.logic.automata.translation import translate
from dineros.analysis.logic.graphs.product import Product
from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.combining import combined, condition_of
from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.logic.language.names import Names, NetNames
from dineros.analysis.logic.language.rewriting import negated
from dineros.analysis.logic.language.syntax import Formula
from dineros.analysis.logic.ltl.emptiness import Emptiness
from dineros.analysis.logic.verdicts.verdict import check_counterexample
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.portfolio.budgets import GIVEN_UP
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.sheet import Sheet
from dineros.analysis.properties.normal_form import is_linear, linear_equal


class AutomatonOnTheFly(Method):
    """Search the product with an automaton, with the net reduced for the formula or the net itself."""

    def answer_all(self, sheet: Sheet, known: Known, budget: Budget) -> None:
        """Decide LTL subformulas, and CTL subformulas that have an equivalent in LTL."""
        linear = [(part, (part.operands[0], True)) for part in sheet.open_parts() if is_linear(part)]
        branching = [(part, linear_equal(part)) for part in sheet.open_parts() if not is_linear(part)]
        parts = [*linear, *((part, equal) for part, equal in branching if equal is not None)]
        for (part, (path, value)), share in fairly(parts, budget, memory=0.5):
            holds = _holds(known, path, sheet.names, share.at_most(sheet.patience))
            if holds is not None:
                sheet.known[part] = value == holds
                sheet.settle("on the fly")


def _holds(known: Known, path: Formula, names: Names, budget: Budget) -> bool | None:
    smaller = known.reduced(path, names)
    if smaller is not None:
        holds = holds_always(smaller.net, smaller.formula, NetNames(smaller.net), budget)
        if holds is not None or budget.is_over:
            return holds
    return holds_always(known.net, path, names, budget, known.cells)


def holds_always(
    net: CompiledNet, formula: Formula, names: Names, budget: Budget, cells: Layout | None = None
) -> bool | None:
    """Decide whether all runs satisfy an LTL formula; a counterexample is checked, but not shortened."""
    budget = budget.begun()
    atoms = BoundAtoms(net, formula, names)
    try:
        automaton = translate(negated(combined(formula)))
        conditions = [condition_of(atom, atoms.conditions) for atom in automaton.atoms]
        run = Emptiness(Product(net, automaton, conditions, (), (), budget, cells), budget).run()
    except (*GIVEN_UP, FormulaError):  # includes too large automata
        return None
    if run is not None:
        check_counterexample(net, formula, atoms, run.stem, run.loop)
    return run is None
