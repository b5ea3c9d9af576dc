"""The calls of a node, as client and as server, rebuilt from its records."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from dineros.metamodel.records import Checkpoint, Data
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

    def happen(self, record: Any, data: Data, now: float) -> bool:
        """Let a step of a call happen, as its kind declares it; False: no instance serves what it answers.

        Parameters
        ----------
        record : CallStep
            The step.
        data : dict
            What its token carries, if that leaves.
        now : float
            When it happens, in seconds since the epoch.
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
        """A request is not answered, and is sent again."""
        if (pending := self._requests.get(key, {}).get(message)) is not None:
            pending.attempts = attempt + 1

    def _replied(self, channel: str, message: str, data: Data) -> bool:
        """Note a response, which is kept for a request that comes again; False: no instance serves it."""
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
