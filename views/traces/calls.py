"""The bars of calls of services: when a request was sent, taken, answered or given up.

A bar stands on the lane of its client; a mark holds its letter and the number of the call on its lane.
"""

from __future__ import annotations

from typing import Any

from dineros.metamodel import records as rec
from dineros.metamodel.records.schema import ServiceStep
from dineros.views.traces.facts import Facts
from dineros.views.traces.lanes import Lane, Lanes

CallRecord = ServiceStep | rec.Timeout | rec.Drop | rec.GiveUp


class CallBars:
    """Finds the bar of each record of a call.

    Parameters
    ----------
    lanes : Lanes
        Where its lanes are made.
    facts : Facts
        What the model says.
    """

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

    def mark(self, record: ServiceStep | rec.Timeout, node: str | None) -> tuple[Lane, list[Any], str]:
        """Return the lane of a record, its mark there, and what happens."""
        name, key = self._facts.channel_name(record.channel), (record.channel, record.message or "")
        lane, call = self._known(record)
        lane = lane or self.lane(record.channel, self._client(record), node)
        if isinstance(record, rec.Request) or not self._counts[lane.index]:
            call = self._counts[lane.index] = self._counts[lane.index] + 1
        call = call or self._following(lane, record)
        if record.message:
            self._call_of[key] = (lane, call)
        instance = getattr(record, "instance", None)
        server = f"instance {instance} of service {name}" if instance is not None else f"service {name}"
        asking = self._facts.client_words(lane.id)
        match record:
            case rec.Request():
                mark, text = ["q", call], f"{asking} calls service {name}"
            case rec.Serve():
                mark, text = ["s", call, instance], f"{server} takes the request of {asking}"
            case rec.Reply():
                mark, text = ["r", call], f"{server} answers {asking}"
            case rec.Response():
                mark, text = ["a", call], f"{asking} gets its response from service {name}"
            case _:
                mark, text = ["o", call], f"{asking} of service {name} waits too long: asks again"
        if mark[0] == "a":
            self._open.get(lane.index, {}).pop(call, None)
        elif mark[0] != "o":
            self._open.setdefault(lane.index, {})[call] = str(mark[0])
        return lane, mark, text

    def mark_unanswered(self, record: rec.Drop | rec.GiveUp, node: str | None) -> tuple[Lane, list[Any], str]:
        """Return the same for a client whose request is lost, or that waits no longer."""
        name, gives_up = self._facts.channel_name(record.channel), isinstance(record, rec.GiveUp)
        lane, call = self._known(record)
        client = record.client if isinstance(record, rec.GiveUp) else lane.id if lane else None
        client = client or self._facts.ports.get((record.channel, record.place or ""), "?")
        lane = lane or self.lane(record.channel, client, node)
        call = call or (self._following(lane, record) if gives_up else self._counts[lane.index])
        if gives_up:
            self._open.get(lane.index, {}).pop(call, None)
        asking = self._facts.client_words(client)
        words = f"{asking} gives up waiting for" if gives_up else f"the request of {asking} is lost by"
        return lane, ["g" if gives_up else "o", call], f"{words} service {name}"

    def _known(self, record: CallRecord) -> tuple[Lane | None, int]:
        """Return the lane and the number of the call of a record that is not its first."""
        return self._call_of.get((record.channel, record.message or ""), (None, 0))

    def _client(self, record: ServiceStep | rec.Timeout) -> str:
        """Return the client of a call, by the place of its port where the record does not name it."""
        channel, ports, message = record.channel, self._facts.ports, record.message or ""
        client = record.client or None
        if client is None and isinstance(record, rec.Request | rec.Response):
            client = ports.get((channel, record.place))
        if client is None and message.count("/") > 1:
            place = message.split("/")[1]
            client = ports.get((channel, place), place)
        return client or "?"

    def _following(self, lane: Lane, record: CallRecord) -> int:
        """Return the oldest call of a client that a step without an id can follow; else the last one."""
        before = {rec.Serve: "q", rec.Reply: "s", rec.Response: "r"}.get(type(record))
        open_ = self._open.get(lane.index, {})
        found = (call for call, mark in open_.items() if mark == before or before is None)
        return next(found, self._counts[lane.index])
