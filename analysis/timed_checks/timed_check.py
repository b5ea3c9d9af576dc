"""Every question of a check that can be asked of a net with its firing intervals.

The largest state classes are built once. They contain all markings and all firings, so they answer what
queues lose, what never happens and where the net ends. Stored properties are asked one by one. What cannot be
decided with times stays unknown, with its reason.
"""

from __future__ import annotations

from collections.abc import Sequence

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.checks.check import check
from dineros.analysis.checks.clauses import Clauses
from dineros.analysis.checks.goals import Goals, qualify
from dineros.analysis.checks.matching import Matching
from dineros.analysis.checks.overflow import Overflow, Presence
from dineros.analysis.checks.properties import Properties
from dineros.analysis.checks.question import Question
from dineros.analysis.checks.unused import Use
from dineros.analysis.symbolic.order_cache import OrderCache
from dineros.analysis.timed.timed_subject import timed_base_subject, unforced_subject
from dineros.analysis.timed_checks.boundedness import TimedBoundedness, TimedPlaces
from dineros.analysis.timed_checks.callbacks import TimedCallbacks
from dineros.analysis.timed_checks.endings import TimedDeadlock
from dineros.analysis.timed_checks.faults_of_time import NeverInTime, TimeStops
from dineros.analysis.timed_checks.lost_ticks import LostTicks
from dineros.analysis.timed_checks.shown_by_runs import shown_by_runs
from dineros.analysis.timed_checks.timed_checked import TimedChecked
from dineros.analysis.timed_checks.unforced import ask_unforced
from dineros.analysis.witnesses.findings import Report
from dineros.metamodel import pn

TIMED_QUESTIONS: tuple[Question, ...] = (
    Clauses(),
    Matching(),
    TimedBoundedness(),
    Overflow(),
    Presence(),
    Use(),
    NeverInTime(),
    TimedDeadlock(),
    TimeStops(),
    TimedCallbacks(),
    LostTicks(),
    Goals(),
    TimedPlaces(),
    Properties(),
)
"""All questions, in the order they are asked."""


def check_timed(
    model: pn.Net, budget: Budget = UNLIMITED, questions: Sequence[Question] | None = None
) -> Report:
    """Ask everything that can be asked of a model with its firing intervals.

    A model without intervals is checked as `check` does.

    Parameters
    ----------
    model : pn.Net
        A system model, or any place/transition net.
    budget : Budget, optional
        What it may cost; running out of time or memory leaves questions unknown.
    questions : sequence of Question, optional
        Which ones, `TimedBoundedness` among them; all by default.

    Raises
    ------
    DinerosError
        An interval is empty or negative.
    """
    report = Report()
    ask_timed(model, report, budget, questions=questions)
    return report


def ask_timed(
    model: pn.Net,
    report: Report,
    budget: Budget = UNLIMITED,
    orders: OrderCache | None = None,
    questions: Sequence[Question] | None = None,
) -> TimedChecked | None:
    """Do what `check_timed` does, and return what became known of state classes; None without these.

    They are not built for a model without intervals and priorities, and for one in which nothing ever has
    to fire.

    Parameters
    ----------
    report : Report
        Where to put the answers as they come.
    orders : OrderCache, optional
        Where orders of levels are kept for the symbolic engine. It is asked if the model has no intervals, or
        if there are too many classes.
    """
    subject = timed_base_subject(model)
    if not subject.timed.has_times and not subject.timed.has_priorities:
        check(model, budget, report, orders=orders)
        return None
    report.times = subject.used_times
    unforced = unforced_subject(subject)
    if unforced is not None and questions is None:
        ask_unforced(model, subject, unforced, report, budget, orders)
        return None
    checked = TimedChecked(model, report, budget.begun(), None, orders)
    checked.subject = subject
    asked = TIMED_QUESTIONS if questions is None else questions
    for properties in (each for each in asked if isinstance(each, Properties)):
        properties.ask_bounds(checked)
    for question in asked:
        checked.ask(question)
        if isinstance(question, TimedBoundedness):
            _tell_of_runs(checked, asked)
    qualify(checked)
    return checked


def _tell_of_runs(checked: TimedChecked, asked: Sequence[Question]) -> None:
    """Answer the properties that random runs and the known firings decide, before what takes long."""
    if checked.firings is None or not checked.walked.runs:
        return
    runs = [*checked.walked.runs, *checked.firings.traces.values()]
    for properties in (each for each in asked if isinstance(each, Properties)):
        properties.tell(checked, lambda question: shown_by_runs(question, runs))
