"""Measures the times in traces of nodes of DiNeROS: all nodes together, in the order of their clocks.

A message was not in the history of its reader while the node was idle and its place was empty: it would have
been taken. So its latency is at least the time from its publication to the last such moment before it was
taken, and at most the time until then. A timer that struck while its node was idle would have begun its
callback.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from heapq import merge

from dineros.metamodel import sym
from dineros.metamodel.records import (
    Aside,
    Checkpoint,
    Error,
    Fire,
    Header,
    Lifecycle,
    Publish,
    Record,
    Reply,
    Request,
    Response,
    Serve,
    Start,
    Take,
)
from dineros.metamodel.records.steps import Step
from dineros.observation.measuring.bodies import Bodies
from dineros.observation.measuring.idling import CLOSE, Spans, idle_before
from dineros.observation.measuring.node_runs import NodeRuns
from dineros.observation.measuring.seen import Part, Seen

Trace = Callable[[], Iterable[Record]]
_MOST_SENT = 1 << 17
"""Limit of the remembered publications; the oldest are discarded."""
_BEGINS = (Start, Error, Aside, Lifecycle)


class JournalTimes:
    """Reads the times of a run.

    Parameters
    ----------
    model : sym.SystemModel
        The model that was run.
    traces : mapping of str to callable
        By node net, a function that reads its records.
    """

    def __init__(self, model: sym.SystemModel, traces: Mapping[str, Trace]) -> None:
        bodies = Bodies(model)
        self._traces = traces
        self._nodes = {node: NodeRuns(bodies) for node in traces}
        self._places = {
            node: {place: Spans() for place in sorted(bodies.readers.get(node, ()))} for node in traces
        }
        self._last: dict[str, float] = {}
        self._held: dict[tuple[str, str], int] = {}
        self._sent: dict[tuple[str, str, str], tuple[float, str]] = {}
        self._missed: dict[tuple[str, str, str], list[Record]] = {}
        self.begun: float | None = None
        """Time of the first record."""
        self.is_simulated = False
        """Whether the run was simulated, so that the times of its records are not measurements."""

    def seen(self) -> Iterator[Seen]:
        """Yield each time that the traces show; none of a simulated run.

        Raises
        ------
        RecordError
            A line of a trace is not a record.
        """
        streams = (_timed(trace()) for trace in self._traces.values())
        for record in merge(*streams, key=lambda each: each.time or 0.0):
            if isinstance(record, Header):
                self.is_simulated |= record.simulated
                continue
            if self.is_simulated:
                return
            if self.begun is None:
                self.begun = record.time
            yield from self._of(record)

    def _of(self, record: Record) -> Iterator[Seen]:
        node, moment = record.node or "", record.time or 0.0
        runs = self._nodes.get(node)
        if runs is None:
            return
        if moment < self._last.get(node, moment) - CLOSE:  # a clock was set back
            runs.begin(moment)
        self._last[node] = moment
        if isinstance(record, _BEGINS):
            if isinstance(record, Start):
                self._mark(node, record)
            if not isinstance(record, Checkpoint):
                runs.begin(moment)
            return
        if isinstance(record, Fire):
            yield from runs.fire(record)
        elif isinstance(record, Publish):
            yield from self._send("publish", record.place, record)
        elif isinstance(record, Request):
            runs.request(record)
            yield from self._send("request", record.client or "", record)
        elif isinstance(record, Reply):
            yield from self._send("reply", "", record)
        elif isinstance(record, Take):
            yield from self._arrive("publish", record)
        elif isinstance(record, Serve):
            yield from self._arrive("request", record)
        elif isinstance(record, Response):
            runs.response(record)
            yield from self._arrive("reply", record)
        if isinstance(record, Step):
            self._change(node, record, moment)

    def _mark(self, node: str, record: Start) -> None:
        """Record which places of messages hold tokens at the start."""
        for place, spans in self._places[node].items():
            self._held[node, place] = len(record.marking.get(place, ()))
            if self._held[node, place]:
                spans.begin(record.time or 0.0)

    def _change(self, node: str, record: Step, moment: float) -> None:
        spans = self._places[node]
        for place, change in record.change.items():
            if place in spans:
                held = self._held[node, place] = max(0, self._held.get((node, place), 0) + change)
                if held:
                    spans[place].begin(moment)
                else:
                    spans[place].end(moment)

    def _send(self, kind: str, writer: str, record: Publish | Request | Reply) -> Iterator[Seen]:
        if record.message is None:
            return
        key = kind, record.channel, record.message
        if len(self._sent) >= _MOST_SENT:
            del self._sent[next(iter(self._sent))]
        self._sent[key] = record.time or 0.0, writer
        # With clocks that differ, a message can be taken before it was sent.
        for taken in self._missed.pop(key, ()):
            yield self._transfer(key, taken, is_ordered=False)

    def _arrive(self, kind: str, record: Take | Serve | Response) -> Iterator[Seen]:
        if record.message is None:
            return
        key = kind, record.channel, record.message
        if key in self._sent:
            yield self._transfer(key, record, is_ordered=True)
            return
        if len(self._missed) >= _MOST_SENT:
            del self._missed[next(iter(self._missed))]
        self._missed.setdefault(key, []).append(record)

    def _transfer(self, key: tuple[str, str, str], record: Record, *, is_ordered: bool) -> Seen:
        kind, channel, _ = key
        sent, writer = self._sent[key]
        node, moment = record.node or "", record.time or 0.0
        place, client = getattr(record, "place", ""), getattr(record, "client", None)
        least, runs = -math.inf, self._nodes[node]
        # A request can wait for a free instance of its server, for an unknown time.
        if is_ordered and kind != "request" and sent >= runs.since:
            spans = self._places[node].get(place)
            least = idle_before(moment, *([runs.busy] if spans is None else [runs.busy, spans])) - sent
        if kind == "publish":
            part = Part("latency", channel, writer, place)
        else:
            part = Part("latency", channel, str(client or writer), kind)
        return Seen(part, least, moment - sent, moment, record)


def _timed(records: Iterable[Record]) -> Iterator[Record]:
    """Yield the header, and the records that have a time."""
    return (each for each in records if isinstance(each, Header) or each.time is not None)
