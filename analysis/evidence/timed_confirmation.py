"""Confirms answers about nets with times: by time as a counter, or by another kind of state classes.

A question about markings is asked of the net in which time is counted, which shares nothing with state
classes but the net. It knows closed intervals without priorities only. Otherwise, and for questions about
runs, strong classes answer where linear ones did: the matrices are computed by the same code, but the
classes are others.

CTL has one engine, unless a formula says something of all markings only. Whole units of time do not keep
what can come next: it may depend on whether something happened between two units.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from dineros.analysis.answers.budget import UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.evidence.confirmation import ONE_ENGINE, Confirmation
from dineros.analysis.logic.language.atoms import BoundAtoms, as_comparisons
from dineros.analysis.logic.language.bounded import read_bounded
from dineros.analysis.logic.language.names import Names, NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.syntax import (
    And,
    Comparison,
    Exists,
    Finally,
    ForAll,
    Formula,
    Globally,
    Name,
    Not,
)
from dineros.analysis.questions import net_questions
from dineros.analysis.timed.durations.bounded_response import decide_bounded
from dineros.analysis.timed.goals import find_timed, find_timed_firing
from dineros.analysis.timed.integers.net import IntegerNet, integer_net
from dineros.analysis.timed.linear_time import is_condition, verify_timed_ltl
from dineros.analysis.timed.nets import TimedNet
from dineros.metamodel.errors import DinerosError

COUNTED = "time as a counter"
STRONG = "strong state classes"
ONLY_ATOMIC = "only atomic classes determine the next steps; integer time and other classes do not"


def confirm_timed_answer(
    net: TimedNet, question: net_questions.Question, answer: Outcome, budget: Budget = UNLIMITED
) -> Confirmation:
    """Confirm an answer that depends on all state classes.

    Parameters
    ----------
    question, answer
        The question, and the answer: ``unreachable`` or ``holds``.
    """
    budget = budget.begun()
    match question:
        case net_questions.Marking(_, names, condition):
            return _confirm_marking(net, parse(condition, "state"), names, answer, budget)
        case net_questions.Branching(_, names, formula):
            return _confirm_branching(net, parse(formula, "ctl"), names, answer, budget)
        case net_questions.Linear(_, names, formula, (), ()):
            bounded = read_bounded(formula)
            if bounded is not None:
                return _by_strong(net, answer, lambda: decide_bounded(net, bounded, names, budget, "S"))
            tree = parse(formula)
            if isinstance(tree, Globally) and is_condition(tree.operand):
                return _confirm_marking(net, Not(tree.operand), names, answer, budget)
            return _by_strong(net, answer, lambda: verify_timed_ltl(net, formula, names, budget, "S"))
        case net_questions.Enabled(_, names, name):
            return _by_strong(net, answer, lambda: find_timed_firing(net, name, names, budget, "S"))
    return Confirmation(None, reason=ONE_ENGINE)


def _confirm_branching(
    net: TimedNet, tree: Formula, names: Names, answer: Outcome, budget: Budget
) -> Confirmation:
    """Ask again what a CTL formula states about all markings."""
    match tree:
        case ForAll(Globally(condition)) if is_condition(condition):
            return _confirm_marking(net, Not(condition), names, answer, budget)
        case Exists(Finally(condition)) if is_condition(condition):
            status = "unreachable" if answer.status == "violated" else "reachable"
            return _confirm_marking(net, condition, names, replace(answer, status=status), budget)
    return Confirmation(None, reason=ONLY_ATOMIC)


def _confirm_marking(
    net: TimedNet, condition: Formula, names: Names, answer: Outcome, budget: Budget
) -> Confirmation:
    """Search the net that counts time for a marking, or use strong classes if it is not suitable."""
    try:
        made = integer_net(net)
    except DinerosError:
        made = None
    counted = None if made is None else _in_counted_time(net, made, condition, names)
    if made is None or counted is None:
        return _by_strong(net, answer, lambda: find_timed(net, condition, names, budget, kind="S"))
    from dineros.analysis.portfolio.asking import find_marking

    found = find_marking(made.net, counted, NetNames(made.net), budget, is_shortest=False)
    return _compared(answer, found, COUNTED)


def _by_strong(net: TimedNet, answer: Outcome, ask: Callable[[], Outcome]) -> Confirmation:
    if net.has_priorities:  # strong classes have given the answer already
        return Confirmation(None, reason=ONE_ENGINE)
    try:
        return _compared(answer, ask(), STRONG)
    except BudgetExceededError as limit:
        return Confirmation(None, reason=str(limit))


def _compared(answer: Outcome, other: Outcome, by: str) -> Confirmation:
    if other.status == "unknown":
        return Confirmation(None, reason=f"{by}: {other.reason}")
    same = {"unreachable": "holds", "reachable": "violated"}
    said = same.get(other.status, other.status)
    if said == same.get(answer.status, answer.status):
        return Confirmation(True, (f"{by} ({other.seconds:.1f} s)",))
    return Confirmation(False, (by,), f"state classes answer {answer.status}, {by}: {other.status}")


def _in_counted_time(net: TimedNet, made: IntegerNet, condition: Formula, names: Names) -> Formula | None:
    """Return the condition for the net that counts time; None: it is not only about tokens.

    A marking of that net corresponds to one of the timed net if its place `end` is marked.
    """
    plain = net.untimed
    conditions = BoundAtoms(plain, condition, names).conditions
    compared: dict[Formula, Formula | None] = {
        atom: as_comparisons(plain, one) for atom, one in conditions.items()
    }
    if None in compared.values():
        return None
    is_settled = Comparison(((1, Name(made.end)),), ">=", 1)
    return And((condition.replaced(compared.get), is_settled))
