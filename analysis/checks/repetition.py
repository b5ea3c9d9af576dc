"""Repetition, as a question of a check."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from dineros.analysis.checks.question import Checked, Question
from dineros.analysis.model.queues import queues
from dineros.analysis.witnesses.findings import Fault
from dineros.metamodel.errors import counted

if TYPE_CHECKING:
    from dineros.analysis.properties.recurrence import Recurrence

BEHAVIOUR = "liveness, reversibility, home markings"
REVERSIBLE = "the net is reversible: the initial marking can always be reached again"


class Repetition(Question):
    """Repetition: liveness, reversibility, home markings.

    Few applications are live, so what fails is a note, no fault. Losing messages forever is not part of being
    live. Answers that need more than the given work stay unknown.
    """

    NOT_LIVE = Fault(
        "not-live",
        "note",
        "A marking can be reached from which a transition never fires again.",
        "these transitions can become permanently disabled: {transitions}",
    )
    NOT_REVERSIBLE = Fault(
        "not-reversible",
        "note",
        "A marking can be reached from which the initial marking cannot be reached again.",
        "the initial marking cannot always be reached again",
    )
    NO_HOME_MARKING = Fault(
        "no-home-marking",
        "note",
        "No marking can be reached from every reachable one.",
        "no marking can always be reached",
    )
    faults = (NOT_LIVE, NOT_REVERSIBLE, NO_HOME_MARKING)
    asks = BEHAVIOUR

    def leave_open(self, checked: Checked, reason: str) -> None:
        """Leave it undecided, which matters only where it was asked for."""
        checked.leave_open(self.asks, reason, may_be_fault=checked.work is None)

    def ask(self, checked: Checked) -> None:
        """Look at the terminal parts of the state space."""
        from dineros.analysis.properties.behaviour import TooMuchWorkError, behaviour

        if checked.firings is not None:
            if checked.recurrence is not None:
                self._say_recurrence(checked, checked.recurrence)
            else:
                self.leave_open(checked, checked.firings.why_open or "there are infinitely many markings")
            return
        try:
            answer = behaviour(checked.space, checked.budget, checked.work)
        except TooMuchWorkError:
            if checked.recurrence is not None:
                self._say_recurrence(checked, checked.recurrence)
                return
            reason = "not decided, because it takes more work than a check may cost"
            checked.leave_open(BEHAVIOUR, reason, "--behaviour decides it", may_be_fault=False)
            return
        self._say_live(checked, answer.not_live)
        found, proved = checked.report.findings, checked.report.proved
        if answer.reversible:
            proved.append(REVERSIBLE)
        else:
            found.append(self.NOT_REVERSIBLE.found(checked.identity))
        if answer.home_markings:
            proved.append(f"{counted(answer.home_markings, 'home marking')} can always be reached")
        else:
            found.append(self.NO_HOME_MARKING.found(checked.identity))

    def _say_live(self, checked: Checked, not_live: Iterable[int]) -> None:
        subject = checked.subject
        drops = {subject.transition_index[drop] for queue in queues(subject) for drop in queue.drops}
        shut_off = (subject.transition_text(t) for t in sorted(not_live) if t not in drops)
        names = tuple(dict.fromkeys([*subject.blocked, *shut_off]))
        if names:
            shown = ", ".join(names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")
            checked.report.findings.append(self.NOT_LIVE.found(checked.identity, transitions=shown))
        else:
            checked.report.proved.append("the net is live: every transition can always fire again")

    def _say_recurrence(self, checked: Checked, proof: Recurrence) -> None:
        self._say_live(checked, proof.dead)
        home = "all" if checked.firings is not None else f"{checked.space.markings} home"
        checked.report.proved += [REVERSIBLE, f"{home} markings can always be reached"]
