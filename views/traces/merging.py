"""Merges the records of several nodes by time, but never a message before its sending.

The clocks of two machines differ, and a node records a message only after it was sent. So a record that
receives a message waits until the one that sent it has passed, whatever the times say.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping

from dineros.metamodel.records import EVENTS, Record

_RECEIVES = {
    kind: kind.declared.receives
    for kind in EVENTS.values()
    if kind.declared.receives and "number" not in kind.__dataclass_fields__
}
"""Messages between nodes: the event of the record that sends it, by the kind that receives it.

Feedback is omitted: the id of its goal does not distinguish the messages.
"""
_SENDS = frozenset(_RECEIVES.values())


class Merger:
    """Takes records of nodes and returns them as one sequence.

    Parameters
    ----------
    nodes : iterable of str
        The nodes whose records will come; a message of any other node does not wait.
    expected : set of (str, str), optional
        All messages that are sent, if known: a record that receives another message does not wait.
    """

    def __init__(self, nodes: Iterable[str], expected: set[tuple[str, str]] | None = None) -> None:
        self._queues: dict[str, deque[Record]] = {node: deque() for node in nodes}
        self._expected = expected
        self._sent: set[tuple[str, str]] = set()

    def push(self, node: str, record: Record) -> None:
        """Take a node's next record."""
        self._queues.setdefault(node, deque()).append(record)

    @property
    def waiting(self) -> bool:
        """Whether there are waiting records."""
        return any(self._queues.values())

    def ready(self, *, force: bool = False) -> Iterator[tuple[str, Record]]:
        """Yield the records that no longer have to wait, the earliest first.

        Parameters
        ----------
        force : bool
            Release records whose message was sent by a missing record, which was lost or is not in the files.
        """
        while True:
            heads = [(self._time(queue[0]), node) for node, queue in self._queues.items() if queue]
            free = [head for head in heads if not self._waits(self._queues[head[1]][0])]
            if not (free or (heads and force)):
                return
            node = min(free or heads)[1]
            record = self._queues[node].popleft()
            sent = _sent_by(record)
            if sent:
                self._sent.add(sent)
            yield node, record

    def _waits(self, record: Record) -> bool:
        receives = _RECEIVES.get(type(record))
        message = getattr(record, "message", None)
        if not receives or not message or (receives, message) in self._sent:
            return False
        if self._expected is not None:
            return (receives, message) in self._expected
        # A response has the id of its request, and so the name of the client, not of the server.
        return receives == "reply" or message.split("/")[0].split("@")[0] in self._queues

    @staticmethod
    def _time(record: Record) -> float:
        return record.time if record.time is not None else 0.0


def merge(traces: Mapping[str, Iterable[Record]]) -> Iterator[tuple[str, Record]]:
    """Yield the records of complete traces, by node, as one sequence.

    Parameters
    ----------
    traces : mapping of str to iterable of Record
        The records of each node in their order.
    """
    if len(traces) == 1:
        yield from ((node, record) for node, records in traces.items() for record in records)
        return
    kept = {node: list(records) for node, records in traces.items()}
    expected = {sent for records in kept.values() for sent in map(_sent_by, records) if sent}
    merger = Merger(kept, expected)
    for node, records in kept.items():
        for record in records:
            merger.push(node, record)
    yield from merger.ready(force=True)


def _sent_by(record: Record) -> tuple[str, str] | None:
    message = getattr(record, "message", None)
    return (record.event, message) if record.event in _SENDS and message else None
