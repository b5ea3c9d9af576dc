"""Bounded model checking and k-induction: goals reached within few steps, or proved never to be reached.

At depth k a solver is asked for k steps from the initial marking to the goal; then for k steps from any
marking, none but the last of which meets the goal. If the second do not exist, and no fewer steps than k
from the initial marking lead to the goal, it is never reached.

References
----------
A. Biere, A. Cimatti, E. M. Clarke, Y. Zhu, *Symbolic model checking without BDDs*, TACAS 1999, LNCS 1579. M.
Sheeran, S. Singh, G. Stalmarck, *Checking safety properties using induction and a SAT-solver*, FMCAD 2000,
LNCS 1954. The solver: A. Ignatiev, A. Morgado, J. Marques-Silva, *PySAT*, SAT 2018, LNCS 10929.
"""

from __future__ import annotations

from collections.abc import Mapping

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.answers.evidence import Inductive
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.language.atoms import Condition
from dineros.analysis.logic.language.syntax import Atom, Formula
from dineros.analysis.nets.bounds import place_bounds
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.structure import place_invariants
from dineros.analysis.proofs.encoding import Sums, TooLargeError, Unrolling

MOST_LITERALS, MOST_TOKENS = 3_000, 16
"""Literals of a marking, and tokens of a place, up to which a net is one of few tokens."""

MOST_DEPTH = 100

LARGEST_SUM = 24
"""Limit of the tokens of an invariant that is given to the solver."""

BOUNDED, INDUCTION = "bounded model checking", "k-induction"


def sums_of(net: CompiledNet) -> Sums | None:
    """Return bounds and invariants of a net whose places are proved to hold few tokens; else None."""
    found = place_bounds(net)
    bounds = [bound for bound in found if bound is not None]
    values = tuple(bound.value for bound in bounds)
    if len(values) < len(found) or sum(values) > MOST_LITERALS or max(values, default=0) > MOST_TOKENS:
        return None
    weightings = []
    for invariant in place_invariants(net):
        weights = invariant.weights
        most = sum(abs(weight) * values[place] for place, weight in weights.items())
        if most <= LARGEST_SUM or (min(weights.values()) > 0 and 0 <= invariant.constant <= LARGEST_SUM):
            weightings.append(weights)
    return Sums(values, tuple(bound.weights for bound in bounds), tuple(weightings))


def by_induction(
    net: CompiledNet,
    goal: Formula,
    conditions: Mapping[Atom, Condition],
    budget: Budget,
    known: Sums | None = None,
) -> Outcome:
    """Look for a way to a goal, or a proof that there is none, ever deeper.

    Parameters
    ----------
    known : Sums, optional
        Bounds and invariants, where they are known.

    Returns
    -------
    Outcome
        ``reachable`` with a trace, not replayed; ``unreachable`` with `Inductive`; or ``unknown``.
    """
    budget, known = budget.begun(), known or sums_of(net)
    if known is None:
        return Outcome("unknown", reason="some places may hold many tokens")
    try:
        return _search(net, known, goal, conditions, budget)
    except TooLargeError:
        return Outcome("unknown", reason="the propositional formula grows too large")
    except BudgetExceededError as limit:
        return Outcome("unknown", reason=str(limit))


def _search(
    net: CompiledNet, known: Sums, goal: Formula, conditions: Mapping[Atom, Condition], budget: Budget
) -> Outcome:
    from pysat.solvers import Glucose4

    with Glucose4() as solver:
        unrolling = Unrolling(net, known, solver, conditions)
        avoided: list[int] = []
        for depth in range(MOST_DEPTH + 1):
            met = unrolling.literal(goal, depth)
            if unrolling.solve([unrolling.begins, *avoided, met], depth, budget):
                trace = unrolling.trace(depth, solver.get_model())
                return Outcome("reachable", trace, seconds=budget.spent, by=BOUNDED)
            if not unrolling.solve([*avoided, met], depth, budget):
                evidence = Inductive(depth, known.bounds, known.proofs, known.weightings)
                return Outcome("unreachable", seconds=budget.spent, by=INDUCTION, evidence=evidence)
            avoided.append(-met)
            unrolling.add_step()
    return Outcome("unknown", reason=f"{MOST_DEPTH} steps do not decide it")
