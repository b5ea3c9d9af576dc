"""Decides whether the traces of a run are a behaviour of the model, with complete traces."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from random import Random

from dineros.analysis.conformance.beginnings import begin_within, beginnings
from dineros.analysis.conformance.merging import Feed, Merger
from dineros.analysis.conformance.net import ConformanceNet
from dineros.analysis.conformance.pasts import Past, Pasts
from dineros.analysis.conformance.reasons import step_words
from dineros.analysis.conformance.replay import Replay
from dineros.analysis.conformance.settling import settle_waiting
from dineros.analysis.conformance.topics.fates import Fates
from dineros.analysis.conformance.verdict import Deviation, Verdict
from dineros.metamodel import sym
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.records import Drop, Header, Publish, Record, Take

Trace = Callable[[], Iterable[Record]]
"""Reads all records of a node from the beginning, at each call."""

ATTEMPTS = 50
"""Maximum number of orders tried if publishers' queues dropped messages, or messages have no ids."""


def conform(
    model: sym.SystemModel, traces: Mapping[str, Trace], attempts: int = ATTEMPTS, firings: bool = False
) -> Verdict:
    """Replay the traces of a run on the flattened net.

    Each recorded step must be a firing that the net allows, in some order that keeps the order of each node,
    and in which no message is received before it was sent. Steps inside of channels are inferred.

    Parameters
    ----------
    model : sym.SystemModel
        The model that was run.
    traces : dict of str to callable
        For each node net, a function that reads its records.
    attempts : int
        Maximum number of orders tried if publishers' queues dropped messages, or if servers do not know the
        clients of requests; beyond it, the result is unknown.
    firings : bool
        Whether the verdict contains the sequence of firings.

    Raises
    ------
    DinerosError
        A trace belongs to a node that the model does not have; or it begins in the middle of a run, without a
        checkpoint or with messages without ids.
    RecordError
        A line of a trace is not a record.
    """
    return _Conformance(ConformanceNet(model), traces, attempts, firings).run()


@dataclass
class _Survey:
    """Facts about a trace, collected before the replay."""

    lost: set[int] = field(default_factory=set)
    """Positions of the messages that the publisher's queue dropped."""
    drops: bool = False


@dataclass(frozen=True)
class _DropToReach:
    """A message that a publisher's queue dropped, for which a special order is needed."""

    node: str
    position: int
    channel: str
    queue: str
    deviation: Deviation


