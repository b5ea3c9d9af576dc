"""Every question with a yes/no answer that can be asked of any model (paper, Sect. 7).

Cheap questions come first: the properties of the model, each for a while, and the growth of tokens. The
properties that are left are asked again as soon as all markings are there. The complete state space of the
net without signals answers most other questions at once; a witness is then searched breadth first, so that it
is a shortest one. If the space is expensive, what a short search and walks find is reported first, and a
smaller net may answer instead; if it is infinite, the search answers what it can.
"""

from __future__ import annotations

from collections.abc import Sequence

from dineros.analysis.acceptance import suppressions
from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.checks.blocking import Callbacks, Deadlock
from dineros.analysis.checks.boundedness import Boundedness, Places
from dineros.analysis.checks.clauses import Clauses
from dineros.analysis.checks.goals import Goals, qualify
from dineros.analysis.checks.matching import Matching
from dineros.analysis.checks.overflow import Overflow, Presence
from dineros.analysis.checks.properties import Properties
from dineros.analysis.checks.question import Checked, Question
from dineros.analysis.checks.repetition import Repetition
from dineros.analysis.checks.unused import Use
from dineros.analysis.symbolic.order_cache import OrderCache
from dineros.analysis.witnesses.findings import Report
from dineros.metamodel import pn

CHEAP = 1_500_000
"""Cache misses of saturation, about half a second, that liveness and the like may cost by default."""


def check(
    model: pn.Net,
    budget: Budget = UNLIMITED,
    report: Report | None = None,
    at_any_cost: bool = False,
    orders: OrderCache | None = None,
    questions: Sequence[Question] | None = None,
    is_shown: bool = True,
) -> Report:
    """Ask everything that can be asked of any model.

    Parameters
    ----------
    model : pn.Net
        A system model, or any place/transition net.
    budget : Budget, optional
        What it may cost; running out of time or memory leaves questions unknown.
    report : Report, optional
        Where to put the answers as they come, for those who want them after an interruption.
    at_any_cost : bool
        Whether to decide liveness, reversibility and home markings also where that takes long.
    orders : OrderCache, optional
        Where orders of levels are kept for the symbolic engine.
    questions : sequence of Question, optional
        Which ones, in their order, `Boundedness` among them; all by default.
    is_shown : bool
        Whether runs are searched that show what is found.
    """
    report = Report() if report is None else report
    work = None if at_any_cost else CHEAP
    checked = Checked(model, report, budget.begun(), work, orders, is_shown)
    ask_all(checked, QUESTIONS if questions is None else questions)
    return report


def ask_all(checked: Checked, asked: Sequence[Question]) -> None:
    """Ask questions in their order, after what each of them can answer at little cost."""
    for question in asked:
        with checked.guarded(None):
            question.ask_first(checked)
    for question in asked:
        checked.ask(question)
        if isinstance(question, Boundedness) and checked.report.space is not None:
            for other in asked:
                with checked.guarded(None):
                    other.ask_with_space(checked)
    qualify(checked)


QUESTIONS: tuple[Question, ...] = (
    Clauses(),
    Matching(),
    Boundedness(),
    Overflow(),
    Presence(),
    Use(),
    Deadlock(),
    Callbacks(),
    Goals(),
    Repetition(),
    Places(),
    Properties(),
)
"""All questions, in the order they are asked."""

FAULTS = {
    fault.rule: fault
    for faults in (*(question.faults for question in QUESTIONS), suppressions.FAULTS)
    for fault in faults
}
"""All that a check may find, by its rule."""
