"""Where a net with times ends: markings in which nothing can fire any more, however long one waits."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from dineros.analysis.checks.blocking import Deadlock
from dineros.analysis.checks.deadlocks import DeadlockGroup, group_at, merged
from dineros.analysis.checks.question import Checked
from dineros.analysis.timed.exploring import Trace
from dineros.analysis.timed.timed_subject import TimedSubject, signals_matter
from dineros.analysis.timed_checks.timed_checked import TimedChecked, with_times
from dineros.metamodel import pn, sym

MOST_LOOKED_AT = 200
"""Limit of the markings whose causes are examined; the rest are one group."""


class TimedDeadlock(Deadlock):
    """Whether a marking is reached in which nothing can fire any more.

    A marking that enables something is never such an end: what is enabled fires when its time comes, or
    something else does. Only priorities in a circle keep each other from firing.
    """

    def ask(self, checked: Checked) -> None:
        """Group the markings that are ends by their causes."""
        known = with_times(checked)
        if not known.explored.is_complete:
            if checked.firings is not None and checked.firings.has_no_deadlock:
                checked.report.proved.append("no deadlock")
            else:
                self._ask_of_runs(known)
            return
        if isinstance(checked.model, sym.SystemModel) and signals_matter(checked.model):
            of_signals = _signal_places(known.timed)
            rows = _quiet(known.timed, known.explored.markings, of_signals)
            ways = [known.explored.way_to(int(row)) for row in rows[: MOST_LOOKED_AT + 1]]
            self._find_all(known, self._groups(known, ways, len(rows), of_signals))
            return
        ends = [way for _, way in known.explored.ends]
        self._find_all(known, self._groups(known, ends, len(ends)))

    def _ask_of_runs(self, known: TimedChecked) -> None:
        """Report where random runs end, as not all markings are known."""
        ends = known.walked.ends
        if not isinstance(known.model, sym.SystemModel) or not signals_matter(known.model):
            for group in self._groups(known, ends, len(ends)):
                self._find(known, group)
        else:
            ends = []
        known.leave_open("whether there are other deadlocks" if ends else self.asks, known.explored.reason)

    def _groups(
        self, known: TimedChecked, ends: list[Trace], count: int, of_signals: Collection[int] = ()
    ) -> list[DeadlockGroup]:
        """Return the dead markings, of which the first ones have a way there, by their causes."""
        final, subject = self._final(known), known.subject
        groups = [group_at(subject, trace, final, of_signals) for trace in ends[: MOST_LOOKED_AT + 1]]
        if count > MOST_LOOKED_AT:
            groups[-1] = replace(groups[-1], markings=count - MOST_LOOKED_AT, is_rest=True)
        return merged(subject, groups)


def _signal_places(subject: TimedSubject) -> set[int]:
    """Return the places of signals, and of the clauses over them."""
    return {
        subject.place_index[link.target.id]
        for link in subject.links()
        if isinstance(link.target, pn.Place)
        and any(isinstance(source, (sym.InputSignal, sym.Disjunction)) for source in link.sources)
    }


def _quiet(
    subject: TimedSubject,
    markings: np.ndarray[tuple[int, ...], np.dtype[np.int64]],
    of_signals: Collection[int],
) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    """Return the markings that enable only changes of signals, with any values of these."""
    ids = {
        link.target.id
        for link in subject.links()
        if isinstance(link.target, pn.Transition)
        and any(isinstance(source, sym.InputSignal) for source in link.sources)
    }
    net = subject.timed
    quiet = np.ones(len(markings), dtype=np.bool_)
    for transition, name in enumerate(net.untimed.transitions):
        if name in ids:
            continue
        enabled = np.ones(len(markings), dtype=np.bool_)
        for place, weight in net.untimed.pre.row(transition):
            if place not in of_signals:
                enabled &= markings[:, place] >= weight
        for place, weight in net.untimed.inhibitor.row(transition):
            enabled &= markings[:, place] < weight
        quiet &= ~enabled
    return np.flatnonzero(quiet)
