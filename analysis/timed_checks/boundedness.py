"""Whether a net with times is bounded, and what its places hold: all other answers rest on its classes."""

from __future__ import annotations

import numpy as np

from dineros.analysis.checks.boundedness import Boundedness, Places
from dineros.analysis.checks.question import Checked, Question
from dineros.analysis.covering.firings import Firings
from dineros.analysis.timed.exploring import Explored, explore_timed, fire_far_away
from dineros.analysis.timed.reductions.parts import part_of_firing
from dineros.analysis.timed_checks.timed_checked import TimedChecked, with_times
from dineros.analysis.timed_checks.timed_walks import walk_in_time, walk_late, walk_towards
from dineros.analysis.timed_checks.without_times import WithoutTimes, time_goes_on, without_times
from dineros.analysis.witnesses.witness import pumping_witness
from dineros.metamodel import sym
from dineros.metamodel.guards.using import guarded

FIRST_SHARE, FIRST_SECONDS = 0.1, 5.0
"""Part of the time, and seconds at most, in which the classes of most nets are all built."""

ALL_SECONDS = 300.0
"""Seconds for all that is left if there are more classes, and no other limit of time."""

WALKS_SHARE, UNTIMED_SHARE, UNTIMED_SECONDS = 0.1, 0.4, 120.0
"""Parts of what is left for random runs and for the net without its times, and seconds at most for that."""

PARTS_SHARE, PART_SECONDS = 0.15, 5.0
"""Part of what is left then for parts of the net, and seconds at most for each."""

CLASSES_SHARE, FAR_SHARE = 0.6, 0.4
"""Parts of the remaining time for the classes, and for a depth-first search."""


