"""Whether the properties that the model stores hold as expected."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, ClassVar

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.stages import Share, fairly
from dineros.analysis.checks.question import Checked, Question
from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.model.subject import Subject
from dineros.analysis.requirements.listing import properties_of
from dineros.analysis.witnesses.findings import Fault
from dineros.analysis.witnesses.witness import Witness, witness_of
from dineros.metamodel import sym
from dineros.metamodel.elements import label

if TYPE_CHECKING:
    from dineros.analysis.requirements.latencies import AskedLatency
    from dineros.analysis.requirements.stored import Asked

FIRST = Share(time=0.08, most_seconds=5.0)
"""Share of each property before all other questions."""

PARTS = Share(time=0.25, most_seconds=60.0)
"""The same for each bound of a time that some nodes may decide."""


class Properties(Question):
    """Whether the properties that the model stores hold as expected."""

    VIOLATED = Fault(
        "property-violated",
        "error",
        "A property that the model stores does not hold.",
        "{property} does not hold: {text}{unless}",
    )
    HOLDS = Fault(
        "property-holds",
        "error",
        "A property that the model stores holds, though it is expected not to.",
        "{property} holds, though it is expected not to: {text}",
    )
    UNREADABLE = Fault(
        "property-unreadable",
        "error",
        "A property that the model stores cannot be decided.",
        "{property} cannot be decided: {reason}",
    )
    faults = (VIOLATED, HOLDS, UNREADABLE)
    asks = "the properties of the model"
    needs_space: ClassVar[bool] = False

    def leave_open(self, checked: Checked, reason: str) -> None:
        """Leave those open that are not answered."""
        for property in _left(checked):
            self._leave_open(checked, property, reason)

    def ask_first(self, checked: Checked) -> None:
        """Ask each for a short while."""
        for property in _left(checked):
            self._ask_of(checked, property, FIRST.share(checked.budget), is_first=True)

    def ask_with_space(self, checked: Checked) -> None:
        """Ask those that are left for a short while, if they are about the net of the state space."""
        if self._subject(checked) is checked.subject:
            Properties.ask_first(self, checked)

    def ask_bounds(self, checked: Checked) -> None:
        """Prove bounds of times by response-time analysis or some nodes, before anything that takes long."""
        from dineros.analysis.requirements.asking import question_of
        from dineros.analysis.requirements.stored import Asked

        for property in (each for each in properties_of(checked.model) if each.expected):
            shown = f"property {label(property)}"
            with checked.guarded(None):
                try:
                    question = question_of(property, self._subject(checked))
                except FormulaError:
                    continue  # what is open, or cannot be read, is asked again
                if isinstance(question, Asked):
                    self._ask_parts(checked, property, shown, question)
                    continue
                checked.budget.stage(f"whether {shown} holds")
                outcome = question.by_bounds()
                if outcome is not None:
                    self._say(checked, property, shown, question, outcome)
                    checked.bounded[_mark(property)] = checked.report.proved[-1]

    def tell(self, checked: Checked, decide: Callable[[Asked], Outcome | None]) -> None:
        """Answer those that are left, and are about the net that is checked, by what is known of it.

        `decide`: gets a property, and returns its answer; None if it is not known.
        """
        from dineros.analysis.requirements.asking import question_of
        from dineros.analysis.requirements.stored import Asked

        for property in _left(checked):
            with checked.guarded(None):
                try:
                    question = question_of(property, self._subject(checked))
                except FormulaError:
                    continue  # what cannot be read is said when all are asked
                if not isinstance(question, Asked) or question.subject is not checked.subject:
                    continue
                outcome = decide(question)
                if outcome is not None:
                    self._say(checked, property, f"property {label(property)}", question, outcome)
                    checked.told.add(_mark(property))

    def _ask_parts(self, checked: Checked, property: sym.Property, shown: str, question: Asked) -> None:
        if question.reading.is_negated:
            return
        outcome = question.by_parts(PARTS.share(checked.budget))
        if outcome is not None:
            self._say(checked, property, shown, question, outcome)
            checked.told.add(_mark(property))

    def ask(self, checked: Checked) -> None:
        """Ask those that are left one after the other, each with its share of what is left."""
        for property, share in fairly(list(_left(checked)), checked.budget):
            self._ask_of(checked, property, share)
        self._order(checked)

    def _subject(self, checked: Checked) -> Subject:
        """Return the net that properties are asked of."""
        return checked.subject

    def _order(self, checked: Checked) -> None:
        """Put what was found of properties first, as the model has them, whenever it was found."""
        places = {str(each.id): number for number, each in enumerate(properties_of(checked.model))}
        rules = {fault.rule for fault in self.faults}
        checked.report.findings.sort(
            key=lambda found: places[found.elements[0]] if found.rule in rules else len(places)
        )

    def _ask_of(
        self, checked: Checked, property: sym.Property, budget: Budget, is_first: bool = False
    ) -> None:
        from dineros.analysis.requirements.asking import question_of

        shown = f"property {label(property)}"
        checked.budget.stage(f"whether {shown} holds")
        # Questions that are open after a short time are asked again.
        with checked.guarded(None if is_first else partial(self._leave_open, checked, property)):
            checked.budget.check_time()
            try:
                question = question_of(property, self._subject(checked))
                outcome = question.answer(budget, checked.orders)
            except FormulaError as error:
                unreadable = self.UNREADABLE.found(str(property.id), property=shown, reason=error)
                checked.report.findings.append(replace(unreadable, question=str(property.text)))
                checked.told.add(_mark(property))
                return
            if outcome.status != "unknown" or not is_first:
                self._say(checked, property, shown, question, outcome)
                checked.told.add(_mark(property))

    def _leave_open(self, checked: Checked, property: sym.Property, reason: str) -> None:
        """Leave a property open, if no safe bound has proved it."""
        if _mark(property) not in checked.bounded:
            checked.leave_open(f"whether property {label(property)} holds", reason)

    def _say(
        self,
        checked: Checked,
        property: sym.Property,
        shown: str,
        question: Asked | AskedLatency,
        outcome: Outcome,
    ) -> None:
        if outcome.status == "unknown":
            self._leave_open(checked, property, outcome.reason)
            return
        if _mark(property) in checked.bounded:
            checked.report.proved.remove(checked.bounded.pop(_mark(property)))
            checked.answered[:] = [each for each in checked.answered if each[0] is not property]
        checked.answered.append((property, question, outcome))
        does_hold = outcome.status == "holds"
        if does_hold == bool(property.expected):
            how = "holds" if does_hold else "does not hold, as expected"
            why = f" ({outcome.reason})" if outcome.reason else ""
            checked.report.proved.append(f"{shown} {how}: {property.text}{why}")
            return
        fault = self.HOLDS if does_hold else self.VIOLATED
        found = fault.found(
            str(property.id),
            witness=_witness(question, outcome),
            property=shown,
            text=property.text,
            unless=_unless(checked, question, outcome),
        )
        checked.report.findings.append(replace(found, question=str(property.text)))


def _unless(checked: Checked, question: Asked | AskedLatency, outcome: Outcome) -> str:
    """Return the time of a violation, or the fairness that would prove the property; empty without either.

    A bound of a time may be violated by a run in which nothing fires: then only these words show it.
    """
    from dineros.analysis.logic.language.bounded import Bounded
    from dineros.analysis.questions.needed_fairness import needed_fairness
    from dineros.analysis.questions.net_questions import Linear
    from dineros.analysis.requirements.stored import Asked

    if not isinstance(question, Asked) or isinstance(question.reading.formula, Bounded):
        return f"; {outcome.reason}"
    linear = question.question()
    if not isinstance(linear, Linear) or question.reading.is_negated:
        return ""
    if question.subject.is_timed:
        return ""  # which runs with times are fair is not known
    needed = needed_fairness(question.subject, linear, outcome, checked.budget)
    return "" if needed is None else f"; only unfair runs violate it: it holds with {needed}"


def _left(checked: Checked) -> list[sym.Property]:
    """Return the properties that are not answered."""
    return [property for property in properties_of(checked.model) if _mark(property) not in checked.told]


def _mark(property: sym.Property) -> str:
    """Return the entry of a report for an answered property."""
    return f"property {property.id}"


def _witness(question: Asked | AskedLatency, outcome: Outcome) -> Witness | None:
    if not outcome.stem and not outcome.loop:
        return None
    loop = len(outcome.stem) if outcome.loop else None
    return witness_of(question.subject, [*outcome.stem, *outcome.loop], loop, outcome.times)
