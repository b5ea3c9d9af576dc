"""Causal pasts of steps: the earlier steps of the node, and the pasts of all messages it received."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

from dineros.metamodel.records import Drop, Publish, Record, Reply, Request, Response, Serve, Take
from dineros.metamodel.records.schema import ChannelStep

_COMES_FROM: dict[type[Record], type[Record]] = {
    Take: Publish,
    Drop: Publish,
    Serve: Request,
    Response: Reply,
}


@dataclass(frozen=True)
class Past:
    """A causal past."""

    records: dict[str, int]
    """Number of records of each node."""
    is_certain: bool
    """Whether it contains all necessary steps. It does not if a message has no id, or was lost at a receiver:
    then other messages must have been sent before, but it is unknown which.
    """


@dataclass(frozen=True)
class _Arrival:
    """A message of another node: its position, and the sending step; None: it is unknown."""

    position: int
    sent: tuple[str, int] | None
    is_certain: bool = True


class Pasts:
    """Causal pasts (Lamport's happened-before) in the traces of several nodes.

    `traces`: all records of each node.
    """

    def __init__(self, traces: Mapping[str, Iterable[Record]]) -> None:
        sent: dict[tuple[type[Record], str, str], tuple[str, int]] = {}
        nameless: set[tuple[type[Record], str]] = set()
        got: dict[str, list[tuple[int, ChannelStep | Drop]]] = {node: [] for node in traces}
        self._sent: defaultdict[tuple[type[Record], str], list[tuple[float, str, int]]] = defaultdict(list)
        self._lengths: dict[str, int] = {}
        for node, records in traces.items():
            position = -1
            for position, record in enumerate(records):
                if isinstance(record, Drop):
                    if record.queue not in ("publisher", "request"):
                        got[node].append((position, record))
                elif not isinstance(record, ChannelStep):
                    continue
                elif type(record) in _COMES_FROM:
                    got[node].append((position, record))
                else:
                    kind = type(record), record.channel
                    self._sent[kind].append((record.time or 0.0, node, position))
                    if record.message:
                        sent.setdefault((*kind, record.message), (node, position))
                    else:
                        nameless.add(kind)
            self._lengths[node] = position + 1
        self._got_of_channels = {
            node: [(position, record.channel) for position, record in arrivals]
            for node, arrivals in got.items()
        }
        for entries in self._sent.values():
            entries.sort()

        def arrival(position: int, record: ChannelStep | Drop) -> _Arrival:
            message = "" if isinstance(record, Drop) else record.message
            kind = _COMES_FROM[type(record)], record.channel
            found = sent.get((*kind, message or ""))
            return _Arrival(position, found, bool(found) or (bool(message) and kind not in nameless))

        self._arrivals = {
            node: [arrival(position, record) for position, record in arrivals]
            for node, arrivals in got.items()
        }

    def of(self, node: str, position: int) -> Past:
        """Return the past of a record of a node, including the record."""
        counts = dict.fromkeys(self._arrivals, 0)
        seen = dict.fromkeys(self._arrivals, 0)
        counts[node] = position + 1
        pending, is_certain = [node], True
        while pending:
            current = pending.pop()
            arrivals = self._arrivals[current]
            while seen[current] < len(arrivals) and arrivals[seen[current]].position < counts[current]:
                arrival = arrivals[seen[current]]
                seen[current] += 1
                is_certain &= arrival.is_certain
                if arrival.sent is None:
                    continue
                sender, at = arrival.sent
                if counts[sender] < at + 1:
                    counts[sender] = at + 1
                    pending.append(sender)
        return Past(counts, is_certain)

    def generous(self, limits: Mapping[str, int], channel: str, node: str) -> dict[str, int]:
        """Return a past in which the other nodes do more steps, but receive nothing on a topic channel.

        Their messages can only help: they can be lost or taken instead of messages that must stay in a queue.
        """
        later = dict(limits)
        for other in limits.keys() - {node}:
            got = (position for position, of in self._got_of_channels[other] if of == channel)
            later[other] = next(
                (position for position in got if position >= limits[other]), self._lengths[other]
            )
        return later

    def extended(
        self, limits: Mapping[str, int], waiting: Collection[Record], before: tuple[str, int]
    ) -> dict[str, int] | None:
        """Return a past extended by one message for which a step waits; None: there is none.

        Parameters
        ----------
        limits : dict of str to int
            The past, as the number of records of each node.
        waiting : collection of Record
            Steps in it that wait for messages without ids.
        before : (str, int)
            Node and position of a record that must not be included.
        """
        goal, at = before
        for record in waiting:
            source = _COMES_FROM.get(type(record))
            if source is None or not isinstance(record, (ChannelStep, Drop)):
                continue
            for _, node, position in self._sent[source, record.channel]:
                if position < limits[node]:
                    continue
                past = self.of(node, position).records
                if past[goal] <= at + 1:
                    return {name: max(count, past[name]) for name, count in limits.items()}
        return None
