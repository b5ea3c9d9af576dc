"""A plain program that explores what executors with one thread do, in whole units of time.

It knows no Petri nets and no rules. An executor of the order `waiting` has a wait result: all that was ready
at one moment. It takes timers from it before messages, one message of each subscription, and looks again
when nothing of it is left. An executor of the order `any` takes whatever is ready.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from tests.support.reachability import explored


class Facts(NamedTuple):
    """What can happen.

    Attributes
    ----------
    longest : dict from str to int
        The greatest number of messages in each reader history.
    lost, missed : set of str
        Readers that can lose a message, timers that can lose a tick.
    response : dict from str to tuple of int
        Of each callback: least and greatest time from its release to its end.
    states : int
        How many there are.
    """

    longest: dict[str, int]
    lost: set[str]
    missed: set[str]
    response: dict[str, tuple[int, int]]
    states: int


class _State(NamedTuple):
    """One moment; ages count from when something was released."""

    strikes: tuple[int, ...]
    """By timer: time to its next strike; of a sporadic one, the time in which it cannot strike."""
    due: tuple[int | None, ...]
    queues: tuple[tuple[int, ...], ...]
    flights: tuple[tuple[int, ...], ...]
    """By writer and reader: how long each message is on its way."""
    running: tuple[tuple[str, int, int] | None, ...]
    """By node: a callback, how long it works, its age."""
    results: tuple[frozenset[str], ...]


class Explorer:
    """Explores a system of timers and subscriptions that work once and then publish.

    Parameters
    ----------
    system : dict
        As `tests.support.timed_systems.models` reads it; a timer with `sporadic` has its period as the least
        distance of its strikes, and a node with the `order` ``any`` has no wait result.
    """

    def __init__(self, system: dict[str, Any]) -> None:
        self.nodes = list(system["nodes"])
        self.waiting = [each.get("order", "any") != "any" for each in system["nodes"].values()]
        self.callbacks = {each["name"]: each for each in system["callbacks"]}
        self.timers = [each for each in system["callbacks"] if "period" in each]
        self.readers = [each for each in system["callbacks"] if "topic" in each]
        self.pairs = [
            (writer["name"], number)
            for writer in system["callbacks"]
            for step in writer["script"]
            if step[0] == "publish"
            for number, reader in enumerate(self.readers)
            if reader["topic"] == step[1]
        ]
        self.latency = [
            system["latency"].get(self.readers[number]["topic"], (0, 0)) for _, number in self.pairs
        ]
        self.longest = {each["name"]: 0 for each in self.readers}
        self.lost: set[str] = set()
        self.missed: set[str] = set()
        self.response: dict[str, tuple[int, int]] = {}

    def explore(self, most: int = 400_000) -> Facts:
        """Return the facts.

        Raises
        ------
        TooManyStatesError
            There are more states than `most`.
        """
        starts: list[tuple[int, ...]] = [()]
        for timer in self.timers:
            offsets = range(timer["period"] + 1) if timer["offset"] == "any" else (timer["offset"],)
            starts = [(*start, offset) for start in starts for offset in offsets]
        todo = [
            _State(
                start,
                (None,) * len(self.timers),
                ((),) * len(self.readers),
                ((),) * len(self.pairs),
                (None,) * len(self.nodes),
                (frozenset(),) * len(self.nodes),
            )
            for start in starts
        ]
        known = explored(todo, self.successors, most)
        for state in known:
            for reader, queue in zip(self.readers, state.queues, strict=True):
                name = reader["name"]
                self.longest[name] = max(self.longest[name], len(queue))
        return Facts(self.longest, self.lost, self.missed, self.response, len(known))

    def successors(self, state: _State) -> Iterator[_State]:
        """Yield what can come next; time passes only if nothing has to happen."""
        must = False
        for number, left in enumerate(state.strikes):
            if left == 0:
                must = must or not self.timers[number].get("sporadic")
                yield self._strike(state, number)
        for pair, (least, most) in enumerate(self.latency):
            if state.flights[pair] and state.flights[pair][0] >= least:
                must = must or state.flights[pair][0] == most
                yield self._arrive(state, pair)
        for node, running in enumerate(state.running):
            if running is None:
                begun = list(self._begin(state, node))
                must = must or bool(begun)
                yield from begun
            else:
                _, least, most = self.callbacks[running[0]]["script"][0]
                if running[1] >= least:
                    must = must or running[1] == most
                    yield self._end(state, node)
        if not must:
            yield self._pass(state)

    def _strike(self, state: _State, number: int) -> _State:
        timer = self.timers[number]
        strikes = _with(state.strikes, number, timer["period"])
        if state.due[number] is not None:
            self.missed.add(timer["name"])
            return state._replace(strikes=strikes)
        return state._replace(strikes=strikes, due=_with(state.due, number, 0))

    def _arrive(self, state: _State, pair: int) -> _State:
        number = self.pairs[pair][1]
        reader = self.readers[number]
        queue = (*state.queues[number], 0)
        if len(queue) > reader["depth"]:
            self.lost.add(reader["name"])
            queue = queue[1:]
        return state._replace(
            flights=_with(state.flights, pair, state.flights[pair][1:]),
            queues=_with(state.queues, number, queue),
        )

    def _ready(self, state: _State, node: int) -> set[str]:
        name = self.nodes[node]
        timers = {
            each["name"]
            for each, due in zip(self.timers, state.due, strict=True)
            if due is not None and each["node"] == name
        }
        return timers | {
            each["name"]
            for each, queue in zip(self.readers, state.queues, strict=True)
            if queue and each["node"] == name
        }

    def _begin(self, state: _State, node: int) -> Iterator[_State]:
        ready = self._ready(state, node)
        result = frozenset[str]()
        choice = ready
        if self.waiting[node]:
            result = state.results[node] or frozenset(ready)
            choice = {each for each in result if "period" in self.callbacks[each]} or set(result)
        for name in sorted(choice):
            left = state._replace(results=_with(state.results, node, result - {name}))
            yield self._begun(left, node, name)

    def _begun(self, state: _State, node: int, name: str) -> _State:
        each = self.callbacks[name]
        if "period" in each:
            number = self.timers.index(each)
            age = state.due[number]
            state = state._replace(due=_with(state.due, number, None))
        else:
            number = self.readers.index(each)
            age, *rest = state.queues[number]
            state = state._replace(queues=_with(state.queues, number, tuple(rest)))
        return state._replace(running=_with(state.running, node, (name, 0, age)))

    def _end(self, state: _State, node: int) -> _State:
        running = state.running[node]
        assert running is not None
        name, _, age = running
        least, most = self.response.get(name, (age, age))
        self.response[name] = min(least, age), max(most, age)
        flights = state.flights
        for number, (writer, _) in enumerate(self.pairs):
            if writer == name:
                flights = _with(flights, number, (*flights[number], 0))
        return state._replace(running=_with(state.running, node, None), flights=flights)

    def _pass(self, state: _State) -> _State:
        return state._replace(
            strikes=tuple(max(0, left - 1) for left in state.strikes),
            due=tuple(None if due is None else due + 1 for due in state.due),
            queues=tuple(tuple(age + 1 for age in queue) for queue in state.queues),
            flights=tuple(tuple(age + 1 for age in flight) for flight in state.flights),
            running=tuple(
                None if each is None else (each[0], each[1] + 1, each[2] + 1) for each in state.running
            ),
        )


def _with(values: tuple[Any, ...], number: int, value: Any) -> tuple[Any, ...]:
    return (*values[:number], value, *values[number + 1 :])