class _Conformance:
    def __init__(
        self, net: ConformanceNet, traces: Mapping[str, Trace], attempts: int, firings: bool
    ) -> None:
        self._net = net
        self._traces = traces
        self._attempts = attempts
        self._firings = firings
        for node in traces:
            if node not in net.nodes:
                said = f"the model has no node net {node!r}"
                raise DinerosError(said, hint="it may not be the model that was run")
        self._generous: set[tuple[str, int]] = set()
        self._beginnings = beginnings({node: trace() for node, trace in traces.items()})
        self._fates = Fates()
        self._surveys = {
            node: _survey(net.model, node, trace(), self._fates) for node, trace in traces.items()
        }
        self._fates.are_known = True

    def run(self) -> Verdict:
        goals: list[_DropToReach] = []
        hopeless: dict[tuple[str, int], tuple[bool, Deviation]] = {}
        for attempt in range(self._attempts + 1):
            merger, stuck = self._attempt(goals)
            missed = stuck or self._missed(merger, hopeless)
            if missed is None:
                break
            key = (missed.node, missed.position)
            if attempt == self._attempts:
                hopeless[key] = (False, _undecided(missed, f"{attempt} orders were tried"))
            elif not self._possible_alone(missed):
                known = self._past(missed).is_certain
                why = "the earlier messages are unknown"
                hopeless[key] = (True, missed.deviation) if known else (False, _undecided(missed, why))
            elif stuck and goals[0] is not missed:
                goals.remove(missed)
                goals.insert(0, missed)
            elif stuck:
                hopeless[key] = (False, _undecided(missed, "no order of events explains all losses"))
            else:
                goals.append(missed)
            if key in hopeless:
                goals = [goal for goal in goals if (goal.node, goal.position) != key]
        if _is_unclear(merger):
            merger = self._in_another_order(merger, goals)
        return self._verdict(merger, hopeless)

    def _in_another_order(self, merger: Merger, goals: list[_DropToReach]) -> Merger:
        """Draw orders of calls whose servers do not know the clients, until one fits."""
        for seed in range(self._attempts):
            other, stuck = self._attempt(goals, Random(seed))
            if stuck is None and not _is_unclear(other) and other.failed.keys() == merger.failed.keys():
                return other
        return merger

    def _attempt(
        self, goals: list[_DropToReach], draw: Random | None = None
    ) -> tuple[Merger, _DropToReach | None]:
        """Replay, reaching the goals first; return the goal that was not reached, if any."""
        merger = self._merger([(goal.channel, goal.queue) for goal in goals], draw)
        for goal in goals:
            if not self._reach(merger, goal):
                return merger, goal
        merger.advance()
        return merger, None

    def _possible_alone(self, goal: _DropToReach) -> bool:
        """Return whether a message can be lost if only its causal past has happened."""
        keep = [(goal.channel, goal.queue)]
        if self._reach(self._merger(keep), goal):
            return True
        if self._past(goal).is_certain:
            return False
        self._generous.add((goal.node, goal.position))
        return self._reach(self._merger(keep), goal)

    def _reach(self, merger: Merger, goal: _DropToReach) -> bool:
        """Replay only the causal past of a loss, and the loss; return whether it was possible."""
        limits: dict[str, int] | None = self._past(goal).records
        if (goal.node, goal.position) in self._generous:
            limits = self._pasts.generous(self._past(goal).records, goal.channel, goal.node)
        while limits is not None:
            merger.advance(limits)
            if merger.feeds[goal.node].position > goal.position:
                return True
            waiting = [
                record
                for node, (record, _) in merger.waiting.items()
                if merger.feeds[node].position < limits[node]
            ]
            limits = self._pasts.extended(limits, waiting, (goal.node, goal.position))
        return False

    def _missed(self, merger: Merger, hopeless: Collection[tuple[str, int]]) -> _DropToReach | None:
        """Return a loss that is not possible in the chosen order."""
        for node, (record, fault) in merger.failed.items():
            position = merger.feeds[node].position
            if fault.queue is not None and (node, position) not in hopeless:
                assert isinstance(record, (Publish, Drop))
                deviation = Deviation(record, step_words(record), fault.reason)
                return _DropToReach(node, position, record.channel, fault.queue, deviation)
        return None

    def _merger(self, keep: Collection[tuple[str, str]], draw: Random | None = None) -> Merger:
        replay = Replay(self._net, keep, [] if self._firings else None, self._fates, draw)
        if self._beginnings:
            begin_within(replay, self._beginnings)
        return Merger(
            replay,
            {node: Feed(trace()) for node, trace in self._traces.items()},
            any(survey.drops for survey in self._surveys.values()),
            lambda feed, record: feed.position in self._surveys[record.node or ""].lost,
            draw,
        )

    def _past(self, goal: _DropToReach) -> Past:
        return self._pasts.of(goal.node, goal.position)

    @cached_property
    def _pasts(self) -> Pasts:
        return Pasts({node: trace() for node, trace in self._traces.items()})

    def _verdict(self, merger: Merger, hopeless: Mapping[tuple[str, int], tuple[bool, Deviation]]) -> Verdict:
        replay = merger.replay
        verdict = Verdict()
        for node, (record, fault) in merger.failed.items():
            known = hopeless.get((node, merger.feeds[node].position)) if fault.queue is not None else None
            certain, deviation = known or (True, Deviation(record, step_words(record), fault.reason))
            (verdict.violations if certain else verdict.unknown).append(deviation)
        if not verdict.violations:
            settle_waiting(merger, verdict)
        return finish(verdict, self._net, replay)


def finish(verdict: Verdict, net: ConformanceNet, replay: Replay) -> Verdict:
    """Sort the findings and set the result."""
    if not verdict.violations:
        verdict.violations.extend(
            Deviation(record, step_words(record), reason) for record, reason in replay.messages.lost()
        )
    verdict.unknown.extend(replay.values.unclear)
    for deviations in (verdict.violations, verdict.unknown):
        deviations.sort(key=lambda deviation: deviation.record.time or 0.0)
    return replace(
        verdict,
        status="violated" if verdict.violations else "unknown" if verdict.unknown else "conforms",
        steps=replay.steps,
        silent=replay.silent,
        sequence=[net.net.transitions[transition] for transition in replay.noted],
    )


def _is_unclear(merger: Merger) -> bool:
    return any(merger.is_unclear(node) for node in merger.waiting)


def _undecided(goal: _DropToReach, why: str) -> Deviation:
    found = goal.deviation
    return Deviation(found.record, found.step, f"{found.reason} in the orders tried: {why}")


def _survey(model: sym.SystemModel, node: str, records: Iterable[Record], fates: Fates) -> _Survey:
    survey = _Survey()
    has_histories = model.middleware == sym.Middleware.ros2
    published: dict[tuple[str, str], list[int]] = defaultdict(list)
    for position, record in enumerate(records):
        if isinstance(record, Header) and record.model != model.id:
            said = f"is a trace of model {record.model!r}, not of {model.id!r}"
            raise DinerosError(said, location=record.location)
        if record.node != node:
            said = f"a record of node {record.node!r} in the trace of node {node!r}"
            raise DinerosError(said, location=record.location)
        if has_histories and isinstance(record, (Publish, Take, Drop)):
            fates.add(record)
        if isinstance(record, Publish):
            published[record.channel, record.place].append(position)
        elif isinstance(record, Drop) and record.queue != "request":
            survey.drops = True
            if record.queue == "publisher" and not has_histories and not any(record.change.values()):
                sent = published[record.channel, record.place or ""]
                # The model loses the newest message. The numbers are the same regardless of which message
                # was lost.
                survey.lost.update(sent[-record.count :])
                del sent[-record.count :]
    return survey
