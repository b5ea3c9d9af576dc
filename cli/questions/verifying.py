"""``dineros verify``: a formula, or a property that the model stores."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dineros.cli.analysing import HOLDS, STATUSES, UNKNOWN, VIOLATED, load_valid, reading_formula
from dineros.cli.models import rules_of
from dineros.cli.presentation.answers import say_needed_fairness, say_unfairness, say_verdict
from dineros.cli.questions.asking import Asking, run_shown
from dineros.cli.questions.property_files import write_formula
from dineros.cli.searching import search

if TYPE_CHECKING:
    from dineros.analysis.answers.outcome import Outcome
    from dineros.analysis.questions.needed_fairness import NeededFairness
    from dineros.analysis.questions.net_questions import Question
    from dineros.analysis.symbolic.order_cache import OrderCache
    from dineros.analysis.witnesses.witness import Witness
    from dineros.metamodel import sym


def verify_formula(
    asking: Asking,
    logic: str,
    formula: str,
    written: Path | None,
    *,
    weak: tuple[str, ...] = (),
    strong: tuple[str, ...] = (),
    orders: OrderCache | None = None,
) -> int:
    """Decide a formula, or write it as a property file instead; return the exit status.

    Parameters
    ----------
    logic, formula : str
        ``ltl`` or ``ctl``, and the formula.
    weak, strong : tuple of str
        What is fair, in linear time.
    """
    from dineros.analysis.model.fairness import fair_transitions, unfairness
    from dineros.analysis.questions.needed_fairness import needed_fairness
    from dineros.analysis.questions.net_questions import Branching, Linear

    run = search()
    first: dict[str, object] = {}

    def say(verdict: Outcome, needed: NeededFairness | None = None) -> int:
        witness = unfair = None
        if verdict.stem or verdict.loop:  # only then is the net known for sure
            witness = run_shown(subject, verdict)
            if verdict.status == "violated" and verdict.loop and logic == "ltl":
                unfair = unfairness(subject, verdict.stem, verdict.loop)

        def say_text() -> None:
            say_verdict(verdict, formula, witness, asking.model, asking.output, is_linear=logic == "ltl")
            if unfair is not None and asking.output is None:
                say_unfairness(unfair, subject.net.transitions)
            if needed is not None and asking.output is None:
                say_needed_fairness(needed)

        named = unfair.to_dict(subject.net.transitions) if unfair else None
        more: dict[str, Any] = {} if needed is None else {"holds_if_fair": needed.to_dict()}
        told = {**first, "formula": formula}
        of_all = _is_of_all_runs(logic, formula, verdict.status)
        more["is_shown_by_run"] = _is_shown_by_run(logic, formula, verdict)
        asking.tell(verdict, witness, formula, say_text, told, is_universal=of_all, unfair=named, **more)
        return STATUSES[verdict.status]

    run.draft(lambda ending: say(run.unknown(ending)))
    subject = asking.subject()
    first.update(rules_of(subject.model))
    if written is not None:
        with run.answer(), reading_formula(f"--{logic}"):
            return write_formula(subject, asking.model, logic, formula, written)
    with reading_formula("--fair"):
        weak = fair_transitions(subject, weak)
    with reading_formula("--strongly-fair"):
        strong = fair_transitions(subject, strong)
    question: Question
    if logic == "ltl":
        question = Linear(subject.net, subject.names, formula, weak, strong)
    else:
        question = Branching(subject.net, subject.names, formula, orders)
    with reading_formula(f"--{logic}"):
        verdict = asking.answer(subject, logic, formula, question, weak=weak, strong=strong)
    needed = None
    if isinstance(question, Linear):
        run.draft(lambda _: say(verdict))
        run.stage("which fairness would prove it")
        needed = needed_fairness(subject, question, verdict, run.budget())
    with run.answer():
        return say(verdict, needed)


def verify_stored(asking: Asking, name: str, orders: OrderCache | None) -> int:
    """Decide a property that a model stores; the exit status shows whether the answer is as expected."""
    from dineros.analysis.evidence.certificate import BASE
    from dineros.analysis.questions.net_questions import Linear
    from dineros.analysis.requirements.latency_bounds import latency_bound
    from dineros.analysis.requirements.stored import VARIANTS, asked, property_named

    run = search()
    net = load_valid(asking.model, asking.settings)
    if not asking.timed:
        asking.leave_out_times(net)
    with reading_formula(str(asking.model)):
        property = property_named(net, name)
    if latency_bound(property) is not None:
        return _verify_latency(asking, property, rules_of(net))
    with reading_formula(f"property {property.id}"):
        stored = asked(property, overflow=asking.overflow, is_timed=asking.timed)  # type: ignore[arg-type]
    reading, formula = stored.reading, str(stored.reading.formula)
    first = {
        **rules_of(net),
        "property": str(property.id),
        "text": str(property.text),
        "formula": formula,
        "expected": bool(property.expected),
    }

    def say(verdict: Outcome) -> int:
        witness = run_shown(stored.subject, verdict)
        answered = {"holds": "violated", "violated": "holds"} if reading.is_negated else {}
        status = answered.get(verdict.status, verdict.status)
        return _tell_stored(
            asking,
            property,
            verdict,
            witness,
            first,
            is_linear=reading.logic == "ltl" and not reading.is_negated,
            is_universal=_is_of_all_runs(reading.logic, formula, status),
            is_shown_by_run=_is_shown_by_run(reading.logic, formula, replace(verdict, status=status)),
        )

    run.draft(lambda ending: say(run.unknown(ending)))
    more: dict[str, Any] = {"weak": stored.weak, "strong": stored.strong}
    signals: str = VARIANTS[str(property.signals)]
    question = stored.question(orders)
    if asking.timed:
        asking.refuse_tina_on_workers()
        more = {"ask": partial(stored.outcome, orders=orders)}
        signals = BASE if signals == "none" else signals
        if isinstance(question, Linear):
            question = replace(question, weak=(), strong=())  # it is decided for all runs
    verdict = asking.answer(stored.subject, reading.logic, formula, question, signals=signals, **more)
    with run.answer():
        return say(stored.verdict(verdict))


def _verify_latency(asking: Asking, property: sym.Property, rules: Mapping[str, object]) -> int:
    """Decide a property that bounds a latency; the exit status shows whether the answer is as expected."""
    from dineros.analysis.requirements.asking import question_of

    run = search()
    about = {"property": str(property.id), "text": str(property.text), "expected": bool(property.expected)}

    def say(verdict: Outcome) -> int:
        witness = run_shown(stored.subject, verdict) if verdict.stem else None
        first, is_universal = {**rules, **about}, verdict.status == "holds"
        return _tell_stored(
            asking, property, verdict, witness, first, is_linear=False, is_universal=is_universal
        )

    run.draft(lambda ending: say(run.unknown(ending)))
    asking.refuse_tina_on_workers()
    run.stage("measuring times")
    with reading_formula(f"property {property.id}"):
        stored = question_of(property, overflow=asking.overflow, is_timed=asking.timed)  # type: ignore[arg-type]
        answer = stored.answer(run.budget())
    verdict = replace(answer, reason=run.reason(answer.reason))
    if asking.confirm:
        from dineros.analysis.evidence.confirmation import Confirmation

        asking.confirmation = Confirmation(None, reason="only one engine decides latencies")
    with run.answer():
        return say(verdict)


def _tell_stored(
    asking: Asking,
    property: sym.Property,
    verdict: Outcome,
    witness: Witness | None,
    first: Mapping[str, object],
    *,
    is_linear: bool,
    is_universal: bool,
    is_shown_by_run: bool = False,
) -> int:
    """Print the answer to a stored property; return the exit status: whether it is as expected."""
    is_expected, text = bool(property.expected), str(property.text)
    line = f"{property.id}: {text}{'' if is_expected else '; expected not to hold'}"
    say = partial(say_verdict, verdict, line, witness, asking.model, asking.output, is_linear=is_linear)
    asking.tell(
        verdict, witness, text, say, first, is_universal=is_universal, is_shown_by_run=is_shown_by_run
    )
    if verdict.status == "unknown":
        return UNKNOWN
    return HOLDS if (verdict.status == "holds") == is_expected else VIOLATED


def _is_of_all_runs(logic: str, formula: str, status: str) -> bool:
    """Return whether a verdict still holds if the net has fewer runs."""
    from dineros.analysis.logic.language.parser import parse
    from dineros.analysis.model.times import is_of_all_runs

    if logic == "ltl" or status == "unknown":
        return status == "holds"
    return is_of_all_runs(parse(formula, "ctl"), status == "holds")


def _is_shown_by_run(logic: str, formula: str, verdict: Outcome) -> bool:
    """Return whether a verdict still holds if the net has more runs; not if a run ends in a deadlock."""
    from dineros.analysis.logic.language.bounded import bounds_times
    from dineros.analysis.logic.language.parser import parse
    from dineros.analysis.logic.language.syntax import Deadlock
    from dineros.analysis.model.times import is_of_all_runs

    if verdict.status == "unknown" or bounds_times(formula):
        return False  # not asked of windows: the safe answer
    tree = parse(formula, "ltl" if logic == "ltl" else "ctl")
    if any(isinstance(part, Deadlock) for part in tree.subformulas()):
        return False
    if logic == "ltl":
        return verdict.status == "violated" and bool(verdict.loop or verdict.ends_at_fault)
    return is_of_all_runs(tree, verdict.status != "holds")
