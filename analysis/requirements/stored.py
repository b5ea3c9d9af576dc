"""The properties that a model stores, asked under its assumptions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.stages import Share
from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.bounded import Bounded, read_bounded
from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.syntax import (
    QUANTIFIERS,
    And,
    Exists,
    Finally,
    ForAll,
    Formula,
    Globally,
    Implies,
    Name,
    Next,
    Not,
    SignalTrue,
)
from dineros.analysis.model.fairness import fair_transitions
from dineros.analysis.model.subject import Subject, base_subject, subject_of
from dineros.analysis.questions.engines import ENGINES, Timed
from dineros.analysis.questions.net_questions import Branching, Linear, Question
from dineros.analysis.requirements.listing import properties_of
from dineros.analysis.requirements.patterns import Reading, read_pattern
from dineros.analysis.symbolic.order_cache import OrderCache
from dineros.analysis.timed.timed_subject import TimedSubject, timed_base_subject, timed_subject_of
from dineros.metamodel import pn, sym
from dineros.metamodel.elements import label
from dineros.metamodel.errors import DinerosError, near_matches

if TYPE_CHECKING:
    from dineros.transformations.rules.phases import OverflowVariant, SignalVariant

VARIANTS: dict[str, SignalVariant] = {
    "none": "none",
    "fullyEnabled": "fully-enabled",
    "inputEnabled": "input-enabled",
    "ioEnabled": "io-enabled",
}
"""Makes the net for the question from a property's statements about signals."""

PARTS = Share(time=0.4)
"""Share of proofs by some nodes, before all nodes are analysed."""

UNFAIR = "a run violates it, and it is unknown whether runs with times are fair"

_SEEN_AT_ONCE = {(ForAll, Globally), (Exists, Finally), (ForAll, Next), (Exists, Next)}
"""What a beginning of a run shows: every beginning continues as a fair run (Apt, Francez and Katz, 1988)."""


@dataclass(frozen=True)
class Asked:
    """A property, as a question about a net."""

    property: sym.Property
    subject: Subject
    reading: Reading
    """The property as a formula, the assumptions about signals in it."""
    weak: tuple[str, ...]
    strong: tuple[str, ...]
    """`weak`, `strong`: transitions of the net that no run neglects."""

    def question(self, orders: OrderCache | None = None) -> Question:
        """Return what engines answer."""
        net, names, formula = self.subject.net, self.subject.names, str(self.reading.formula)
        if self.reading.logic == "ctl":
            return Branching(net, names, formula, orders)
        return Linear(net, names, formula, self.weak, self.strong)

    def verdict(self, outcome: Outcome) -> Outcome:
        """Return the answer for the property, given an answer to the question."""
        if not self.reading.is_negated:
            return outcome
        other = {"holds": "violated", "violated": "holds"}
        return replace(outcome, status=other.get(outcome.status, outcome.status))

    def answer(self, budget: Budget, orders: OrderCache | None = None) -> Outcome:
        """Decide the property with the engine that suits it; with times, if the net has them."""
        return self.verdict(self.outcome(budget, orders))

    def by_parts(self, budget: Budget) -> Outcome | None:
        """Prove it with times by some nodes of the model; None if they do not prove it."""
        from dineros.analysis.requirements.parts import holds_in_part

        formula = self.reading.formula
        if self.reading.logic != "ltl" or not isinstance(self.subject, TimedSubject):
            return None
        return holds_in_part(self.subject, formula, budget)

    def outcome(self, budget: Budget, orders: OrderCache | None = None) -> Outcome:
        """Answer the question, which may be the property turned round; see `verdict`."""
        question = self.question(orders)
        if not isinstance(self.subject, TimedSubject):
            if isinstance(self.reading.formula, Bounded):
                return Outcome("unknown", reason="it bounds times, which requires --time")
            return ENGINES["auto"].answer(question, budget)
        part = self.by_parts(PARTS.share(budget))
        if part is not None:
            return part
        is_fair = bool(self.weak or self.strong)
        if is_fair and isinstance(question, Linear):
            question = replace(question, weak=(), strong=())
        try:
            found = Timed(self.subject.timed).answer(question, budget)
        except FormulaError:
            raise
        except DinerosError as error:
            return Outcome("unknown", reason=error.message)
        if is_fair and found.status == "violated":
            # Whether the run is fair, or continues as a fair one, is not known.
            return Outcome("unknown", reason=UNFAIR, states=found.states, seconds=found.seconds)
        return found


