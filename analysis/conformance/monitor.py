"""Conformance while the nodes run: records are replayed as they arrive."""

from __future__ import annotations

from collections.abc import Iterable

from dineros.analysis.conformance.beginnings import begin_within, beginnings
from dineros.analysis.conformance.conform import finish
from dineros.analysis.conformance.merging import Feed, Merger
from dineros.analysis.conformance.net import ConformanceNet
from dineros.analysis.conformance.reasons import step_words
from dineros.analysis.conformance.replay import Replay
from dineros.analysis.conformance.settling import settle_waiting
from dineros.analysis.conformance.topics.fates import Fates
from dineros.analysis.conformance.verdict import Deviation, Verdict
from dineros.metamodel import sym
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.records import Drop, Publish, Record, Take

MOST_HELD = 1000
"""Records of a node that may arrive while it waits at a loss that only complete traces explain."""


class Monitor:
    """Replays the records of a run as they arrive, those of each node in order, the nodes in any order.

    A step with a message waits until the message was sent. Records are removed once they are replayed, so
    that the monitor does not grow with the run. The monitor cannot undo the take of a message when the
    publisher's trace later reports that another message was lost from a full queue: such a loss is `unknown`
    here, and `conform` decides it afterwards. The same applies to a loss from a history of several publishers
    that is reported after later messages were taken. Under the rules of ROS 2, a publisher with full
    histories waits here until its subscribers' records show which messages they took.

    Parameters
    ----------
    model : sym.SystemModel
        The model that is run.

    Examples
    --------
    >>> from dineros.metamodel.records import Header
    >>> page = sym.NodeNet(id="node")
    >>> monitor = Monitor(sym.SystemModel(id="model", pages=[page]))
    >>> monitor.add([Header(sequence=0, kind="run", model="other", node="node")])[0].reason
    "the trace is of model 'other', not of 'model'"
    """

    def __init__(self, model: sym.SystemModel) -> None:
        self._net = ConformanceNet(model)
        self._fates = Fates()
        self._replay = Replay(self._net, fates=self._fates)
        self._has_histories = model.middleware == sym.Middleware.ros2
        self._feeds = {node: Feed() for node in self._net.nodes}
        self._merger = Merger(
            self._replay, self._feeds, takes_last=self._has_histories, is_dropped=self._is_dropped
        )
        self._merger.forces = False
        self._verdict = Verdict()
        self._told: set[str] = set()
        self._finished = False
        self._heard: set[str] = set()

    @property
    def steps(self) -> int:
        """Number of replayed records."""
        return self._replay.steps

    @property
    def waiting(self) -> dict[str, Record]:
        """For each waiting node, the record at which it waits."""
        return {node: record for node, (record, _) in self._merger.waiting.items()}

    def add(self, records: Iterable[Record]) -> list[Deviation]:
        """Add records and return the steps that are not allowed.

        A node whose step is not allowed is not replayed any further.

        Raises
        ------
        DinerosError
            A record belongs to no node of the model.
        """
        records = list(records)
        if records and not self._heard:
            self._begin(records)
        for record in records:
            feed = self._feeds.get(record.node or "")
            if feed is None:
                raise DinerosError(f"the model has no node net {record.node!r}", location=record.location)
            self._heard.add(record.node or "")
            if isinstance(record, (Publish, Take, Drop)) and self._has_histories:
                self._fates.add(record)
            if record.node not in self._told:
                feed.add(record)
        return self._advance()

    def _begin(self, records: Iterable[Record]) -> None:
        """Begin at the first records, which may belong to a run that continues."""
        by_node: dict[str, list[Record]] = {}
        for record in records:
            by_node.setdefault(record.node or "", []).append(record)
        found = beginnings(by_node)
        if found:
            begin_within(self._replay, found)

    def finish(self) -> Verdict:
        """Return the verdict on all records; no further records may follow."""
        self._finished = self._fates.are_known = self._merger.forces = True
        self._advance()
        for node in set(self._feeds) - self._heard:
            del self._feeds[node]
        if not self._verdict.violations:
            settle_waiting(self._merger, self._verdict)
        return finish(self._verdict, self._net, self._replay)

    def _advance(self) -> list[Deviation]:
        found = []
        self._merger.retry()
        while True:
            self._merger.advance()
            skipped = self._pass_over_losses()
            for node, (record, fault) in list(self._merger.failed.items()):
                if node in self._told:
                    continue
                if fault.queue is None:
                    deviation = Deviation(record, step_words(record), fault.reason)
                    self._told.add(node)
                    self._verdict.violations.append(deviation)
                    found.append(deviation)
                else:
                    self._pass_over(node, record, fault.reason)
                    skipped = True
            if not skipped:
                return found

    def _pass_over(self, node: str, record: Record, reason: str) -> None:
        """Leave a loss to `conform`, and continue after it."""
        self._verdict.unknown.append(Deviation(record, step_words(record), reason))
        self._replay.topics.lose(record)
        self._merger.skip(node)

    def _pass_over_losses(self) -> bool:
        """Pass over losses that only whole traces explain; return whether there were any."""
        passed = False
        for node, (record, waiting) in list(self._merger.waiting.items()):
            if waiting.in_hindsight and (self._finished or self._feeds[node].held > MOST_HELD):
                self._pass_over(node, record, waiting.reason)
                passed = True
        return passed

    def _is_dropped(self, feed: Feed, record: Publish) -> bool | None:
        """Return whether the next record reports the message as lost; only a full queue loses messages."""
        if not self._replay.topics.is_full(record):
            return False
        following = feed.following()
        if following is None:
            return False if self._finished else None
        return (
            isinstance(following, Drop)
            and (following.queue, following.channel, following.place)
            == ("publisher", record.channel, record.place)
            and not any(following.change.values())
        )
