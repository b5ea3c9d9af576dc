"""Whether the properties that the model stores hold as expected."""

from __future__ import annotations

from functools import partial
from typing import ClassVar

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.checks.question import Checked, Question
from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.requirements.stored import Asked, asked, properties_of
from dineros.analysis.witnesses.findings import Fault, Witness, witness_of
from dineros.metamodel import sym
from dineros.metamodel.elements import label


class Properties(Question):
    """Whether the properties that the model stores hold as expected."""

    VIOLATED = Fault(
        "property-violated",
        "error",
        "A property that the model stores does not hold.",
        "{property} does not hold: {text}",
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
        "A property that the model stores cannot be asked.",
        "{property} cannot be asked: {reason}",
    )
    faults = (VIOLATED, HOLDS, UNREADABLE)
    asks = "the properties of the model"
    needs_space: ClassVar[bool] = False

    def ask(self, checked: Checked) -> None:
        """Ask them one after the other, each with its share of what is left."""
        properties = properties_of(checked.model)
        for number, property in enumerate(properties):
            shown = f"property {label(property)}"
            checked.budget.stage(f"whether {shown} holds")
            with checked.guarded(partial(checked.leave_open, f"whether {shown} holds")):
                self._ask_of(checked, property, shown, checked.budget.share(1 / (len(properties) - number)))

    def _ask_of(self, checked: Checked, property: sym.Property, shown: str, budget: Budget) -> None:
        try:
            question = asked(property, checked.subject)
            outcome = question.answer(budget, checked.orders)
        except FormulaError as error:
            checked.report.findings.append(
                self.UNREADABLE.found(str(property.id), property=shown, reason=error)
            )
            return
        self._say(checked, property, shown, question, outcome)

    def _say(
        self, checked: Checked, property: sym.Property, shown: str, question: Asked, outcome: Outcome
    ) -> None:
        if outcome.status == "unknown":
            checked.leave_open(f"whether {shown} holds", outcome.reason)
            return
        does_hold = outcome.status == "holds"
        if does_hold == bool(property.expected):
            how = "holds" if does_hold else "does not hold, as expected"
            checked.report.proved.append(f"{shown} {how}: {property.text}")
            return
        fault = self.HOLDS if does_hold else self.VIOLATED
        checked.report.findings.append(
            fault.found(
                str(property.id),
                witness=_witness(question, outcome),
                property=shown,
                text=property.text,
            )
        )


def _witness(question: Asked, outcome: Outcome) -> Witness | None:
    if not outcome.stem and not outcome.loop:
        return None
    loop = len(outcome.stem) if outcome.loop else None
    return witness_of(question.subject, [*outcome.stem, *outcome.loop], loop)
