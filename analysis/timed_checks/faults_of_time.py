"""Faults that only nets with times have: time that stops, and transitions that always come too late."""

from __future__ import annotations

from dineros.analysis.checks.question import Checked, Question
from dineros.analysis.checks.unused import TRANSITION
from dineros.analysis.timed_checks import faults
from dineros.analysis.timed_checks.standing_time import Loop, StandingTime
from dineros.analysis.timed_checks.timed_checked import TimedChecked, with_times
from dineros.analysis.timed_checks.without_times import time_goes_on
from dineros.analysis.witnesses.findings import Fault
from dineros.analysis.witnesses.witness import witness_of
from dineros.metamodel import sym

NO_LOOP = "no loop of transitions that must fire at once, with the interval [0,0]"


class NeverInTime(Question):
    """Whether a transition gets its tokens, but never fires, because others always come first."""

    TOO_LATE = faults.TOO_LATE
    faults = (TOO_LATE,)
    asks = "which transitions never fire in time"

    def ask(self, checked: Checked) -> None:
        """Look for markings that enable what never fires. Such a transition is not also reported as dead."""
        known = with_times(checked)
        explored, subject = known.explored, known.timed
        if not explored.is_complete:
            return  # what never fires is undecided then, and reported so
        names = subject.net.transitions
        firing = {subject.transition_element(t) for t in explored.ways}
        found: set[str] = set()
        for t in range(len(names)):
            element, link = subject.transition_element(t), subject.link_of(names[t])
            if element in firing or element in found or (link is not None and link.maker is not None):
                continue
            rows = explored.enabled_at(t)
            if len(rows):
                found.add(element)
                witness = witness_of(subject, explored.way_to(int(rows[0])))
                words = {"transition": subject.transition_text(t), "interval": explored.net.intervals[t]}
                checked.report.findings.append(self.TOO_LATE.found(element, witness=witness, **words))
        checked.report.findings = [
            one
            for one in checked.report.findings
            if one.rule != TRANSITION.rule or found.isdisjoint(one.elements)
        ]


class TimeStops(Question):
    """Whether infinitely many firings must happen in no time, or priorities keep time from going on.

    Of a plain net it is a note if they can, and need not. In a system model that is usual: a duration is
    known to be at most so long.
    """

    STOPS, HELD, MAY_STOP, LOCKED = faults.STOPS, faults.HELD, faults.MAY_STOP, faults.LOCKED
    faults = (STOPS, HELD, MAY_STOP, LOCKED)
    asks = "whether time can stop"

    def ask(self, checked: Checked) -> None:
        """Look for loops of transitions that fire at once, and for what priorities hold."""
        known = with_times(checked)
        explored = known.explored
        self._find_locks(known)
        standing = StandingTime(explored, known.budget)
        goes_on = time_goes_on(explored.net)
        loop = None if goes_on else standing.at_once()
        if loop is not None:
            self._report(known, self.STOPS, loop)
            return
        if goes_on or explored.is_complete:
            known.report.proved.append(NO_LOOP)
        else:
            checked.leave_open(self.asks, explored.reason)
        held = standing.that_holds() if explored.is_complete else None
        if held is not None:
            self._report(known, self.HELD, *held)
        may = None if isinstance(known.subject.model, sym.SystemModel) else standing.that_may_wait()
        if may is not None:
            self._report(known, self.MAY_STOP, may)

    def _report(self, known: TimedChecked, fault: Fault, loop: Loop, held: int | None = None) -> None:
        stem, repeated = loop
        subject = known.subject
        witness = witness_of(subject, [*stem, *repeated], len(stem))
        concerned = [*repeated, *([] if held is None else [held])]
        ids = dict.fromkeys(subject.transition_element(t) for t in concerned)
        words = {"loop": ", ".join(dict.fromkeys(subject.transition_text(t) for t in repeated))}
        if held is not None:
            words["held"] = subject.transition_text(held)
        known.report.findings.append(fault.found(*ids, witness=witness, **words))

    def _find_locks(self, known: TimedChecked) -> None:
        """Find ends in which transitions with priority over themselves, through others, are enabled."""
        net = known.explored.net
        circular = [t for t, above in enumerate(net.above) if t in above]
        if not circular:
            return
        for row, trace in known.explored.ends:
            held = [t for t in circular if row in known.explored.enabled_at(t)]
            if held:
                ids = [known.subject.transition_element(t) for t in held]
                words = ", ".join(known.subject.transition_text(t) for t in held)
                witness = witness_of(known.subject, trace)
                known.report.findings.append(self.LOCKED.found(*ids, witness=witness, transitions=words))
                return
