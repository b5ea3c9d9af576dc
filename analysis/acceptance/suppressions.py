"""Which findings the suppressions of a model accept, which suppressions have expired or match nothing."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from datetime import date
from itertools import chain

from dineros.analysis.witnesses.findings import Fault, Finding, Report, Suppressed
from dineros.metamodel import pn
from dineros.metamodel.base import EObject
from dineros.metamodel.constraints.wording import describe
from dineros.metamodel.elements import named_elements
from dineros.metamodel.errors import near_matches

EXPIRED = Fault(
    "suppression-expired",
    "note",
    "A suppression has expired, so the finding counts again.",
    "the suppression of {rule} at {element} expired on {until}: the finding counts again (reason: {reason})",
)
UNUSED = Fault(
    "suppression-unused",
    "note",
    "A suppression matches no finding and can be removed.",
    "the suppression of {rule} at {element} suppresses nothing{why}",
)
FAULTS = (EXPIRED, UNUSED)
"""Findings about suppressions themselves; both are always printed."""


@dataclass(frozen=True)
class _Entry:
    """A suppression of the model, and the element that has it."""

    element: pn.Element
    rule: str
    reason: str
    until: str | None

    def ends_before(self, today: date) -> bool:
        return self.until is not None and date.fromisoformat(self.until) < today


class Suppressions:
    """The suppressions of a model.

    A suppression accepts the findings of its rule about the element that has it, or about anything that this
    element contains. A finding is about all of its elements. Consequences of an accepted finding are accepted
    only by suppressions of their own; the others count.

    Parameters
    ----------
    model : pn.Net
        A valid model.
    today : date, optional
        The day that decides what has expired; by default the current one.
    """

    def __init__(self, model: pn.Net, today: date | None = None) -> None:
        self._today = date.today() if today is None else today
        self._by_id: dict[str, list[pn.Element]] = {}
        self._entries: dict[EObject, list[_Entry]] = {}
        for element in named_elements(model):
            # An unset feature would be filled just by looking at it.
            if "suppressions" in element.__dict__ and len(element.suppressions):
                self._entries[element] = [
                    _Entry(element, each.rule, each.reason, each.until) for each in element.suppressions
                ]
        if self._entries:
            for element in named_elements(model):
                self._by_id.setdefault(element.id, []).append(element)

    def apply(self, report: Report, rules: Collection[str]) -> Report:
        """Return a report in which accepted findings are set apart, with notes about the suppressions.

        A suppression without effect is named only if no question stayed open, because an open question may
        hide the finding; one whose rule does not exist is always named.

        `report`: the report; it is not changed.
        """
        if not self._entries:
            return report
        used: set[int] = set()
        counting: list[Finding] = []
        suppressed, notes = list(report.suppressed), []
        left = deque(report.findings)
        while left:
            finding = left.popleft()
            matching = self._matching(finding)
            used |= {id(entry) for each in (finding, *finding.consequences) for entry in self._matching(each)}
            valid = next((entry for entry in matching if not entry.ends_before(self._today)), None)
            if valid is not None:
                accepted = replace(finding, consequences=())
                suppressed.append(Suppressed(accepted, str(valid.element.id), valid.reason, valid.until))
                left.extendleft(reversed(finding.consequences))
                continue
            counting.append(finding)
            notes += [self._note(EXPIRED, entry) for entry in matching]
        is_complete = not any(unknown.may_be_fault for unknown in report.unknown)
        for entry in chain.from_iterable(self._entries.values()):
            if id(entry) in used:
                continue
            why = "" if entry.rule in rules else _unknown(entry.rule, rules)
            if why or is_complete:
                notes.append(self._note(UNUSED, entry, why=why))
        return report.with_accepted([*counting, *dict.fromkeys(notes)], suppressed, report.known)

    def _matching(self, finding: Finding) -> list[_Entry]:
        """Return the suppressions that are about a finding, expired or not."""
        return [entry for entry in self._at(finding) if entry.rule == finding.rule]

    def _at(self, finding: Finding) -> Iterator[_Entry]:
        """Yield the suppressions at the elements of a finding and at what contains them, nearest first."""
        for name in finding.elements:
            for element in self._by_id.get(name, ()):
                around: EObject | None = element
                while around is not None:
                    yield from self._entries.get(around, ())
                    around = around.eContainer()

    @staticmethod
    def _note(fault: Fault, entry: _Entry, why: str = "") -> Finding:
        return fault.found(
            str(entry.element.id),
            rule=entry.rule,
            element=describe(entry.element),
            until=entry.until,
            reason=entry.reason,
            why=why,
        )


def _unknown(rule: str, rules: Collection[str]) -> str:
    hint = near_matches(rule, sorted(rules))
    return f": there is no rule {rule!r}" + (f" ({hint})" if hint else "")