def property_named(model: pn.Net, name: str) -> sym.Property:
    """Return the property of this id, or else the one of this name.

    Raises
    ------
    FormulaError
        There is none, or several have the name.
    """
    known = properties_of(model)
    found = [each for each in known if each.id == name] or [each for each in known if label(each) == name]
    if len(found) == 1:
        return found[0]
    if found:
        raise FormulaError(f"{len(found)} properties are named {name!r}", hint="give the id")
    names = [str(each.id) for each in known]
    raise FormulaError(
        f"the model stores no property {name!r}",
        hint=near_matches(name, names) or (f"it stores {', '.join(names)}" if names else "it stores none"),
    )


def asked(
    property: sym.Property,
    subject: Subject | None = None,
    overflow: OverflowVariant = "weighted",
    is_timed: bool = False,
) -> Asked:
    """Read a property and what it may assume.

    Parameters
    ----------
    property : sym.Property
        A property of a system model.
    subject : Subject, optional
        The net without signals, where it is there already.
    overflow : str, optional
        How queues lose messages in the net.
    is_timed : bool
        Whether it is asked with the firing intervals of the model; so it is if the net given has them.

    Raises
    ------
    FormulaError
        It cannot be read, names something unknown, or asks in CTL what an assumption makes a matter of runs.
    """
    model = property.eContainer()
    assert isinstance(model, sym.SystemModel)
    reading = read(property)
    variant = VARIANTS[str(property.signals)]
    is_timed |= isinstance(subject, TimedSubject)
    if variant != "none":
        subject = (timed_subject_of if is_timed else subject_of)(model, variant, overflow)
    elif subject is None:
        subject = (timed_base_subject if is_timed else base_subject)(model, overflow)
    weak: list[str] = []
    strong: list[str] = []
    never: list[Formula] = []
    for assumption in model.assumptions:
        if isinstance(assumption, sym.Fairness):
            named = fair_transitions(subject, [str(assumption.of)])
            (strong if assumption.strong else weak).extend(named)
        elif isinstance(assumption, sym.ExclusiveSignals) and variant != "none":
            signals = [SignalTrue(Name(str(signal.id))) for signal in assumption.signals]
            never += [Not(And(pair)) for pair in combinations(signals, 2)]
    if reading.logic == "ctl":
        if never:
            raise FormulaError("CTL is not supported for runs with exclusive signals", hint="write it in LTL")
        if (weak or strong) and not _is_seen_at_once(reading.formula):
            raise FormulaError(
                "CTL is not supported for fair runs, except AG, EF, AX and EX", hint="write it in LTL"
            )
    elif never and isinstance(reading.formula, Bounded):
        raise FormulaError("bounds of times are not supported for runs with exclusive signals")
    elif never:
        premise = Globally(never[0] if len(never) == 1 else And(tuple(never)))
        reading = replace(reading, formula=Implies(premise, reading.formula))
    BoundAtoms(subject.net, reading.formula, subject.names)  # raises at what is unknown, with its column
    return Asked(property, subject, reading, tuple(dict.fromkeys(weak)), tuple(dict.fromkeys(strong)))


def read(property: sym.Property) -> Reading:
    """Read what a property asks.

    Raises
    ------
    FormulaError
        It cannot be read.
    """
    text = str(property.text)
    match str(property.language):
        case "ltl":
            return Reading("ltl", read_bounded(text) or parse(text))
        case "ctl":
            return Reading("ctl", parse(text, "ctl"))
    return read_pattern(text)


def _is_seen_at_once(formula: Formula) -> bool:
    return all(
        (type(part), type(part.operands[0])) in _SEEN_AT_ONCE
        for part in formula.subformulas()
        if isinstance(part, QUANTIFIERS)
    )
