"""Whether a net with times is bounded, and what its places hold: all other answers rest on its classes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.stages import Share, Stage, run_stages
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
from dineros.metamodel.errors import counted
from dineros.metamodel.guards.using import guarded

FIRST = Share(time=0.1, most_seconds=5.0)
"""Share in which the classes of most nets are all built."""

ALL_SECONDS = 300.0
"""Seconds for all that is left if there are more classes, and no other limit of time."""

PART = Share(most_seconds=5.0)
"""Limit of each part of the net."""

FAR = Share(time=0.4)
"""Share of a depth-first search."""


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


@dataclass
class _TimedFacts:
    """What is known of the net so far."""

    known: TimedChecked
    explored: Explored
    proof: WithoutTimes | None = None

    def __post_init__(self) -> None:
        self.found = _firings(self.explored)
        self.ways = [f"state classes with times, compared by inclusion ({self.explored.kind})"]

    @property
    def grows(self) -> bool:
        """Whether places grow without bound."""
        return self.explored.growth is not None

    @property
    def needs_classes(self) -> bool:
        """Whether state classes would add something: only they decide whether callbacks always end."""
        net, found, proof = self.explored.net, self.found, self.proof
        return not (
            proof is not None
            and proof.most is not None
            and found.has_no_deadlock
            and not self.known.waiting.callbacks
            and not any(map(found.is_open, range(len(net.intervals))))
            and time_goes_on(net)
        )

    def bound_responses(self, budget: Budget) -> None:
        """Note what bounds of response times exclude, and say so: they are there for models of any size."""
        from dineros.analysis.bounds.losses import never_lost

        subject = self.known.subject
        with self.known.guarded(None):
            if guarded(subject.model):
                return
            excluded = {subject.transition_index[name] for name in never_lost(subject)}
            excluded -= self.found.traces.keys()
            self.found.dead |= excluded
            self.ways += ["bounds of response times"] if excluded else []

    def walk(self, budget: Budget) -> None:
        """Note what random runs meet."""
        self.ways.append("random runs")
        run_stages(self, WALKS, budget, given_up=())
        for transition, way in self.known.walked.ways.items():
            self._note_way(transition, way)

    def walk_soon(self, budget: Budget) -> None:
        """Fire each transition as soon as it may fire, or at random."""
        self.known.walked = walk_in_time(self.known.timed.timed, budget)

    def walk_late(self, budget: Budget) -> None:
        """Fire transitions as late as possible."""
        walk_late(self.known.timed.timed, self.known.walked, budget)

    def walk_towards(self, budget: Budget) -> None:
        """Walk to transitions that did not fire."""
        net, found = self.known.timed.timed, self.found
        unmet = set(range(len(net.intervals))) - found.traces.keys() - found.dead
        walk_towards(net, sorted(unmet), self.known.walked, budget)

    def ask_without_times(self, budget: Budget) -> None:
        """Note what the net without its times proves."""
        self.ways.append("the net without its times")
        subject, found = self.known.timed, self.found
        self.proof = proof = without_times(subject, budget, self.known.orders)
        found.dead |= {subject.transition_index[name] for name in proof.dead} - found.traces.keys()
        # Priorities in a circle keep each other from firing.
        is_free = not any(t in above for t, above in enumerate(self.explored.net.above))
        found.has_no_deadlock = proof.has_no_deadlock and is_free

    def ask_parts(self, budget: Budget) -> None:
        """Add what never fires in the part of the net that decides."""
        net, found = self.known.timed.timed, self.found
        asked: dict[frozenset[int], frozenset[int]] = {}
        before = len(found.dead)
        for transition in range(len(net.intervals)):
            if not found.is_open(transition) or budget.is_over:
                continue
            part = part_of_firing(net, transition)
            if part is None:
                continue
            if part.own not in asked:
                seen = explore_timed(part.net, PART.share(budget))
                asked[part.own] = part.own - seen.ways.keys() if seen.is_complete else frozenset()
            found.dead |= asked[part.own] - found.traces.keys()
        if len(found.dead) > before:
            self.ways.append("parts of the net")

    def add_classes(self, budget: Budget) -> None:
        """Build more classes, and add what they show about firings."""
        known = self.found
        self.explored = explore_timed(self.known.timed.timed, budget, self.explored)
        self.found = _firings(self.explored)
        if self.found.is_complete:
            self.ways = self.ways[:1]
            return
        for transition, way in known.traces.items():
            self._note_way(transition, way)
        self.found.dead |= known.dead - self.found.traces.keys()
        self.found.has_no_deadlock = known.has_no_deadlock

    def _note_way(self, transition: int, way: tuple[int, ...]) -> None:
        traces = self.found.traces
        if transition not in traces or len(way) < len(traces[transition]):
            traces[transition] = way


WALKS = (
    Stage(_TimedFacts.walk_soon),
    Stage(_TimedFacts.walk_late, time=0.5),
    Stage(_TimedFacts.walk_towards),
)
"""Random runs with times."""

PLAN = (
    Stage(_TimedFacts.bound_responses),
    Stage(_TimedFacts.walk, lambda facts: not facts.grows, time=0.1),
    Stage(_TimedFacts.ask_without_times, lambda facts: not facts.grows, time=0.4, most_seconds=120.0),
    Stage(_TimedFacts.ask_parts, lambda facts: not facts.grows, time=0.15),
    Stage(_TimedFacts.add_classes, lambda facts: not facts.grows and facts.needs_classes, time=0.6),
)
"""What is asked if there are many classes."""


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
        facts = _TimedFacts(known, explore_timed(known.timed.timed, FIRST.share(checked.budget)))
        if not facts.explored.is_complete:
            # Without a limit, the classes of a large net would be built until the memory is full.
            checked.budget = checked.budget.unless_limited(ALL_SECONDS)
            run_stages(facts, PLAN, checked.budget, given_up=())
        explored, found = facts.explored, facts.found
        known.explored, known.firings = explored, found
        self._report(known, explored, facts.ways, facts.proof)
        if explored.growth is None and any(map(found.is_open, range(len(explored.net.intervals)))):
            ways, others = fire_far_away(explored.net, {*found.traces, *found.dead}, FAR.share(known.budget))
            found.traces.update(ways)
            found.possible |= others

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
                f"at most {counted(int(markings.max(initial=0)), 'token')} in a place"
            )
        elif proof is not None and proof.most is not None:
            how, count = ("even without", f"{proof.markings} markings, ") if proof.markings else ("with", "")
            report.proved.append(
                f"the net is bounded {how} its times: {count}"
                f"at most {counted(proof.most, 'token')} in a place"
            )
        else:
            known.leave_open("whether the net is bounded", explored.reason)


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
