"""A plain program that explores callbacks which call services and whose runs overlap, in whole units of time.

Runs of a callback in a reentrant group are on threads of their own. Each waits for the response to its own
request, so each request carries the number of its run.
"""

from __future__ import annotations

from collections.abc import Iterator

from tests.support.timed_systems.threads import _note, _with
from tests.support.timed_systems.waiting import Waiters, _Run, _running, _State


class Overlapping(Waiters):
    """Explores a system, as `tests.support.timed_systems.models` reads it, without time-outs.

    A callback calls once at most, in any group. What tells elsewhere whether a client still waits is the
    number of its run here.
    """

    def _go_on(self, state: _State, run: _Run) -> _State:
        each, runs = self.callbacks[run.name], list(state.running)
        runs.remove(run)
        state = state._replace(running=tuple(runs))
        for at in range(run.at + 1, len(each["script"])):
            kind, *rest = each["script"][at]
            if kind == "publish":
                state = self._published(state, each["node"], rest[0])
                continue
            number = 0
            if kind == "call":
                used = {other.has_told for other in runs if other.name == run.name}
                number = next(free for free in range(1, len(used) + 2) if free not in used)
                client = self.clients.index(run.name)
                sent = (*state.requests[client], (0, number))
                state = state._replace(requests=_with(state.requests, client, sent))
            return _running(state, run._replace(at=at, spent=0, has_told=number))  # type: ignore[arg-type]
        _note(self.found.response, run.name, run.age)
        if run.client:
            client = self.clients.index(run.client)
            sent = (*state.responses[client], (0, run.is_live))
            state = state._replace(responses=_with(state.responses, client, sent))
        return state

    def _taken(self, state: _State) -> Iterator[_State]:
        for client, name in enumerate(self.clients):
            node, group = self.callbacks[name]["node"], self.calls[name][2]
            if state.answered[client] and self._is_free(state, node, group):
                number, *rest = state.answered[client]
                left = state._replace(answered=_with(state.answered, client, tuple(rest)))
                (run,) = (
                    each
                    for each in left.running
                    if (each.name, each.has_told) == (name, number)
                    and self.callbacks[name]["script"][each.at][0] == "call"
                )
                yield self._go_on(left, run)
