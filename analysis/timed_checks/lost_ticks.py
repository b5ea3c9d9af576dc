"""Ticks of timers that are lost: a timer strikes while its last tick still waits for a thread or a group."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from dineros.analysis.checks.blocking import Callbacks
from dineros.analysis.checks.question import Checked, Question
from dineros.analysis.checks.ways import can_fire, firing_witness, why_unseen
from dineros.analysis.model.subject import Subject
from dineros.analysis.model.wording import source_of
from dineros.analysis.timed_checks import faults
from dineros.metamodel import sym
from dineros.metamodel.elements import label
from dineros.metamodel.times.orders import begins_in_every_state
from dineros.transformations.rules.times.strikes import D1


class LostTicks(Question):
    """Whether a timer can strike while its last tick still waits.

    If its callback can begin only in some states, the model says that ticks may wait: then it is a note.
    """

    LOSES, SKIPS = faults.LOSES_TICKS, faults.SKIPS_TICKS
    faults = (LOSES, SKIPS)
    asks = "which timers can lose ticks"
    reads_firings = True

    def ask(self, checked: Checked) -> None:
        """Ask of each timer. A callback that waits forever is reported as such, and not again here."""
        stuck = {
            element
            for finding in checked.report.findings
            if finding.rule in {fault.rule for fault in Callbacks.faults}
            for element in finding.elements
        }
        for page, transition in misses(checked.subject):
            if page.id not in stuck:
                with checked.guarded(partial(self._leave_open, checked, page)):
                    self._ask_of(checked, page, transition)

    def _ask_of(self, checked: Checked, page: sym.CallbackPage, transition: str) -> None:
        loses = can_fire(checked, [transition])
        if loses is None:
            self._leave_open(checked, page, checked.why_open)
        elif not loses:
            checked.report.proved.append(f"the timer of {label(page)} loses no tick")
        else:
            with checked.showing():
                witness = firing_witness(checked, [transition])
            if witness is None:
                checked.leave_open(f"how the timer of {label(page)} loses a tick", why_unseen(checked))
            fault = self.LOSES if begins_in_every_state(page) else self.SKIPS
            checked.report.findings.append(fault.found(page.id, witness=witness, callback=label(page)))

    def _leave_open(self, checked: Checked, page: sym.CallbackPage, reason: str) -> None:
        asks = f"whether the timer of {label(page)} loses ticks"
        checked.leave_open(asks, reason, "", begins_in_every_state(page), (page.id,), self.LOSES.rule)


def misses(subject: Subject) -> Iterator[tuple[sym.CallbackPage, str]]:
    """Yield the callbacks of timers, each with the transition by which its timer loses a tick."""
    for link in subject.links():
        if link.maker is D1 and link.role == "miss":
            yield source_of(link, sym.CallbackPage), link.target.id
