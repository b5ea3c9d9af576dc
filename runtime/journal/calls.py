"""The calls of a node, as client and as server, rebuilt from its records."""

from __future__ import annotations

from dataclasses import dataclass

from dineros.metamodel.records import (
    Checkpoint,
    Data,
    Reply,
    Request,
    Serve,
    Timeout,
)
from dineros.metamodel.records.schema import requests_of
from dineros.runtime.journal.saved import CallState


@dataclass
class _Pending:
    """A request under way; `asked`: when, in seconds since the epoch."""

    data: Data
    asked: float
    attempts: int = 1


class Calls:
    """What the records so far leave the calls of a node in."""

    def __init__(self) -> None:
        self._requests: dict[str, dict[str, _Pending]] = {}
        self._serving: dict[str, str] = {}
        self._responses: dict[str, dict[str, Data]] = {}
        self._kept_responses: dict[str, int] = {}

    def begin(self, record: Checkpoint, now: float) -> None:
        """Take over what a checkpoint says at a time."""
        self._requests = {
            client: {
                request["message"]: _Pending(request["data"], now - request["age"], request["attempts"])
                for request in requests_of(found, record.location)
            }
            for client, found in record.requests.items()
        }
        self._serving = dict(record.serving)
        self._responses = {channel: dict(kept) for channel, kept in record.responses.items()}
        self._kept_responses = dict(record.kept_responses)

    def save(self, now: float) -> CallState:
        """Return them, with their age at a time."""
        return {
            "requests": {
                client: [
                    {
                        "message": id,
                        "data": each.data,
                        "attempts": each.attempts,
                        "age": max(0.0, now - each.asked),
                    }
                    for id, each in requests.items()
                ]
                for client, requests in self._requests.items()
                if requests
            },
            "serving": dict(self._serving),
            "responses": {channel: dict(kept) for channel, kept in self._responses.items()},
            "kept_responses": dict(self._kept_responses),
        }

    # What a client does.

    def asked(self, record: Request, data: Data, now: float) -> None:
        """A request is sent."""
        self._pending(record.channel, record.client)[record.message or ""] = _Pending(data, now)

    def failed(self, record: Timeout) -> None:
        """A request is not answered, and is sent again."""
        pending = self._pending(record.channel, record.client).get(record.message or "")
        if pending is not None:
            pending.attempts = record.attempt + 1

    def over(self, channel: str, client: str | None, message: str | None) -> None:
        """A request is answered, or its client gives up."""
        self._pending(channel, client).pop(message or "", None)

    def _pending(self, channel: str, client: str | None) -> dict[str, _Pending]:
        """Return the requests that a client has under way, by id."""
        return self._requests.setdefault(f"{channel}/{client}", {})

    # What a server does.

    def served(self, record: Serve) -> None:
        """An instance takes a request."""
        self._serving[record.place] = record.message or ""

    def replied(self, record: Reply, data: Data) -> bool:
        """Note a response, which is kept for a request that comes again; False: no instance serves it."""
        message = record.message or ""
        entry = next((place for place, served in self._serving.items() if served == message), None)
        if entry is None:
            return False
        del self._serving[entry]
        if message:
            kept = self._responses.setdefault(record.channel, {})
            kept[message] = data
            sender = message.rpartition("/")[0]
            of_sender = [id for id in kept if id.rpartition("/")[0] == sender]
            for earlier in of_sender[: -self._kept_responses.get(record.channel, 1)]:
                del kept[earlier]
        return True
