"""The bars of calls of services, with the times of sending, taking, response and time-out.

A bar is on the lane of its client; a mark has its letter and the number of the call on its lane.
"""

from __future__ import annotations

from typing import Any

from dineros.metamodel import records as rec
from dineros.views.traces.facts import Facts
from dineros.views.traces.lanes import Lane, Lanes

_BEFORE = {"is served": "q", "is answered": "s", "ends": "r"}
"""The last mark of a call that a step of a kind follows."""


class CallBars:
    """Finds the bar of each record of a call."""

    def __init__(self, lanes: Lanes, facts: Facts) -> None:
        self._lanes, self._facts = lanes, facts
        self._call_of: dict[tuple[str, str], tuple[Lane, int]] = {}  # by channel and message
        self._open: dict[int, dict[int, str]] = {}  # of each lane: the last mark of its open calls
        self._counts: dict[int, int] = {}

    def lane(self, channel: str, client: str, node: str | None) -> Lane:
        """Return the lane of a client."""
        lane = self._lanes.make(
            "client", channel, client, group="services", kind="client", id=client,
            label=self._facts.channel_name(channel), note=f"C {client}", node=node, channel=channel,
        )  # fmt: skip
        self._counts.setdefault(lane.index, 0)
        return lane

    def mark(self, record: Any, node: str | None) -> tuple[Lane, list[Any], str]:
        """Return the lane of a step of a call or of a time-out, its mark, and its description.

        Letter and words are those that the kind of record declares.
        """
        name, key = self._facts.channel_name(record.channel), (record.channel, record.message or "")
        declared = record.declared
        is_given_up = declared.call == "is given up"
        lane, call = self._known(record)
        lane = lane or self.lane(record.channel, self._client(record), node)
        if declared.call == "begins" or not (is_given_up or self._counts[lane.index]):
            call = self._counts[lane.index] = self._counts[lane.index] + 1
        call = call or self._following(lane, record)
        if record.message and not is_given_up:
            self._call_of[key] = (lane, call)
        instance = getattr(record, "instance", None)
        server = f"instance {instance} of service {name}" if instance is not None else f"service {name}"
        asking = self._facts.client_words(lane.id)
        if declared.call in ("ends", "is given up"):
            self._open.get(lane.index, {}).pop(call, None)
        elif declared.call:
            self._open.setdefault(lane.index, {})[call] = declared.mark
        mark = [declared.mark, call, *([instance] if declared.call == "is served" else [])]
        return lane, mark, declared.happens.format(client=asking, server=server, service=name)

    def mark_lost(self, record: rec.Drop, node: str | None) -> tuple[Lane, list[Any], str]:
        """Return the same for a client whose request is lost."""
        lane, call = self._known(record)
        client = lane.id if lane else self._facts.ports.get((record.channel, record.place or ""), "?")
        lane = lane or self.lane(record.channel, client, node)
        asking, name = self._facts.client_words(client), self._facts.channel_name(record.channel)
        mark = ["o", call or self._counts[lane.index]]
        return lane, mark, f"the request of {asking} is lost by service {name}"

    def _known(self, record: Any) -> tuple[Lane | None, int]:
        """Return the lane and the number of the call of a record that is not its first."""
        return self._call_of.get((record.channel, record.message or ""), (None, 0))

    def _client(self, record: Any) -> str:
        """Return the client of a call, by the place of its port if the record does not name it."""
        channel, ports, message = record.channel, self._facts.ports, record.message or ""
        client = record.client or None
        if client is None and record.declared.end == "client":
            client = ports.get((channel, record.place))
        if client is None and message.count("/") > 1:
            place = message.split("/")[1]
            client = ports.get((channel, place), place)
        return client or "?"

    def _following(self, lane: Lane, record: Any) -> int:
        """Return the oldest call of a client that a step without an id can follow; otherwise the last one."""
        before = _BEFORE.get(record.declared.call)
        open_ = self._open.get(lane.index, {})
        found = (call for call, mark in open_.items() if mark == before or before is None)
        return next(found, self._counts[lane.index])
