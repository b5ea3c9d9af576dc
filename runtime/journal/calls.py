"""The calls of a node, as client and as server, rebuilt from its records."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from dineros.metamodel.records import Checkpoint, Data
from dineros.metamodel.records.schema import requests_of
from dineros.runtime.journal.saved import CallState


@dataclass
class _Pending:
    """A request under way; `asked`: when it was first sent, in seconds since the epoch."""

    data: Data
    asked: float
    attempts: int = 1


class Calls:
    """The state of a node's calls after the records so far."""

    def __init__(self) -> None:
        self._requests: dict[str, dict[str, _Pending]] = {}
        self._serving: dict[str, str] = {}
        self._responses: dict[str, dict[str, Data]] = {}
        self._kept_responses: dict[str, int] = {}

    def begin(self, record: Checkpoint, now: float) -> None:
        """Take over the calls of a checkpoint, written at time `now`."""
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
        """Return the state of the calls, with their ages at time `now`."""
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

    def happen(self, record: Any, data: Data, now: float) -> bool:
        """Apply a step of a call, as its kind declares it; False: it answers a request that is not served.

        Parameters
        ----------
        record : CallStep
            The step.
        data : dict
            Data of the token that leaves its place, if one does.
        now : float
            Time of the step, in seconds since the epoch.
        """
        requests = self._requests.setdefault(f"{record.channel}/{record.client}", {})
        message = record.message or ""
        match record.declared.call:
            case "begins":
                requests[message] = _Pending(data, now)
            case "is served":
                self._serving[record.place] = message
            case "is answered":
                return self._replied(record.channel, message, data)
            case _:
                requests.pop(message, None)
        return True

    def failed(self, key: str, message: str, attempt: int) -> None:
        """Count an attempt of a request that was not answered and is sent again."""
        if (pending := self._requests.get(key, {}).get(message)) is not None:
            pending.attempts = attempt + 1

    def _replied(self, channel: str, message: str, data: Data) -> bool:
        """Keep a response for repeated requests; False: no instance serves the request."""
        entry = next((place for place, served in self._serving.items() if served == message), None)
        if entry is None:
            return False
        del self._serving[entry]
        if message:
            kept = self._responses.setdefault(channel, {})
            kept[message] = data
            sender = message.rpartition("/")[0]
            of_sender = [id for id in kept if id.rpartition("/")[0] == sender]
            for earlier in of_sender[: -self._kept_responses.get(channel, 1)]:
                del kept[earlier]
        return True
