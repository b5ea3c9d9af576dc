"""A plain program that explores executors with several threads and groups, in whole units of time.

It knows no Petri nets, no rules and no bounds. It follows data: each message carries the timer whose tick it
comes from, and how long ago that was. An executor takes whatever is ready, in any order.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from tests.support.reachability import explored


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
    results: tuple[frozenset[str], ...] = ()
    """By node with an order: callbacks that were ready when its thread looked, and are not taken yet."""
    beside: Any = None
    """What a program that measures more keeps beside."""


TOLD = "!"
"""Ends the name of a run that has published in the middle of its work."""


class Threads:
    """Explores a system of timers and subscriptions that work once, and publish then or meanwhile.

    Parameters
    ----------
    system : dict
        As `tests.support.timed_systems.models` reads it; a timer may have a `jitter`.
    """

    def __init__(self, system: dict[str, Any]) -> None:
        self.threads = {name: node["threads"] for name, node in system["nodes"].items()}
        self.ordered = [name for name, node in system["nodes"].items() if node.get("order", "any") != "any"]
        self.callbacks = {each["name"]: each for each in system["callbacks"]}
        self.open = {
            name: step[3] for name, each in self.callbacks.items() if (step := each["script"][0])[0] == "open"
        }
        self.callbacks |= {name + TOLD: self.callbacks[name] for name in self.open}
        self.timers = [each for each in system["callbacks"] if "period" in each]
        self.readers = [each for each in system["callbacks"] if "topic" in each]
        self.publishers = {
            each["name"]: [
                (each["node"], step[-1]) for step in each["script"] if step[0] in ("publish", "open")
            ]
            for each in system["callbacks"]
        }
        """By callback: nodes and topics. Callbacks of a node share the publisher of a topic."""
        self.pairs = [
            (publisher, number)
            for publisher in dict.fromkeys(one for of in self.publishers.values() for one in of)
            for number, reader in enumerate(self.readers)
            if reader["topic"] == publisher[1]
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
        found: Followed = self._all_from(self._starts(), most)
        return found

    def _all_from(self, todo: list[_State], most: int) -> Any:
        """Explore all states that follow some states."""
        explored(todo, self._successors, most)
        return self.found

    def _starts(self) -> list[_State]:
        starts: list[tuple[int, ...]] = [()]
        for timer in self.timers:
            starts = [(*start, offset) for start in starts for offset in _offsets(timer)]
        on_time = ((),) * len(self.timers)
        none = (on_time, (None,) * len(self.timers), ((),) * len(self.readers), ((),) * len(self.pairs), ())
        results = (frozenset[str](),) * len(self.ordered)
        return [_State(start, *none, results) for start in starts]

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
            least, most = self.callbacks[run[0]]["script"][0][1:3]
            if run[0] in self.open:
                must = must or run[1] == most
                yield self._tell(state, run)
            elif run[1] >= least:
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
            if tick is not None and (left := self._taken(state, timer)) is not None:
                left = left._replace(due=_with(state.due, number, None))
                yield left._replace(running=_sorted(left.running, (timer["name"], 0, tick)))
        for number, reader in enumerate(self.readers):
            if state.queues[number] and (left := self._taken(state, reader)) is not None:
                first, *rest = state.queues[number]
                left = left._replace(queues=_with(state.queues, number, tuple(rest)))
                yield left._replace(running=_sorted(left.running, (reader["name"], 0, first)))

    def _taken(self, state: _State, each: dict[str, Any]) -> _State | None:
        """Return the state after an executor has chosen a callback that is ready; None if it does not."""
        if not self._can_begin(state, each):
            return None
        if each["node"] not in self.ordered:
            return state
        at = self.ordered.index(each["node"])
        result = state.results[at] or self._ready(state, each["node"])
        timers = {name for name in result if "period" in self.callbacks[name]}
        if each["name"] not in (timers or result):
            return None
        return state._replace(results=_with(state.results, at, result - {each["name"]}))

    def _ready(self, state: _State, node: str) -> frozenset[str]:
        pairs = [*zip(self.timers, state.due, strict=True), *zip(self.readers, state.queues, strict=True)]
        return frozenset(each["name"] for each, waiting in pairs if waiting and each["node"] == node)

    def _tell(self, state: _State, run: tuple[str, int, Data]) -> _State:
        """Publish in the middle of the work."""
        name, works, data = run
        runs = list(state.running)
        runs.remove(run)
        after = state._replace(running=_sorted(tuple(runs), (name + TOLD, works, data)))
        return self._publish(after, name, data)

    def _publish(self, state: _State, name: str, data: Data) -> _State:
        flights = state.flights
        for number, (publisher, _) in enumerate(self.pairs):
            if publisher in self.publishers[name.removesuffix(TOLD)]:
                flights = _with(flights, number, (*flights[number], data._replace(age=0)))
        return state._replace(flights=flights)

    def _end(self, state: _State, run: tuple[str, int, Data]) -> _State:
        name, _, data = run
        is_told, name = name.endswith(TOLD), name.removesuffix(TOLD)
        _note(self.found.response, name, data.age)
        _note(self.found.chains, (data.timer, name), data.since)
        runs = list(state.running)
        runs.remove(run)
        after = state._replace(running=tuple(runs))
        return after if is_told else self._publish(after, name, data)

    def _later(self, state: _State) -> _State:
        return _State(
            tuple(left - 1 for left in state.strikes),
            tuple(tuple(age + 1 for age in late) for late in state.late),
            tuple(None if due is None else due.older() for due in state.due),
            tuple(tuple(each.older() for each in queue) for queue in state.queues),
            tuple(tuple(each.older() for each in flight) for flight in state.flights),
            tuple((name, works + 1, data.older()) for name, works, data in state.running),
            state.results,
        )


def _offsets(timer: dict[str, Any]) -> range:
    """Return when a timer may strike first."""
    match timer["offset"]:
        case "any":
            return range(timer["period"] + 1)
        case [least, most]:
            return range(least, most + 1)
        case offset:
            return range(offset, offset + 1)


def _note(spans: dict[Any, tuple[int, int]], key: object, time: int) -> None:
    least, greatest = spans.get(key, (time, time))
    spans[key] = min(least, time), max(greatest, time)


def _sorted(runs: tuple[Any, ...], run: object) -> tuple[Any, ...]:
    return tuple(sorted([*runs, run]))


def _with(values: tuple[Any, ...], number: int, value: Any) -> tuple[Any, ...]:
    return (*values[:number], value, *values[number + 1 :])
