"""Where a net with times ends: markings in which nothing can fire any more, however long one waits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from dineros.analysis.checks.blocking import Deadlock
from dineros.analysis.checks.deadlocks import DeadlockGroup, group_at, merged
from dineros.analysis.checks.properties import Properties
from dineros.analysis.checks.question import Checked
from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.model.final_conditions import FinalCondition
from dineros.analysis.timed.exploring import Trace
from dineros.analysis.timed.timed_subject import TimedSubject, signals_matter
from dineros.analysis.timed_checks.timed_checked import TimedChecked, with_times
from dineros.analysis.witnesses.findings import witness_of
from dineros.metamodel import sym

MOST_LOOKED_AT = 200
"""Markings of which the causes are looked at; the rest are one group."""


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
            self._ask_of_signals(known)
            return
        groups = merged(checked.subject, _groups(known, [way for _, way in known.explored.ends]))
        for group in groups:
            self._find(checked, group)
        if not groups:
            checked.report.proved.append("no deadlock")

    def _ask_of_runs(self, known: TimedChecked) -> None:
        """Report where random runs end, as not all markings are known."""
        ends = known.walked.ends
        if not isinstance(known.model, sym.SystemModel) or not signals_matter(known.model):
            for group in merged(known.subject, _groups(known, ends)):
                self._find(known, group)
        else:
            ends = []
        known.leave_open("whether there are other deadlocks" if ends else self.asks, known.explored.reason)

    def _ask_of_signals(self, known: TimedChecked) -> None:
        """Look for markings in which nothing but signals can change, whatever these are."""
        rows = _quiet(known.timed, known.explored.markings)
        if not len(rows):
            known.report.proved.append("no deadlock")
            return
        count = f"{len(rows)} markings enable" if len(rows) > 1 else "one marking enables"
        words = f"{count} only changes of signals"
        witness = witness_of(known.subject, known.explored.way_to(int(rows[0])))
        known.report.findings.append(self.STUCK.found(known.identity, witness=witness, markings=words))


def _final(known: TimedChecked) -> FinalCondition | None:
    try:
        return FinalCondition.of(known.subject)
    except FormulaError as error:
        what = "the final condition of the model"
        found = Properties.UNREADABLE.found(known.identity, property=what, reason=error)
        known.report.findings.append(found)
        return None


def _groups(known: TimedChecked, ends: list[Trace]) -> Iterator[DeadlockGroup]:
    """Yield the ends, each given by a way there, with the same causes as one group each."""
    final = _final(known)
    found: dict[object, DeadlockGroup] = {}
    for trace in ends[:MOST_LOOKED_AT]:
        group = group_at(known.subject, trace, final)
        key = (group.causes, group.unfinished, group.is_final)
        first = found.get(key)
        found[key] = group if first is None else replace(first, markings=first.markings + 1)
    yield from found.values()
    if len(ends) > MOST_LOOKED_AT:
        group = group_at(known.subject, ends[MOST_LOOKED_AT], final)
        yield replace(group, markings=len(ends) - MOST_LOOKED_AT, is_rest=True)


def _quiet(
    subject: TimedSubject, markings: np.ndarray[tuple[int, ...], np.dtype[np.int64]]
) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    """Return the markings that enable nothing but changes of signals, if signals are left out."""
    ids = {
        link.target.id
        for link in subject.links()
        if any(isinstance(source, sym.InputSignal) for source in link.sources)
    }
    net = subject.timed
    of_signals = {subject.place_index[id] for id in ids if id in subject.place_index}
    quiet = np.ones(len(markings), dtype=np.bool_)
    for transition, name in enumerate(net.untimed.transitions):
        if name in ids:
            continue
        enabled = np.ones(len(markings), dtype=np.bool_)
        for place, weight in net.test.row(transition):
            if place not in of_signals:
                enabled &= markings[:, place] >= weight
        for place, weight in net.untimed.inhibitor.row(transition):
            enabled &= markings[:, place] < weight
        quiet &= ~enabled
    return np.flatnonzero(quiet)
