"""A plain program that explores executors of managed nodes, in whole units of time.

A managed node is unconfigured, inactive, active or finalized. It changes its state at any moment at which it
has a free thread and no callback of its default group runs. Its timers run while it is configured, from their
offset on each time. What it publishes while it is not active is lost, and so is what is sent to it while it
is not configured, and what it holds when it leaves.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from tests.support.timed_systems.threads import Data, Threads, _offsets, _State, _with

STOPPED = -1
"""A timer that does not run."""
CONFIGURED = ("inactive", "active")


class Managed(Threads):
    """Explores a system, as `tests.support.timed_systems.models` reads it, some of whose nodes are managed.

    A managed node has a dictionary `life` with the truth values `deactivates`, `cleansUp`, `shutsDown` and
    `pauses`. The topics of its publishers and subscriptions have no latency: their messages take any time,
    and a publisher keeps `limit` of them.

    Attributes
    ----------
    gone : set of (str, str)
        What is lost otherwise than in a full reader history: how, and the topic or the reader.
    """

    def __init__(self, system: dict[str, Any]) -> None:
        super().__init__(system)
        self.lives = {name: node["life"] for name, node in system["nodes"].items() if "life" in node}
        self.managed = list(self.lives)
        self.limit = system.get("limit", 10)
        self.is_open = [
            node in self.lives or self.readers[reader]["node"] in self.lives
            for (node, _), reader in self.pairs
        ]
        self.gone: set[tuple[str, str]] = set()

    def _starts(self) -> list[_State]:
        found = []
        for state in super()._starts():
            strikes = tuple(
                STOPPED if timer["node"] in self.lives else left
                for timer, left in zip(self.timers, state.strikes, strict=True)
            )
            found.append(state._replace(strikes=strikes, beside=("unconfigured",) * len(self.managed)))
        return list(dict.fromkeys(found))

    def _is(self, state: _State, node: str, *kinds: str) -> bool:
        return node not in self.lives or state.beside[self.managed.index(node)] in kinds

    def _successors(self, state: _State) -> Iterator[_State]:
        yield from self._changed(state)
        for pair, flight in enumerate(state.flights):
            writer = self.pairs[pair][0][0]
            if flight and self.is_open[pair]:
                yield self._arrive(state, pair)
                if not self._is(state, writer, *CONFIGURED):
                    self.gone.add(("left", self.pairs[pair][0][1]))
                    yield state._replace(flights=_with(state.flights, pair, flight[1:]))
        yield from self._forced(state)

    def _forced(self, state: _State) -> Iterator[_State]:
        """Yield what an executor and messages with a latency do."""
        kept = state.flights
        hidden = tuple(() if open_ else flight for open_, flight in zip(self.is_open, kept, strict=True))
        for after in super()._successors(state._replace(flights=hidden)):
            flights = tuple(
                (*before, *now) if open_ else now
                for open_, before, now in zip(self.is_open, kept, after.flights, strict=True)
            )
            yield after._replace(flights=self._bounded(flights))

    def _bounded(self, flights: tuple[tuple[Data, ...], ...]) -> tuple[tuple[Data, ...], ...]:
        """Keep the last messages of each publisher, of those that take any time."""
        found = []
        for pair, flight in enumerate(flights):
            if self.is_open[pair]:
                if len(flight) > self.limit:
                    self.gone.add(("written", self.pairs[pair][0][1]))
                found.append(tuple(Data(0, "", 0) for _ in flight[-self.limit :]))
            else:
                found.append(flight)
        return tuple(found)

    def _changed(self, state: _State) -> Iterator[_State]:
        """Yield the changes of a managed node's state."""
        for number, node in enumerate(self.managed):
            running = [self.callbacks[name] for name, _, _ in state.running]
            on_node = [each for each in running if each["node"] == node]
            if len(on_node) >= self.threads[node] or any(each["group"] == "default" for each in on_node):
                continue
            life, now = self.lives[node], state.beside[number]
            for after in _changes(now, life):
                changed = state._replace(beside=_with(state.beside, number, after))
                if now in CONFIGURED and after not in CONFIGURED:
                    changed = self._left(changed, node)
                if now == "unconfigured" and after == "inactive":
                    yield from self._started(changed, node)
                else:
                    yield changed

    def _started(self, state: _State, node: str) -> Iterator[_State]:
        """Start the timers of a node, which was written to and wrote nothing that is still on its way."""
        if any(
            flight and node == writer[0]
            for (writer, _), flight in zip(self.pairs, state.flights, strict=True)
        ):
            return
        found = [state.strikes]
        for number, timer in enumerate(self.timers):
            if timer["node"] == node:
                found = [_with(strikes, number, first) for strikes in found for first in _offsets(timer)]
        for strikes in found:
            yield state._replace(strikes=strikes)

    def _left(self, state: _State, node: str) -> _State:
        """Lose what a node holds: ticks, messages in its histories and on their way to it."""
        strikes, late, due = list(state.strikes), list(state.late), list(state.due)
        for number, timer in enumerate(self.timers):
            if timer["node"] == node:
                strikes[number], late[number], due[number] = STOPPED, (), None
        queues, flights = list(state.queues), list(state.flights)
        for number, reader in enumerate(self.readers):
            if reader["node"] == node:
                if queues[number]:
                    self.gone.add(("cleared", reader["name"]))
                queues[number] = ()
        for pair, (_, number) in enumerate(self.pairs):
            if self.readers[number]["node"] == node:
                if flights[pair]:
                    self.gone.add(("left", self.pairs[pair][0][1]))
                flights[pair] = ()
        return state._replace(
            strikes=tuple(strikes),
            late=tuple(late),
            due=tuple(due),
            queues=tuple(queues),
            flights=tuple(flights),
        )

    def _can_begin(self, state: _State, each: dict[str, Any]) -> bool:
        node = each["node"]
        kinds: tuple[str, ...] = CONFIGURED
        if node in self.lives and self.lives[node].get("pauses") and "period" in each:
            kinds = ("active",)
        return self._is(state, node, *kinds) and super()._can_begin(state, each)

    def _publish(self, state: _State, name: str, data: Data) -> _State:
        node = self.callbacks[name]["node"]
        after = super()._publish(state, name, data)
        flights = list(after.flights)
        for number, (_, reader) in enumerate(self.pairs):
            if len(flights[number]) > len(state.flights[number]):
                if not self._is(state, node, "active"):
                    flights[number] = state.flights[number]
                elif not self._is(state, self.readers[reader]["node"], *CONFIGURED):
                    self.gone.add(("missed", self.readers[reader]["name"]))
                    flights[number] = state.flights[number]
        if not self._is(state, node, "active"):
            for _, topic in self.publishers[name]:
                self.gone.add(("discarded", topic))
        return after._replace(flights=tuple(flights))

    def _later(self, state: _State) -> _State:
        after = super()._later(state)
        strikes = tuple(
            STOPPED if left == STOPPED else next_
            for left, next_ in zip(state.strikes, after.strikes, strict=True)
        )
        return after._replace(strikes=strikes, beside=state.beside)


def _changes(now: str, life: dict[str, bool]) -> Iterator[str]:
    """Yield the states that follow a state."""
    if now == "unconfigured":
        yield "inactive"
    if now == "inactive":
        yield "active"
    if now == "active" and life.get("deactivates"):
        yield "inactive"
    if now == "inactive" and life.get("cleansUp"):
        yield "unconfigured"
    if now != "finalized" and life.get("shutsDown"):
        yield "finalized"
