"""Confirms the results of a check with times: by time as a counter, or by strong state classes.

The markings, firings and final markings of the check are compared with all those that the other engine finds.
Callbacks that wait forever, and each stored property whose answer depends on all state classes, are decided
again, too.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from dineros.analysis.answers.budget import RAN_OUT, UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.stages import Share
from dineros.analysis.evidence.confirmation import ONE_ENGINE, Confirmation, rests_on_markings
from dineros.analysis.evidence.timed_confirmation import COUNTED, STRONG, confirm_timed_answer
from dineros.analysis.logic.graphs.predicates import MarkingMatrix
from dineros.analysis.nets.compiled import Int64Array
from dineros.analysis.questions.net_questions import Linear
from dineros.analysis.requirements.stored import Asked
from dineros.analysis.timed.graph import timed_graph
from dineros.analysis.timed.integers.counting import all_markings
from dineros.analysis.timed.integers.net import integer_net
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.search import ClassSearch
from dineros.analysis.timed.timed_subject import TimedSubject
from dineros.analysis.timed_checks.callbacks import waits_of
from dineros.analysis.timed_checks.timed_checked import TimedChecked
from dineros.analysis.witnesses.findings import Report
from dineros.metamodel.elements import label
from dineros.metamodel.errors import DinerosError

MARKINGS, FIRINGS, ENDS = (
    "which markings are reached",
    "which transitions fire",
    "in which markings the net ends",
)
CALLBACKS = "which callbacks wait forever"

COUNTING = Share(time=0.3)
"""Share of the time for counted time; after it, strong classes are used."""


@dataclass(frozen=True)
class Behaviour:
    """The behaviour of a net with times, as found by one engine.

    Attributes
    ----------
    markings : int64 array, shape (markings, places)
        The markings, sorted.
    """

    by: str
    markings: Int64Array
    firings: frozenset[int]

    def ends(self, net: TimedNet) -> Int64Array:
        """Return the markings that enable nothing, in which the net ends, unless priorities are cyclic."""
        return self.markings[MarkingMatrix(net.untimed, self.markings).deadlocks()]


def confirm_timed_check(checked: TimedChecked, budget: Budget = UNLIMITED) -> dict[str, Confirmation]:
    """Confirm the results of a check with times.

    Returns
    -------
    dict
        For each question, as text, the other engine's result. Questions answered by a run are left out.
    """
    budget = budget.begun()
    told: dict[str, Confirmation] = {}
    if checked.explored.is_complete:
        told |= _compared(checked, budget)
    if checked.waits:
        told[CALLBACKS] = _again_callbacks(checked, budget)
    told.update(_again_properties(checked, budget))
    return told


def add_confirmations(report: Report, told: dict[str, Confirmation]) -> None:
    """Add confirmations to a report. After a disagreement, nothing counts as proved."""
    disputed = [what for what, one in told.items() if one.agrees is False]
    if disputed:
        why = f"engines disagree about {', '.join(disputed)}"
        report.unknown += [Outcome.left_open(f"whether this holds: {text}", why) for text in report.proved]
        report.proved.clear()
    for what, one in told.items():
        if one.agrees:
            report.proved.append(f"{what}: {one}")
        else:
            report.unknown.append(Outcome.left_open(what, str(one), may_be_fault=one.agrees is False))


def _compared(checked: TimedChecked, budget: Budget) -> dict[str, Confirmation]:
    """Compare markings, firings and final markings."""
    net, explored = checked.timed.timed, checked.explored
    budget.stage("confirming the markings")
    began = time.perf_counter()
    try:
        other = behaviour(net, budget)
    except BudgetExceededError as limit:
        reason = RAN_OUT.get(str(limit), str(limit))
        return dict.fromkeys((MARKINGS, FIRINGS, ENDS), Confirmation(None, reason=reason))
    by = f"{other.by} ({time.perf_counter() - began:.1f} s)"
    markings = np.unique(explored.markings, axis=0)
    ends = np.unique(explored.markings[[row for row, _ in explored.ends]], axis=0)
    names, firings = net.untimed.transitions, frozenset(explored.ways)
    only = sorted(names[t] for t in firings ^ other.firings)
    differences = {
        MARKINGS: _difference(markings, other.markings, by),
        FIRINGS: f"only one of state classes and {by} lets these fire: {', '.join(only)}" if only else "",
        ENDS: _difference(ends, other.ends(net), by),
    }
    told = {what: Confirmation(not wrong, (by,), wrong) for what, wrong in differences.items()}
    if any(t in above for t, above in enumerate(net.above)):
        told[ENDS] = Confirmation(
            None, reason="priorities in a circle also end the net, which only one engine supports"
        )
    return told


def _difference(ours: Int64Array, theirs: Int64Array, by: str) -> str:
    """Describe the difference of two sorted sets of markings; empty if they are equal."""
    if np.array_equal(ours, theirs):
        return ""
    return f"state classes find {len(ours)} markings, {by} {len(theirs)}, and not the same ones"


def behaviour(net: TimedNet, budget: Budget) -> Behaviour:
    """Explore with counted time, or with strong classes if the intervals or the budget do not allow it.

    Raises
    ------
    BudgetExceededError
        No other engine supports the net, or a limit was exceeded.
    """
    budget = budget.begun()
    try:
        made = integer_net(net)
        found = all_markings(made, net.untimed.places, COUNTING.share(budget))
        return Behaviour(COUNTED, *found)
    except (DinerosError, BudgetExceededError):
        if net.has_priorities:
            raise BudgetExceededError(ONE_ENGINE) from None
    search = ClassSearch(net, "E", budget, keeps_edges=True)
    search.run()
    if search.reason is not None:
        raise BudgetExceededError(search.reason)
    return Behaviour(STRONG, np.unique(search.markings(), axis=0), frozenset(search.first_sources()))


def _again_callbacks(checked: TimedChecked, budget: Budget) -> Confirmation:
    """Find the callbacks that wait forever by strong classes."""
    net = checked.timed.timed
    if net.has_priorities:
        return Confirmation(None, reason=ONE_ENGINE)
    budget.stage("confirming the waits of callbacks")
    began = time.perf_counter()
    try:
        graph = timed_graph(net, "S", budget)
    except BudgetExceededError as limit:
        return Confirmation(None, reason=RAN_OUT.get(str(limit), str(limit)))
    again = waits_of(graph, list(checked.waiting.callbacks.values()))
    by = f"{STRONG} ({time.perf_counter() - began:.1f} s)"
    wrong = "" if again == checked.waits else f"{by} disagree"
    return Confirmation(not wrong, (by,), wrong)


def _again_properties(checked: TimedChecked, budget: Budget) -> Iterator[tuple[str, Confirmation]]:
    """Decide again each stored property that no run answers."""
    for property, question, outcome in checked.answered:
        if not rests_on_markings(outcome):
            continue
        what = f"property {label(property)}"
        budget.stage(f"confirming {what}")
        if not isinstance(question, Asked) or not isinstance(question.subject, TimedSubject):
            yield what, Confirmation(None, reason=ONE_ENGINE)
            continue
        asked = question.question()
        if isinstance(asked, Linear):
            asked = replace(asked, weak=(), strong=())  # it was decided for all runs
        raw = question.verdict(outcome)  # the double negation gives the answer to the question
        yield what, confirm_timed_answer(question.subject.timed, asked, raw, budget)
