"""Whether a net with times is bounded, and what its places hold: all other answers rest on its classes."""

from __future__ import annotations

import numpy as np

from dineros.analysis.checks.boundedness import Boundedness, Places
from dineros.analysis.checks.question import Checked, Question
from dineros.analysis.covering.firings import Firings
from dineros.analysis.timed.exploring import Explored, explore_timed
from dineros.analysis.timed_checks.timed_checked import with_times
from dineros.analysis.witnesses.findings import pumping_witness
from dineros.metamodel import sym

CLASSES_SHARE = 0.6
"""Part of the time in which the classes are built; the rest is for properties and the like."""


class TimedBoundedness(Question):
    """Whether the net is bounded with its times. The search ends if it is; a loop shows that it is not."""

    faults = (Boundedness.UNBOUNDED,)
    asks = "all questions on the state classes"

    def leave_open(self, checked: Checked, reason: str) -> None:
        """End, as the others are asked of what is made here."""
        checked.close(self.asks, reason)

    def ask(self, checked: Checked) -> None:
        """Build the classes, and note what they say of firings."""
        known = with_times(checked)
        subject, report = known.timed, checked.report
        known.explored = explored = explore_timed(subject.timed, checked.budget.share(CLASSES_SHARE))
        report.by = f"state classes with times, compared by inclusion ({explored.kind})"
        if explored.growth is not None:
            grown = tuple(subject.place_text(place) for place in explored.growth.places)
            way = pumping_witness(subject, explored.growth)
            found = Boundedness.UNBOUNDED.found(*grown, witness=way, places=", ".join(grown))
            report.findings.append(found)
        elif explored.is_complete:
            markings = explored.markings
            report.proved.append(
                f"the net is bounded with its times: {len(markings)} markings, "
                f"at most {int(markings.max(initial=0))} tokens in a place"
            )
        else:
            checked.leave_open("whether the net is bounded", explored.reason)
        checked.firings = _firings(explored)


def _firings(explored: Explored) -> Firings:
    """Return what the classes tell of firings, as the questions about queues and the like read it."""
    ways = explored.ways
    is_all = explored.is_complete
    every = range(len(explored.net.untimed.transitions))
    return Firings(
        traces=dict(ways),
        dead={t for t in every if t not in ways} if is_all else set(),
        has_no_deadlock=is_all and not explored.ends,
        is_complete=is_all,
        reason=explored.reason,
    )


class TimedPlaces(Places):
    """Whether a place/transition net is one-safe with its times, and its marking stable."""

    def ask(self, checked: Checked) -> None:
        """Look at all markings."""
        explored = with_times(checked).explored
        if isinstance(checked.model, sym.SystemModel):
            return
        if not explored.is_complete:
            self.leave_open(checked, explored.reason)
            return
        markings, initial = explored.markings, checked.subject.net.initial
        crowded = np.flatnonzero(np.any(markings > 1, axis=0))
        still = np.flatnonzero(np.all(markings == initial, axis=0))
        self._say(checked, self.NOT_ONE_SAFE, crowded.tolist())
        self._say(checked, self.STABLE, still.tolist())
