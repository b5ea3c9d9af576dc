"""A plain program that explores executors whose timers call services and wait, in whole units of time.

A call is a message to the server, and a message back to the one that asked: until its work goes on, that one
keeps its thread and its group.
"""

from __future__ import annotations

from typing import Any

from tests.support.timed_systems.threads import Data, Threads, _State

THEN = ".then"
"""Ends the name of what a caller does when it has the response."""


class Callers(Threads):
    """Explores a system of timers and subscriptions, where timers may call one service once.

    Parameters
    ----------
    system : dict
        As `tests.support.timed_systems.models` reads it.
    """

    def __init__(self, system: dict[str, Any]) -> None:
        super().__init__(_as_messages(system))
        (self.server,) = (each["name"] for each in system["callbacks"] if "service" in each)

    def _waiting(self, state: _State) -> set[str]:
        """Return the callers that wait for a response."""
        waiting = {data.timer for name, _, data in state.running if name == self.server}
        for number, reader in enumerate(self.readers):
            if self._is_called(reader):
                waiting |= {data.timer for data in state.queues[number]}
        for (_, number), flight in zip(self.pairs, state.flights, strict=True):
            if self._is_called(self.readers[number]):
                waiting |= {data.timer for data in flight}
        return waiting

    def _is_called(self, reader: dict[str, Any]) -> bool:
        name: str = reader["name"]
        return name == self.server or name.endswith(THEN)

    def _can_begin(self, state: _State, each: dict[str, Any]) -> bool:
        if each["name"].endswith(THEN):
            return True
        held = tuple((name, 0, Data(0, name, 0)) for name in sorted(self._waiting(state)))
        return super()._can_begin(state._replace(running=(*state.running, *held)), each)

    def _end(self, state: _State, run: tuple[str, int, Data]) -> _State:
        after = super()._end(state, run)
        if run[0] != self.server:
            return after
        flights = list(after.flights)
        for number, (writer, reader) in enumerate(self.pairs):
            if writer == self.server and self.readers[reader]["name"] != run[2].timer + THEN:
                flights[number] = state.flights[number]
        return after._replace(flights=tuple(flights))


def _as_messages(system: dict[str, Any]) -> dict[str, Any]:
    """Return the system with a message for each request and each response."""
    callbacks = []
    for each in system["callbacks"]:
        script = each["script"]
        if "service" in each:
            more = {"topic": "request", "depth": each["depth"], "script": [*script, ["publish", "response"]]}
            callbacks.append({**each, **more})
        elif len(script) > 1 and script[1][0] == "call":
            callbacks.append({**each, "script": [script[0], ["publish", "request"]]})
            then = {key: each[key] for key in ("node", "group")}
            then |= {"name": each["name"] + THEN, "topic": "response", "depth": 1, "script": script[2:]}
            callbacks.append(then)
        else:
            callbacks.append(each)
    latency = system["latency"]
    (service,) = (each["service"] for each in system["callbacks"] if "service" in each)
    calls = latency.get(service, (0, 0))
    return {**system, "callbacks": callbacks, "latency": {**latency, "request": calls, "response": calls}}
