"""A plain program that explores executors with several threads and groups, in whole units of time.

It knows no Petri nets, no rules and no bounds. It follows data: each message carries the timer whose tick it
comes from, and how long ago that was. An executor takes whatever is ready, in any order.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple


class Followed(NamedTuple):
    """What can happen.

    Attributes
    ----------
    longest : dict from str to int
        The greatest number of messages in each reader history.
    lost, missed : set of str
        Readers that can lose a message, timers that can lose a tick.
    response : dict from str to tuple of int
        Of each callback: least and greatest time from its release to its end.
    chains : dict from (str, str) to tuple of int
        By timer and callback: least and greatest time from a tick to the end of a run that has its data.
    """

    longest: dict[str, int]
    lost: set[str]
    missed: set[str]
    response: dict[str, tuple[int, int]]
    chains: dict[tuple[str, str], tuple[int, int]]


class Data(NamedTuple):
    """A tick or message: how long ago it came, the timer that it comes from, how long ago that ticked."""

    age: int
    timer: str
    since: int

    def older(self) -> Data:
        """Return it a unit later."""
        return Data(self.age + 1, self.timer, self.since + 1)


class _State(NamedTuple):
    strikes: tuple[int, ...]
    late: tuple[tuple[int, ...], ...]
    """By timer: how long ago it struck, where its ticks may come later than that."""
    due: tuple[Data | None, ...]
    queues: tuple[tuple[Data, ...], ...]
    flights: tuple[tuple[Data, ...], ...]
    """By writer and reader: messages on their way; their age is how long they are."""
    running: tuple[tuple[str, int, Data], ...]
    """Runs: a callback, how long it works, what it works on; in an order that tells nothing."""


class TooManyStatesError(Exception):
    """The system is too large to be explored."""


class Threads:
    """Explores a system of timers and subscriptions that work once and then publish.

    Parameters
    ----------
    system : dict
        As `tests.support.timed_systems.models` reads it; a timer may have a `jitter`.
    """

    def __init__(self, system: dict[str, Any]) -> None:
        self.threads = {name: node["threads"] for name, node in system["nodes"].items()}
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
        self.latency = [system["latency"][self.readers[number]["topic"]] for _, number in self.pairs]
        self.found = Followed({each["name"]: 0 for each in self.readers}, set(), set(), {}, {})

    def explore(self, most: int) -> Followed:
        """Return what can happen.

        Raises
        ------
        TooManyStatesError
            There are more states than `most`.
        """
        starts: list[tuple[int, ...]] = [()]
        for timer in self.timers:
            offsets = range(timer["period"] + 1) if timer["offset"] == "any" else (timer["offset"],)
            starts = [(*start, offset) for start in starts for offset in offsets]
        on_time = ((),) * len(self.timers)
        none = (on_time, (None,) * len(self.timers), ((),) * len(self.readers), ((),) * len(self.pairs), ())
        todo = [_State(start, *none) for start in starts]
        known = set(todo)
        while todo:
            for after in self._successors(todo.pop()):
                if after not in known:
                    known.add(after)
                    todo.append(after)
            if len(known) > most:
                raise TooManyStatesError
        return self.found

    def _successors(self, state: _State) -> Iterator[_State]:
        must = False
        for number, left in enumerate(state.strikes):
            if left == 0:
                must = True
                yield self._strike(state, number)
            if state.late[number]:
                must = must or state.late[number][0] == self.timers[number].get("jitter", 0)
                late = _with(state.late, number, state.late[number][1:])
                yield self._tick(state._replace(late=late), number)
        for pair, (least, most) in enumerate(self.latency):
            if state.flights[pair] and state.flights[pair][0].age >= least:
                must = must or state.flights[pair][0].age == most
                yield self._arrive(state, pair)
        for begun in self._begun(state):
            must = True
            yield begun
        for run in state.running:
            _, least, most = self.callbacks[run[0]]["script"][0]
            if run[1] >= least:
                must = must or run[1] == most
                yield self._end(state, run)
        if not must:
            yield self._later(state)

    def _strike(self, state: _State, number: int) -> _State:
        strikes = _with(state.strikes, number, self.timers[number]["period"])
        return state._replace(strikes=strikes, late=_with(state.late, number, (*state.late[number], 0)))

    def _tick(self, state: _State, number: int) -> _State:
        timer = self.timers[number]
        if state.due[number] is not None:
            self.found.missed.add(timer["name"])
            return state
        return state._replace(due=_with(state.due, number, Data(0, timer["name"], 0)))

    def _arrive(self, state: _State, pair: int) -> _State:
        number = self.pairs[pair][1]
        reader = self.readers[number]
        first, *rest = state.flights[pair]
        queue = (*state.queues[number], first._replace(age=0))
        if len(queue) > reader["depth"]:
            self.found.lost.add(reader["name"])
            queue = queue[1:]
        self.found.longest[reader["name"]] = max(self.found.longest[reader["name"]], len(queue))
        return state._replace(
            flights=_with(state.flights, pair, tuple(rest)), queues=_with(state.queues, number, queue)
        )

    def _can_begin(self, state: _State, each: dict[str, Any]) -> bool:
        beside = [self.callbacks[name] for name, _, _ in state.running]
        on_node = [other for other in beside if other["node"] == each["node"]]
        if len(on_node) >= self.threads[each["node"]]:
            return False
        return each["group"] == "reentrant" or all(other["group"] != each["group"] for other in on_node)

    def _begun(self, state: _State) -> Iterator[_State]:
        for number, timer in enumerate(self.timers):
            tick = state.due[number]
            if tick is not None and self._can_begin(state, timer):
                left = state._replace(due=_with(state.due, number, None))
                yield left._replace(running=_sorted(left.running, (timer["name"], 0, tick)))
        for number, reader in enumerate(self.readers):
            if state.queues[number] and self._can_begin(state, reader):
                first, *rest = state.queues[number]
                left = state._replace(queues=_with(state.queues, number, tuple(rest)))
                yield left._replace(running=_sorted(left.running, (reader["name"], 0, first)))

    def _end(self, state: _State, run: tuple[str, int, Data]) -> _State:
        name, _, data = run
        _note(self.found.response, name, data.age)
        _note(self.found.chains, (data.timer, name), data.since)
        runs = list(state.running)
        runs.remove(run)
        flights = state.flights
        for number, (writer, _) in enumerate(self.pairs):
            if writer == name:
                flights = _with(flights, number, (*flights[number], data._replace(age=0)))
        return state._replace(running=tuple(runs), flights=flights)

    def _later(self, state: _State) -> _State:
        return _State(
            tuple(left - 1 for left in state.strikes),
            tuple(tuple(age + 1 for age in late) for late in state.late),
            tuple(None if due is None else due.older() for due in state.due),
            tuple(tuple(each.older() for each in queue) for queue in state.queues),
            tuple(tuple(each.older() for each in flight) for flight in state.flights),
            tuple((name, works + 1, data.older()) for name, works, data in state.running),
        )


def _note(spans: dict[Any, tuple[int, int]], key: object, time: int) -> None:
    least, greatest = spans.get(key, (time, time))
    spans[key] = min(least, time), max(greatest, time)


def _sorted(runs: tuple[Any, ...], run: object) -> tuple[Any, ...]:
    return tuple(sorted([*runs, run]))


def _with(values: tuple[Any, ...], number: int, value: Any) -> tuple[Any, ...]:
    return (*values[:number], value, *values[number + 1 :])
