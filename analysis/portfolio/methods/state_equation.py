"""The state equation and traps: proofs that no marking fulfils a condition, without a state space."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.stages import fairly
from dineros.analysis.logic.language.rewriting import simplified
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.reach import Reach
from dineros.analysis.portfolio.satisfies import Question

if TYPE_CHECKING:
    from dineros.analysis.answers.evidence import Row
    from dineros.analysis.logic.language.syntax import Formula
    from dineros.analysis.portfolio.sheet import Sheet
    from dineros.analysis.walks.arrays import Int64Array

STATE_EQUATION, TRAPS = "state equation", "state equation and traps"


class StateEquationAndTraps(Method):
    """Exclude each alternative of the condition by a weighting of the places."""

    def answer(self, question: Question, known: Known, budget: Budget) -> Outcome | None:
        """Return that no marking fulfils the condition, or None; structure proves nothing else."""
        from dineros.analysis.proofs.exclusion import excluded

        if not isinstance(question, Reach):
            return None
        wanted = simplified(question.condition)
        found = excluded(known.equation, wanted, question.conditions, lambda: budget.is_over)
        if found is None:
            return None
        return Outcome("unreachable", by=TRAPS if found.traps else STATE_EQUATION, evidence=found)

    def answer_all(self, sheet: Sheet, known: Known, budget: Budget) -> None:
        """Compute upper bounds of sums, exclude goals, and walk along solutions of the equation."""
        _bound_sums(sheet, known, budget)
        if sheet.open_globals():
            sheet.whole.by_state_equation(known.equation, budget)
        _exclude_goals(sheet, known, budget)
        _exclude_conditions(sheet, known, budget)


def _bound_sums(sheet: Sheet, known: Known, budget: Budget) -> None:
    import numpy as np

    for limits in sheet.open_limits().values():
        if budget.is_over:
            return
        most = known.equation.largest(limits.factors)
        if most is not None and (limits.most is None or most < limits.most):
            limits.most = most
    sheet.settle("state equation")
    for limits in sheet.open_limits().values():
        gains = np.zeros(len(known.net.transitions), dtype=np.int64)
        for t, change in enumerate(known.net.delta):
            gains[t] = sum(limits.factors.get(p, 0) * tokens for p, tokens in change.items())
        if limits.most is not None and not budget.is_over:
            _follow(sheet, known, budget, [(limits.factors, limits.most)])
        elif not budget.is_over:
            _follow(sheet, known, budget, [], gains)


def _follow(
    sheet: Sheet, known: Known, budget: Budget, rows: Sequence[Row], gains: Int64Array | None = None
) -> None:
    """Walk along a solution of the state equation, and evaluate the markings."""
    from dineros.analysis.portfolio.walker import TRIES, follow
    from dineros.analysis.walks.firing_counts import firings

    counts = firings(known.net, rows, gains)
    for seed in range(TRIES if counts is not None else 0):
        if budget.is_over:
            return
        assert counts is not None
        sheet.look(follow(known.walker.arrays, counts, seed), "directed walk")


def _exclude_goals(sheet: Sheet, known: Known, budget: Budget) -> None:
    from dineros.analysis.proofs.exclusion import excluded

    for (part, condition, value), own in fairly(sheet.open_goals(), budget, factor=2.0):
        if own.is_over:
            break

        def reached(rows: Sequence[Row], part: Formula = part, own: Budget = own) -> bool:
            _follow(sheet, known, own, rows)
            return part in sheet.known

        def is_late(own: Budget = own) -> bool:
            return own.is_over

        if found := excluded(known.equation, simplified(condition), sheet.conditions, is_late, reached):
            sheet.known[part], sheet.evidence[part] = not value, found
    sheet.settle("state equation")


def _exclude_conditions(sheet: Sheet, known: Known, budget: Budget) -> None:
    """Find constant conditions, which simplify any formula that contains them."""
    from dineros.analysis.logic.graphs.predicates import is_condition
    from dineros.analysis.logic.language.syntax import Atom, Constant, Not
    from dineros.analysis.proofs.exclusion import excluded

    found = [
        part
        for formula in sheet.open_formulas().values()
        for part in formula.subformulas()
        if part not in sheet.always and is_condition(part) and not isinstance(part, Constant)
    ]
    # Larger conditions first: their atoms need not be decided then.
    for part in sorted(dict.fromkeys(found), key=lambda part: isinstance(part, Atom)):
        if budget.is_over:
            break
        for value, condition in ((False, simplified(part)), (True, simplified(Not(part)))):
            proof = excluded(
                known.equation, condition, sheet.conditions, lambda: budget.is_over, most_traps=0
            )
            if proof is not None:
                sheet.always[part], sheet.evidence[part] = value, proof
                break
    sheet.settle("state equation")
