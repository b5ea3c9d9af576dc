"""Temporal formulas decided as goals where possible: a conjunction is split, and its goals are decided alone.

``G p`` of LTL, ``AG p`` and ``EF p`` of CTL are reachability questions, with or without fairness: every
firing sequence can be continued as a run that is weakly and strongly fair to finitely many transitions.

References
----------
K. R. Apt, N. Francez, S. Katz, *Appraising fairness in languages for distributed programming*, Distributed
Computing 2, 1988 (every beginning continues fairly).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.stages import fairly
from dineros.analysis.logic.graphs.predicates import is_condition
from dineros.analysis.logic.language.atoms import BoundAtoms, all_resolved
from dineros.analysis.logic.language.names import Names
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.rewriting import simplified
from dineros.analysis.logic.language.syntax import And, Enabled, Fired, Formula, Globally, Name, Not, Or
from dineros.analysis.logic.ltl.free_parts import without_free_parts
from dineros.analysis.logic.ltl.verification import verify_ltl
from dineros.analysis.logic.verdicts.faults import check_fault, faulty_beginning
from dineros.analysis.logic.verdicts.verdict import ReplayError, check_counterexample
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import ending_with_one_of
from dineros.analysis.portfolio.asking import find_enabled, find_marking
from dineros.analysis.portfolio.plans import NEAR_STATES
from dineros.analysis.properties.normal_form import goal_of

if TYPE_CHECKING:
    from dineros.analysis.logic.ltl.earlier import EarlierSearches
    from dineros.analysis.symbolic.order_cache import OrderCache

ON_THE_FLY = "automaton on the fly"


def verify_linear(
    net: CompiledNet,
    formula: str | Formula,
    names: Names,
    weak: Iterable[str] = (),
    strong: Iterable[str] = (),
    budget: Budget = UNLIMITED,
    earlier: EarlierSearches | None = None,
) -> Outcome:
    """Decide whether all fair runs satisfy an LTL formula: each ``G p`` of a conjunction as a goal.

    Parameters and results are those of `verify_ltl`; a counterexample ends as soon as it violates the formula
    regardless of its continuation.

    Raises
    ------
    FormulaError
        It is not a formula, has an unknown name, or is too large.
    """
    budget, weak, strong = budget.begun(), tuple(weak), tuple(strong)
    tree = parse(formula) if isinstance(formula, str) else formula
    BoundAtoms(net, tree, names)  # raises if a name is unknown
    all_resolved(names, [*weak, *strong])
    wanted = simplified(tree)
    parts = wanted.operands if isinstance(wanted, And) else (wanted,)
    conditions = [part.operand for part in parts if isinstance(part, Globally) and _is_goal(part.operand)]
    others = tuple(part for part in parts if not (isinstance(part, Globally) and _is_goal(part.operand)))

    def ask_others(share: Budget) -> Outcome:
        rest = tree if not conditions else others[0] if len(others) == 1 else And(others)
        answer = replace(_on_the_fly(net, rest, names, weak, strong, share, earlier), by=ON_THE_FLY)
        return _up_to_fault(net, rest, names, answer)

    def ask_goal(condition: Formula, share: Budget) -> Outcome:
        way = _way_against(net, condition, names, share)
        if way.trace is None:
            return replace(way, status={"unreachable": "holds"}.get(way.status, "unknown"))
        check_fault(net, Globally(condition), names, way.trace)
        return replace(way, status="violated", ends_at_fault=True)

    asked = [partial(ask_goal, condition) for condition in conditions]
    return _all_of([*asked, *([ask_others] if others else [])], budget)


def _is_goal(condition: Formula) -> bool:
    """Whether the violation of a condition is a goal: a marking, or the firing of a transition in one."""
    return is_condition(condition) or _firing_against(condition) is not None


def _firing_against(condition: Formula) -> tuple[Name, tuple[Formula, ...]] | None:
    """Return the transition whose firing violates a condition, and the other conditions; None: no such."""
    parts = condition.operands if isinstance(condition, Or) else (condition,)
    fired = [part.operand.name for part in parts if isinstance(part, Not) and isinstance(part.operand, Fired)]
    others = tuple(part for part in parts if is_condition(part))
    if len(fired) != 1 or len(others) != len(parts) - 1:
        return None
    return fired[0], tuple(Not(part) for part in others)


def _way_against(net: CompiledNet, condition: Formula, names: Names, budget: Budget) -> Outcome:
    """Find a trace to the violation of a condition."""
    found = _firing_against(condition)
    if found is None:
        return find_marking(net, Not(condition), names, budget, is_shortest=False)
    name, others = found
    if not others:
        return find_enabled(net, name.text, names, budget, is_shortest=False)
    way = find_marking(net, And((Enabled(name), *others)), names, budget, is_shortest=False)
    if way.trace is None:
        return way
    return replace(way, trace=ending_with_one_of(net, way.trace, names.transitions(name.text)))


def _up_to_fault(net: CompiledNet, formula: Formula, names: Names, answer: Outcome) -> Outcome:
    """End a counterexample where it violates the formula regardless of its continuation."""
    if answer.status != "violated":
        return answer
    firings = (*answer.stem, *answer.loop)
    length = faulty_beginning(net, formula, names, firings)
    if length is None:
        return answer
    return replace(answer, trace=firings[:length], loop=(), ends_at_fault=True)


def verify_branching(
    net: CompiledNet,
    formula: str | Formula,
    names: Names,
    budget: Budget = UNLIMITED,
    orders: OrderCache | None = None,
) -> Outcome:
    """Decide whether the initial marking satisfies a CTL formula: each ``AG p`` and ``EF p`` as a goal.

    Parameters and results are those of `check_ctl`.

    Raises
    ------
    FormulaError
        It is not a formula, or has an unknown name.
    """
    from dineros.analysis.portfolio.branching_time import check_ctl

    budget = budget.begun()
    tree = parse(formula, "ctl") if isinstance(formula, str) else formula
    parts = tree.operands if isinstance(tree, And) else (tree,)
    goals = [part for part in parts if goal_of(part) is not None]
    others = tuple(part for part in parts if goal_of(part) is None)
    if not goals:
        return check_ctl(net, tree, names, budget, orders=orders)
    near = NEAR_STATES if budget.states is None else min(NEAR_STATES, budget.states)
    answer = check_ctl(net, tree, names, budget.share(most_states=near), engine="explicit")
    if answer.status != "unknown" or budget.is_over:
        return answer

    def ask_others(share: Budget) -> Outcome:
        rest = others[0] if len(others) == 1 else And(others)
        return check_ctl(net, rest, names, share, orders=orders)

    def ask_goal(part: Formula, share: Budget) -> Outcome:
        goal = goal_of(part)
        assert goal is not None
        condition, value_if_met = goal
        way = find_marking(net, condition, names, share, is_shortest=False)
        if way.status == "unknown":
            return way
        is_met = way.trace is not None
        status = "holds" if is_met == value_if_met else "violated"
        return replace(way, status=status, reason=f"shows EF {condition}" if is_met else "")

    asked = [partial(ask_goal, part) for part in goals]
    return _all_of([*asked, *([ask_others] if others else [])], budget)


def _all_of(asked: Sequence[Callable[[Budget], Outcome]], budget: Budget) -> Outcome:
    """Return the answer to a conjunction: a violation, else an unknown answer, else the last answer."""
    answers: list[Outcome] = []
    for ask, share in fairly(asked, budget):
        answers.append(ask(share))
        if answers[-1].status == "violated" or budget.is_over:
            break
    worst = min(answers, key=lambda answer: ["violated", "unknown", "holds"].index(answer.status))
    if len(answers) < len(asked) and worst.status == "holds":
        return Outcome("unknown", seconds=budget.spent, reason="time ran out")
    by = ", ".join(dict.fromkeys(answer.by for answer in answers if answer.by))
    states = [answer.states for answer in answers if answer.states is not None]
    if worst.status != "holds" or len(asked) == 1:
        return replace(worst, seconds=budget.spent)
    return replace(worst, seconds=budget.spent, by=by, states=max(states, default=None))


def _on_the_fly(
    net: CompiledNet,
    formula: Formula,
    names: Names,
    weak: tuple[str, ...],
    strong: tuple[str, ...],
    budget: Budget,
    earlier: EarlierSearches | None,
) -> Outcome:
    """Search the product with an automaton, without environment-controlled places."""
    bound, strongly = BoundAtoms(net, formula, names), all_resolved(names, strong)
    weakly = [t for t in all_resolved(names, weak) if t not in strongly]
    smaller = without_free_parts(net, formula, bound, names, weakly, strongly)
    if smaller is None:
        return verify_ltl(net, formula, names, weak, strong, budget, earlier)
    answer = verify_ltl(smaller.net, formula, smaller.names, smaller.weak, smaller.strong, budget, earlier)
    if answer.status != "violated":
        return answer
    lasso = smaller.lift(answer.stem, answer.loop)
    if lasso is not None:
        with suppress(ReplayError):
            check_counterexample(net, formula, bound, *lasso, weakly, strongly)
            return replace(answer, trace=lasso[0], loop=lasso[1])
    return verify_ltl(net, formula, names, weak, strong, budget)
