"""A plain program that explores executors whose messages have lifespans, in whole units of time.

A message counts its age from its publication on. It is not taken once it is older than the lifespan of its
topic, and leaves its history when it is as old as that.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from tests.support.timed_systems.threads import Threads, _State, _with


class Aging(Threads):
    """Explores a system, as `tests.support.timed_systems.models` reads it, without following chains.

    Attributes
    ----------
    expired : set of str
        Readers of which a message can be too old.
    """

    def __init__(self, system: dict[str, Any]) -> None:
        super().__init__(system)
        spans = system.get("lifespan", {})
        self.lifespans = [spans.get(reader["topic"]) for reader in self.readers]
        self.expired: set[str] = set()

    def _successors(self, state: _State) -> Iterator[_State]:
        is_over = False
        for number, queue in enumerate(state.queues):
            span = self.lifespans[number]
            if span is not None and queue and queue[0].since >= span:
                is_over = True
                self.expired.add(self.readers[number]["name"])
                yield state._replace(queues=_with(state.queues, number, queue[1:]))
        for after in super()._successors(state):
            if not (is_over and after == self._later(state)):
                yield after

    def _arrive(self, state: _State, pair: int) -> _State:
        number = self.pairs[pair][1]
        first, *rest = state.flights[pair]
        span = self.lifespans[number]
        if span is None or first.since <= span:
            return super()._arrive(state, pair)
        self.expired.add(self.readers[number]["name"])
        return state._replace(flights=_with(state.flights, pair, tuple(rest)))

    def _end(self, state: _State, run: tuple[str, int, Any]) -> _State:
        """Publish messages that are new; which tick they come from does not count here."""
        name, works, data = run
        new = data._replace(age=0, timer="", since=0)
        runs = tuple(each if each != run else (name, works, new) for each in state.running)
        return super()._end(state._replace(running=tuple(sorted(runs))), (name, works, new))
