"""CTL on nets with an infinite state space: decides what is decidable, and reports the rest at once.

CTL is undecidable there. Decidable are: whether a marking is reachable, as far as goals of a search express
it; formulas on nets in which only counters grow; and universal formulas that a single run refutes, since the
formula without its quantifiers is weaker.

References
----------
J. Esparza, *On the decidability of model checking for several mu-calculi and Petri nets*, CAAP 1994, LNCS
787.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.stages import Attempt, Share, first_result
from dineros.analysis.covering.bounded_part import unbounded_places
from dineros.analysis.covering.goals import decide_goal
from dineros.analysis.covering.growing import without_growth
from dineros.analysis.covering.growth import growth_of
from dineros.analysis.explicit import find
from dineros.analysis.explicit.goals import Goal
from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.disjunctions import goals_of
from dineros.analysis.logic.language.names import LimitedNames, Names
from dineros.analysis.logic.language.syntax import (
    And,
    Exists,
    Finally,
    ForAll,
    Formula,
    Globally,
    Implies,
    Not,
    Or,
)
from dineros.analysis.logic.ltl.growing_runs import EndlessRuns, compared_tokens, endless_text
from dineros.analysis.logic.ltl.verification import verify_ltl
from dineros.analysis.nets.compiled import CompiledNet

NEAR = 200_000
"""Maximum number of markings of a search for a goal that is not about single places."""

GROWTH = Share(time=0.2)
"""Share of the proof that the net is unbounded."""

Check = Callable[[CompiledNet, Formula, Names, Budget], Outcome]
"""`check_ctl`."""


def decide_endless(
    net: CompiledNet, tree: Formula, atoms: BoundAtoms, names: Names, budget: Budget, check: Check
) -> Outcome | None:
    """Decide a formula on an unbounded net, or report what grows; None: unboundedness is not proved.

    Parameters
    ----------
    check : callable
        Decides a formula on a bounded net.
    """
    pumping = growth_of(net, GROWTH.share(budget))
    if pumping is None:
        return None
    attempts = (
        Attempt(lambda share: _without_counters(net, tree, atoms, names, share, check)),
        Attempt(lambda share: _by_search(net, tree, names, share)),
        Attempt(lambda share: _by_run(net, tree, names, share), time=0.5),
    )
    found = first_result(attempts, budget)
    if found is None:
        found = Outcome("unknown", reason=f"states: {endless_text(net, pumping)}")
    return replace(found, seconds=budget.spent, states=found.states or 0)


def _without_counters(
    net: CompiledNet, tree: Formula, atoms: BoundAtoms, names: Names, budget: Budget, check: Check
) -> Outcome | None:
    compared = compared_tokens(net, atoms)
    small = None if compared is None else without_growth(net, compared)
    if small is None or unbounded_places(small.net):
        return None
    answer = check(small.net, tree, LimitedNames(names, small.place, small.images()), budget)
    if answer.status == "unknown":
        return None
    trace = None if answer.trace is None else small.back(answer.trace)
    return replace(answer, trace=trace, loop=small.back(answer.loop))


def _by_search(net: CompiledNet, tree: Formula, names: Names, budget: Budget) -> Outcome | None:
    """Decide whether some marking is reachable: ``EF`` and ``AG`` of a condition."""
    match tree:
        case Exists(Finally(condition)) if _is_condition(condition):
            is_met, is_never_met = "holds", "violated"
        case ForAll(Globally(operand)) if _is_condition(operand):
            condition, is_met, is_never_met = Not(operand), "violated", "holds"
        case _:
            return None
    goals = goals_of(net, condition, names)
    if goals is None:
        return None
    answers = [_reached(net, goal, budget) for goal in goals]
    for answer in answers:
        if answer is not None and answer.status == "reachable":
            return replace(answer, status=is_met, reason=f"shows {Exists(Finally(condition))}")
    return None if None in answers else Outcome(is_never_met)


def _reached(net: CompiledNet, goal: Goal, budget: Budget) -> Outcome | None:
    def near(share: Budget) -> Outcome | None:
        found = find(net, goal, share)
        return None if found.status == "unknown" else found

    attempts = (
        Attempt(lambda share: decide_goal(net, goal, share), time=0.5),
        Attempt(near, time=0.5, most_states=NEAR),
    )
    return first_result(attempts, budget)


def _by_run(net: CompiledNet, tree: Formula, names: Names, budget: Budget) -> Outcome | None:
    linear = _without_quantifiers(tree)
    if linear is None:
        return None
    runs = EndlessRuns(net, linear, BoundAtoms(net, linear, names), names, (), (), verify_ltl)
    answer = runs.decide(budget)
    if answer is None or answer.status == "violated":
        return answer
    # It is as strong as the formula only if there is one quantifier in front.
    return answer if isinstance(tree, ForAll) and all(map(_is_condition, tree.operand.operands)) else None


def _is_condition(formula: Formula) -> bool:
    return not any(isinstance(part, (Exists, ForAll)) for part in formula.subformulas())


def _without_quantifiers(tree: Formula) -> Formula | None:
    """Return a universal formula as an LTL formula; None: it is of another kind."""
    if _is_condition(tree):
        return tree
    match tree:
        case ForAll(outer) | (And() as outer) | (Or() as outer):
            parts = [_without_quantifiers(operand) for operand in outer.operands]
            return None if None in parts else outer.with_operands(tuple(filter(None, parts)))
        case Implies(left, right) if _is_condition(left):
            later = _without_quantifiers(right)
            return None if later is None else Implies(left, later)
    return None
