"""``dineros find``: finds a firing sequence to a goal (paper, Alg. 5)."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import click

from dineros.cli.analysing import STATUSES, question_options, reading_formula, search_order_option
from dineros.cli.models import rules_of
from dineros.cli.options import flag, model_argument, value_option
from dineros.cli.presentation.answers import say_way
from dineros.cli.questions.asking import Asking
from dineros.cli.questions.timed import quickest_way, time_option
from dineros.cli.quick_start import start_quickly
from dineros.cli.searching import search
from dineros.cli.supervising import search_command

if TYPE_CHECKING:
    from dineros.analysis.answers.outcome import Outcome
    from dineros.analysis.explicit import Order


@search_command(
    "dineros find sorting.sym.xmi --enabled TShowResult",
    "dineros find sorting.sym.xmi --signals none --marking 'Shown >= 1 & StateGet >= 1'",
    "dineros find race.net --time --marking 'a >= 1'",
    "dineros find race.net --time --quickest --enabled fast",
)
@model_argument()
@value_option("--enabled TRANSITION", "Find a marking that enables a transition.")
@value_option("--marking EXPR", "Find a marking with a property, such as 'Shown >= 2'.")
@search_order_option(
    "Breadth first finds a shortest firing sequence; depth first often finds a long one sooner."
)
@time_option("Take firing intervals into account; the firing sequence has a schedule.")
@flag("--quickest", "With --time: the firing sequence that takes the least time.")
@question_options
def find(enabled: str | None, marking: str | None, order: Order, quickest: bool, **options: Any) -> int:
    """Find a firing sequence to a marking: a shortest one, unless searched depth first or on a reduced net.

    With --engine tina, TINA's programs sift and pathto find the sequence, which may be longer; it is
    replayed. Exit status 0: found; 1: proved unreachable; 3: unknown.
    """
    start_quickly(options["model"])
    from dineros.analysis.questions.net_questions import Enabled, Marking, Question
    from dineros.analysis.witnesses.witness import witness_of

    if (enabled is None) == (marking is None):
        raise click.UsageError("give either --enabled or --marking")
    asking, run = Asking(**options), search()
    if quickest and not asking.timed:
        raise click.UsageError("--quickest requires --time")
    if quickest and (asking.certificate is not None or asking.confirm):
        raise click.UsageError("--quickest cannot be combined with --certificate or --confirm")
    asking.refuse_tina_on_workers()
    goal = f"enabled({enabled})" if enabled is not None else str(marking)
    first: dict[str, object] = {}
    last: dict[str, Any] = {}

    def say(answer: Outcome) -> int:
        witness = witness_of(subject, answer.trace) if answer.trace is not None else None
        shown = partial(say_way, answer, goal, witness, asking.model, asking.output)
        told = {**first, "goal": goal}
        never = answer.status == "unreachable"
        last["is_shown_by_run"] = not never and "deadlock" not in goal
        asking.tell(answer, witness, goal, shown, told, is_universal=never, is_timed=False, **last)
        return STATUSES[answer.status]

    run.draft(lambda ending: say(run.unknown(ending)))
    subject = asking.subject()
    first.update(rules_of(subject.model))
    question: Question
    if enabled is not None:
        kind, text, question = "enabled", enabled, Enabled(subject.net, subject.names, enabled, order)
    else:
        kind, text, question = "marking", goal, Marking(subject.net, subject.names, goal, order)
    if quickest:
        with reading_formula(f"--{kind}"):
            answer, last["quickest"] = quickest_way(subject, kind, text)
        with run.answer():
            return say(answer)
    with reading_formula(f"--{kind}"):
        answer = asking.answer(subject, kind, text, question, order=order)
    with run.answer():
        return say(answer)
