"""A check with times of a net in which nothing ever has to fire: no interval has a latest bound.

Such a net can do with its times what it can do without, so the engines for nets without times answer. Only
stored properties are asked with times: they may bound one, and with times a run may stay where it is.
"""

from __future__ import annotations

from dineros.analysis.answers.budget import Budget
from dineros.analysis.checks.check import CHEAP, QUESTIONS, ask_all
from dineros.analysis.checks.properties import Properties
from dineros.analysis.checks.question import Checked
from dineros.analysis.model.subject import Subject
from dineros.analysis.symbolic.order_cache import OrderCache
from dineros.analysis.timed.timed_subject import ScheduledSubject, TimedSubject
from dineros.analysis.witnesses.findings import Report
from dineros.metamodel import pn

BY = "no interval has a latest bound, so each run without times is also a run with times"


class TimedProperties(Properties):
    """Stored properties, asked with times in a check without them.

    `timed`: the model and net of the questions.
    """

    def __init__(self, timed: TimedSubject) -> None:
        self._timed = timed

    def _subject(self, checked: Checked) -> Subject:
        return self._timed


def ask_unforced(
    model: pn.Net,
    timed: TimedSubject,
    unforced: ScheduledSubject,
    report: Report,
    budget: Budget,
    orders: OrderCache | None,
) -> None:
    """Ask all questions of a check; see `unforced_subject` for what is asked."""
    checked = Checked(model, report, budget.begun(), CHEAP, orders)
    checked.subject = unforced
    ask_all(checked, [TimedProperties(timed) if type(each) is Properties else each for each in QUESTIONS])
    report.by = f"{report.by}; {BY}" if report.by else BY
