"""Whether something can wait forever: the whole net, or a callback."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from dineros.analysis.answers.stages import Share
from dineros.analysis.callbacks.circles import Circle, Waiter
from dineros.analysis.checks.properties import Properties
from dineros.analysis.checks.question import Checked, Question
from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.model.final_conditions import FinalCondition
from dineros.analysis.nets.witness import last_marking
from dineros.analysis.witnesses.findings import Fault, Wait
from dineros.analysis.witnesses.witness import Witness, witness_to
from dineros.metamodel.elements import is_unseen, node_net_of

if TYPE_CHECKING:
    from dineros.analysis.callbacks.blocking import Blocked
    from dineros.analysis.checks.deadlocks import DeadlockGroup


MOST_MARKINGS = 1_000_000
"""Limit of the markings that are examined for waiting callbacks; above it, parts of the net are."""

MANY_TRANSITIONS = 600
"""In a net with as many, circles that planned runs show are reported before all other questions."""

PLANNED = Share(time=0.2)
"""Part of the time for that."""

CALLBACKS = Share(time=0.7)
"""Part of the time that is left in which callbacks that wait forever are looked for without a state space."""

ALL_END = "every callback that has begun can end"
OTHERS_END = "every other callback that has begun can end"


class Deadlock(Question):
    """Whether there is a deadlock."""

    STUCK = Fault(
        "deadlock", "warning", "A marking can be reached in which no transition is enabled.", "{markings}"
    )
    RESTS = Fault("deadlock", "note", STUCK.meaning, STUCK.message)
    """Every node rests in final places: a finished scenario."""
    faults = (STUCK,)
    asks = "whether there is a deadlock"
    reads_firings = True

    def ask(self, checked: Checked) -> None:
        """Group the markings that enable nothing."""
        from dineros.analysis.checks.deadlocks import deadlock_groups, group_at

        subject, known, final = checked.subject, checked.firings, self._final(checked)
        if known is not None:
            if known.deadlock is not None:
                self._find(checked, group_at(subject, known.deadlock, final))
            if known.has_no_deadlock:
                checked.report.proved.append("no deadlock")
            elif not known.is_complete:
                asks = "whether there are other deadlocks" if known.deadlock else self.asks
                checked.leave_open(asks, known.why_open)
            return
        self._find_all(checked, deadlock_groups(subject, checked.space, final))

    @staticmethod
    def _final(checked: Checked) -> FinalCondition | None:
        """Return the final condition of the model; one that cannot be read is a finding."""
        try:
            return FinalCondition.of(checked.subject)
        except FormulaError as error:
            what = "the final condition of the model"
            unreadable = Properties.UNREADABLE.found(checked.identity, property=what, reason=error)
            checked.report.findings.append(unreadable)
            return None

    def _find_all(self, checked: Checked, groups: Sequence[DeadlockGroup]) -> None:
        """Report all dead markings; there are no others."""
        for group in groups:
            self._find(checked, group)
        if not groups:
            checked.report.proved.append("no deadlock")

    def _find(self, checked: Checked, group: DeadlockGroup) -> None:
        from dineros.analysis.checks.deadlocks import group_text, is_finished

        subject = checked.subject
        circle = checked.waiting.circle(last_marking(subject.net, group.trace))
        if circle is not None:
            Callbacks.find(checked, circle, group.trace)
            return
        witness = witness_to(subject, group.trace)
        waits = dict.fromkeys(subject.transition_element(cause.transition) for cause in group.causes)
        text = group_text(subject, group)
        fault = self.RESTS if is_finished(subject, group) else self.STUCK
        checked.report.findings.append(fault.found(*waits, checked.identity, witness=witness, markings=text))


class Callbacks(Question):
    """Whether callbacks can wait forever, in nodes that run callbacks."""

    CIRCLE = Fault(
        "callback-deadlock",
        "error",
        "Callbacks, callback groups, threads and calls can wait for each other in a circle.",
        "{circle}",
    )
    ENDLESS = Fault(
        "callback-never-ends",
        "error",
        "A callback can wait forever, and so can callbacks that need its thread or its group.",
        "{callback} can begin and never end",
    )
    faults = (CIRCLE, ENDLESS)
    asks = "which callbacks can wait forever"
    needs_space = False

    def leave_open(self, checked: Checked, reason: str) -> None:
        """Leave it undecided, unless it was decided."""
        if not checked.is_closed and not checked.callbacks_asked:
            super().leave_open(checked, reason)

    def ask_first(self, checked: Checked) -> None:
        """Look for circles that can be seen at little cost, in models whose markings may never be counted."""
        if len(checked.subject.net.transitions) < MANY_TRANSITIONS or not checked.waiting.callbacks:
            return
        from dineros.analysis.callbacks.searching import near_circles

        checked.budget.stage(self.asks)
        share = PLANNED.share(checked.budget)
        self._report(checked, near_circles(checked.subject.net, checked.waiting, share))

    def ask(self, checked: Checked) -> None:
        """Look for callbacks that never end from some marking on."""
        if checked.callbacks_asked or not checked.waiting.callbacks:
            return
        if checked.recurs:
            checked.report.proved.append(ALL_END)
            return
        has_no_space = checked.firings is not None or checked.is_closed
        if has_no_space or checked.space.markings > MOST_MARKINGS:
            self.ask_early(checked)
            return
        from dineros.analysis.callbacks.blocking import blocked

        if not self._report(checked, blocked(checked.space, checked.waiting, checked.budget)):
            checked.report.proved.append(ALL_END)

    @classmethod
    def ask_early(cls, checked: Checked) -> None:
        """Look for them without the state space, which may take long, or have no end."""
        if checked.callbacks_asked or not checked.waiting.callbacks:
            return
        from dineros.analysis.callbacks.searching import searched

        checked.budget.stage(cls.asks)
        share = CALLBACKS.share(checked.budget)
        search = searched(checked.subject.net, checked.waiting, share)
        checked.callbacks_asked, checked.callbacks_known = True, search.is_complete
        found = cls._report(checked, search.blocked)
        if not search.is_complete:
            asks = "which other callbacks can wait forever" if found else cls.asks
            checked.leave_open(asks, search.reason)
        else:
            checked.report.proved.append(OTHERS_END if found else ALL_END)

    @classmethod
    def _report(cls, checked: Checked, each_blocked: Iterable[Blocked]) -> bool:
        """Put what is found into the report; return whether there is anything."""
        found = False
        for each in each_blocked:
            if each.circle is None and is_unseen(node_net_of(each.callback.model)):
                continue  # it stands for what other programs do, which is not known
            found = True
            if each.circle is not None:
                cls.find(checked, each.circle, each.trace)
            else:
                callback = each.callback
                witness = cls._witness(checked, callback, None, each.trace)
                checked.report.findings.append(
                    cls.ENDLESS.found(callback.element, witness=witness, callback=callback.text)
                )
        return found

    @classmethod
    def find(cls, checked: Checked, circle: Circle, trace: tuple[int, ...]) -> None:
        """Put a circle, which is closed after a run, into the report, once for all server instances."""
        if any(other.shape == circle.shape for other in checked.circles):
            return
        checked.circles.append(circle)
        witness = cls._witness(checked, circle.waiters[0], circle, trace)
        finding = replace(
            cls.CIRCLE.found(*circle.elements, witness=witness, circle=circle),
            circle=tuple(waiter.text for waiter in circle.waiters),
            waits=tuple(
                Wait(reason.waiter.text, tuple(need.text for need in reason.needs), reason.is_choice)
                for reason in circle.reasons
            ),
        )
        checked.report.findings.append(finding)

    @staticmethod
    def _witness(
        checked: Checked, callback: Waiter, circle: Circle | None, trace: tuple[int, ...]
    ) -> Witness:
        """Return a run that ends when a callback waits forever, without later independent firings."""
        from dineros.analysis.callbacks.blocking import Blocked
        from dineros.analysis.callbacks.walking import Walks

        if checked.is_shown and not checked.subject.is_timed:
            walks = Walks(checked.subject.net, checked.waiting)
            trace = walks.shortest(Blocked(callback, circle, trace)).trace
        return witness_to(checked.subject, trace)