class TimedBoundedness(Question):
    """Whether the net is bounded with its times. The search ends if it is; a loop shows that it is not."""

    faults = (Boundedness.UNBOUNDED,)
    asks = "all questions on the state classes"
    is_basis = True

    def leave_open(self, checked: Checked, reason: str) -> None:
        """End the search here, as the other questions need the state space."""
        checked.close(self.asks, reason)

    def ask(self, checked: Checked) -> None:
        """Build the classes, and record which transitions fire in them."""
        known = with_times(checked)
        net, first = known.timed.timed, checked.budget.share(FIRST_SHARE)
        explored = explore_timed(net, first.at_most(FIRST_SECONDS))
        found = _firings(explored)
        ways = [f"state classes with times, compared by inclusion ({explored.kind})"]
        proof: WithoutTimes | None = None
        if not explored.is_complete:
            # Without a limit, the classes of a large net would be built until the memory is full.
            checked.budget = checked.budget.unless_limited(ALL_SECONDS)
            with checked.guarded(None):
                ways += self._bound_responses(checked, found)
        if not explored.is_complete and explored.growth is None:
            ways += ["random runs", "the net without its times"]
            self._walk(known, found)
            proof = self._ask_without_times(known, explored, found)
            if self._ask_parts(known, found):
                ways.append("parts of the net")
            if not _is_all_known(known, explored, found, proof):
                explored = explore_timed(net, checked.budget.share(CLASSES_SHARE), explored)
                found, ways = _with_classes(explored, found, ways)
        known.explored, known.firings = explored, found
        self._report(known, explored, ways, proof)
        if explored.growth is None and any(map(found.is_open, range(len(net.intervals)))):
            self._look_far(known, explored, found)

    @staticmethod
    def _report(known: TimedChecked, explored: Explored, ways: list[str], proof: WithoutTimes | None) -> None:
        """Put into the report whether the net is bounded, and how that became known."""
        subject, report = known.timed, known.report
        report.by = "; ".join(ways)
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
        elif proof is not None and proof.most is not None:
            how, count = ("even without", f"{proof.markings} markings, ") if proof.markings else ("with", "")
            report.proved.append(
                f"the net is bounded {how} its times: {count}at most {proof.most} tokens in a place"
            )
        else:
            known.leave_open("whether the net is bounded", explored.reason)

    @staticmethod
    def _bound_responses(checked: Checked, found: Firings) -> list[str]:
        """Note what bounds of response times exclude, and say so: they are there for models of any size."""
        from dineros.analysis.bounds.losses import never_lost

        if guarded(checked.subject.model):
            return []
        excluded = {checked.subject.transition_index[name] for name in never_lost(checked.subject)}
        excluded -= found.traces.keys()
        found.dead |= excluded
        return ["bounds of response times"] if excluded else []

    @staticmethod
    def _walk(known: TimedChecked, found: Firings) -> None:
        """Note what random runs meet."""
        net, budget = known.timed.timed, known.budget.share(WALKS_SHARE)
        known.walked = walk_in_time(net, budget)
        walk_late(net, known.walked, budget.share(0.5))
        unmet = set(range(len(net.intervals))) - found.traces.keys() - found.dead
        walk_towards(net, sorted(unmet), known.walked, budget)
        for transition, way in known.walked.ways.items():
            if transition not in found.traces or len(way) < len(found.traces[transition]):
                found.traces[transition] = way

    @staticmethod
    def _ask_without_times(known: TimedChecked, explored: Explored, found: Firings) -> WithoutTimes:
        """Note what the net without its times proves, and return it."""
        subject = known.timed
        budget = known.budget.share(UNTIMED_SHARE).at_most(UNTIMED_SECONDS)
        proof = without_times(subject, budget, known.orders)
        found.dead |= {subject.transition_index[name] for name in proof.dead} - found.traces.keys()
        # Priorities in a circle keep each other from firing.
        is_free = not any(t in above for t, above in enumerate(explored.net.above))
        found.has_no_deadlock = proof.has_no_deadlock and is_free
        return proof

    @staticmethod
    def _ask_parts(known: TimedChecked, found: Firings) -> bool:
        """Add what never fires in the part of the net that decides; return whether there is anything."""
        net, budget = known.timed.timed, known.budget.share(PARTS_SHARE)
        asked: dict[frozenset[int], frozenset[int]] = {}
        before = len(found.dead)
        for transition in range(len(net.intervals)):
            if not found.is_open(transition) or budget.is_over:
                continue
            part = part_of_firing(net, transition)
            if part is None:
                continue
            if part.own not in asked:
                seen = explore_timed(part.net, budget.at_most(PART_SECONDS))
                asked[part.own] = part.own - seen.ways.keys() if seen.is_complete else frozenset()
            found.dead |= asked[part.own] - found.traces.keys()
        return len(found.dead) > before

    @staticmethod
    def _look_far(checked: Checked, explored: Explored, found: Firings) -> None:
        """Note what fires far from the beginning."""
        share = checked.budget.share(FAR_SHARE)
        ways, others = fire_far_away(explored.net, {*found.traces, *found.dead}, share)
        found.traces.update(ways)
        found.possible |= others


def _is_all_known(known: TimedChecked, explored: Explored, found: Firings, proof: WithoutTimes) -> bool:
    """Return whether state classes would add nothing: only they decide whether callbacks always end."""
    return (
        proof.most is not None
        and found.has_no_deadlock
        and not known.waiting.callbacks
        and not any(map(found.is_open, range(len(explored.net.intervals))))
        and time_goes_on(explored.net)
    )


def _with_classes(explored: Explored, found: Firings, ways: list[str]) -> tuple[Firings, list[str]]:
    """Add what further classes show about firings, and which engine showed it."""
    told = _firings(explored)
    if told.is_complete:
        return told, ways[:1]
    for transition, way in found.traces.items():
        if transition not in told.traces or len(way) < len(told.traces[transition]):
            told.traces[transition] = way
    told.dead |= found.dead - told.traces.keys()
    told.has_no_deadlock = found.has_no_deadlock
    return told, ways


def _firings(explored: Explored) -> Firings:
    """Return what the classes show about firings, in the form for questions about queues and the like."""
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
