"""Whether a marking can be reached: ``find``, ``EF`` and ``AG`` of CTL, ``G`` of LTL (paper, Alg. 5)."""

from __future__ import annotations

from dataclasses import replace

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.explicit import Order
from dineros.analysis.explicit.goals import Goal
from dineros.analysis.logic.language.names import Names, NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.rewriting import simplified
from dineros.analysis.logic.language.syntax import (
    TEMPORAL,
    TRUE,
    Enabled,
    Exists,
    Fired,
    ForAll,
    Formula,
    Name,
    Not,
)
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import ending_with_one_of, replay
from dineros.analysis.portfolio.plans import FIND, FIRE, NEAR, NEAR_STATES, PROVE
from dineros.analysis.portfolio.reach import Reach
from dineros.analysis.portfolio.scheduler import Plan, answered
from dineros.analysis.witnesses.folding import in_rounds


def find_enabled(
    net: CompiledNet,
    name: str,
    names: Names,
    budget: Budget = UNLIMITED,
    order: Order = "breadth-first",
    is_shortest: bool = True,
) -> Outcome:
    """Find a trace that ends with a transition; if several have the name, with the nearest one.

    A longer trace may be found under the conditions of `find_marking`.

    Raises
    ------
    FormulaError
        No transition has the name.
    """
    transitions = names.transitions(name)
    goals = (Goal.enabled(net, *transitions),)
    answer = _found(net, Enabled(Name(name)), names, budget, order, is_shortest, goals)
    if answer.trace is None:
        return answer
    return replace(answer, trace=ending_with_one_of(net, answer.trace, transitions))


def find_marking(
    net: CompiledNet,
    condition: str | Formula,
    names: Names,
    budget: Budget = UNLIMITED,
    order: Order = "breadth-first",
    is_shortest: bool = True,
) -> Outcome:
    """Find a trace to a marking that fulfils a condition, a shortest one if the search goes breadth first.

    It may be longer if only the reduced net, or a decision diagram, is small enough, or if `is_shortest` is
    false: then the first trace found by any method is returned.

    Raises
    ------
    FormulaError
        It is not a condition on markings, or has an unknown name.
    """
    tree = parse(condition, "state") if isinstance(condition, str) else condition
    return _found(net, tree, names, budget, order, is_shortest)


def find_firing(net: CompiledNet, transition: int, budget: Budget = UNLIMITED, plan: Plan = FIRE) -> Outcome:
    """Find a trace that ends with a transition, by a plan: a shortest one, if the plan requires it."""
    name = net.transitions[transition]
    goals = (Goal.enabled(net, transition),)
    question = Reach(net, Enabled(Name(name)), NetNames(net), is_shortest=True, own_goals=goals)
    answer = answered(question, plan, budget)
    return answer if answer.trace is None else replace(answer, trace=(*answer.trace, transition))


def _found(
    net: CompiledNet,
    condition: Formula,
    names: Names,
    budget: Budget,
    order: Order,
    is_shortest: bool,
    goals: tuple[Goal, ...] | None = None,
) -> Outcome:
    is_shortest = is_shortest and order == "breadth-first"
    question = Reach(net, condition, names, order, is_shortest, goals)
    is_near = budget.states is not None and budget.states <= NEAR_STATES
    answer = answered(question, NEAR if is_near else FIND, budget)
    return answer if answer.trace is None else replace(answer, trace=_in_rounds(question, answer.trace))


def _in_rounds(question: Reach, trace: tuple[int, ...]) -> tuple[int, ...]:
    """Order a trace so that rounds repeat; it ends at the first marking that fulfils the condition."""
    ordered = in_rounds(question.net, trace)
    if ordered == trace:
        return trace
    markings = replay(question.net, ordered)
    return ordered[: next(number for number, marking in enumerate(markings) if question.holds(marking))]


def proof_against(net: CompiledNet, condition: Formula, names: Names, budget: Budget) -> Outcome | None:
    """Prove without a state space that no reachable marking fulfils a condition; None if that fails.

    Parameters
    ----------
    condition : Formula
        On markings; a `fired(t)` atom is over-approximated by `enabled(t)`.

    Raises
    ------
    FormulaError
        The condition has an unknown name.
    """
    if any(isinstance(part, (*TEMPORAL, ForAll, Exists)) for part in condition.subformulas()):
        return None
    answer = answered(Reach(net, _without_steps(condition), names), PROVE, budget)
    return answer if answer.status == "unreachable" else None


def _without_steps(condition: Formula) -> Formula:
    """Replace the atoms on steps in a condition: `fired` becomes `enabled`."""

    def weaker(part: Formula) -> Formula | None:
        match part:
            case Fired(name):
                return Enabled(name)
            case Not(Fired()):
                return TRUE
        return None

    return simplified(condition).replaced(weaker)
