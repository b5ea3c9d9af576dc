"""A plain program that explores callbacks which call services, on any threads, in whole units of time.

It knows no Petri nets and no rules. A callback works, publishes (after its work, or at any moment of it),
calls a service and waits. It keeps its thread and its group while it waits. A thread of its executor takes
the response, as soon as there is one, and the group of the client is free. With a time-out, the callback
continues when that is over; a response that comes later is taken and dropped. What happens at the same moment
may happen in any order.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from tests.support.reachability import explored
from tests.support.timed_systems.threads import _note, _offsets, _sorted, _with

DEPTH = 10
"""Requests that a server keeps."""


class Waited(NamedTuple):
    """What can happen, as in `tests.support.timed_systems.threads.Followed`, and how calls end."""

    longest: dict[str, int]
    lost: set[str]
    missed: set[str]
    response: dict[str, tuple[int, int]]
    late: set[str]
    """Callbacks whose call may end by its time-out."""
    ends: set[str]
    """Callbacks whose call may end by its response."""


class _Run(NamedTuple):
    name: str
    at: int
    """The step that it does."""
    spent: int
    """Time in this step."""
    age: int
    """Since its release."""
    client: str = ""
    """Of a server: whose request it is."""
    is_live: bool = True
    """Whether that client still waits for it."""
    has_told: bool = False
    """Whether it has published in this step, which it may do at any moment of it."""


class _State(NamedTuple):
    strikes: tuple[int, ...]
    due: tuple[int, ...]
    """By timer, how long a tick waits; -1: none does."""
    flights: tuple[tuple[int, ...], ...]
    queues: tuple[tuple[int, ...], ...]
    requests: tuple[tuple[tuple[int, bool], ...], ...]
    """By client, requests on their way, with their age, and whether the client still waits."""
    asked: tuple[tuple[tuple[str, int, bool], ...], ...]
    """By server, requests that have come: client, age, whether it still waits."""
    responses: tuple[tuple[tuple[int, bool], ...], ...]
    answered: tuple[tuple[bool, ...], ...]
    running: tuple[_Run, ...]


class Waiters:
    """Explores a system, as `tests.support.timed_systems.models` reads it.

    A callback calls once at most, with or without a time-out, and is not in a reentrant group then.
    """

    def __init__(self, system: dict[str, Any]) -> None:
        self.threads = {name: node["threads"] for name, node in system["nodes"].items()}
        self.callbacks = {each["name"]: each for each in system["callbacks"]}
        every = system["callbacks"]
        self.timers = [each for each in every if "period" in each]
        self.readers = [each for each in every if "topic" in each]
        self.servers = [each for each in every if "service" in each]
        self.calls = {each["name"]: step for each in every for step in each["script"] if step[0] == "call"}
        self.clients = list(self.calls)
        publishers = dict.fromkeys(
            (each["node"], step[-1])
            for each in every
            for step in each["script"]
            if step[0] in ("publish", "open")
        )
        self.pairs = [
            (publisher, number)
            for publisher in publishers
            for number, reader in enumerate(self.readers)
            if reader["topic"] == publisher[1]
        ]
        latency = system["latency"]
        self.latency = [latency.get(publisher[1], (0, 0)) for publisher, _ in self.pairs]
        self.of_calls = [latency.get(self.calls[name][1], (0, 0)) for name in self.clients]
        histories = [each["name"] for each in (*self.readers, *self.servers)]
        self.found = Waited(dict.fromkeys(histories, 0), set(), set(), {}, set(), set())

    def explore(self, most: int) -> Waited:
        """Return what can happen; raises `TooManyStatesError` if there are more than `most` states."""
        starts: list[tuple[int, ...]] = [()]
        for timer in self.timers:
            starts = [(*start, offset) for start in starts for offset in _offsets(timer)]
        empty = [((),) * len(each) for each in (self.pairs, self.readers, self.clients, self.servers)]
        flights, queues, requests, asked = empty
        none = ((-1,) * len(self.timers), flights, queues, requests, asked, requests, requests, ())
        todo = [_State(start, *none) for start in starts]
        explored(todo, self._successors, most)
        return self.found

    def _successors(self, state: _State) -> Iterator[_State]:
        must = False
        for number, left in enumerate(state.strikes):
            if left == 0:
                must = True
                yield self._strike(state, number)
        for pair, (least, most) in enumerate(self.latency):
            if state.flights[pair] and state.flights[pair][0] >= least:
                must = must or state.flights[pair][0] == most
                yield self._arrive(state, pair)
        for client, (least, most) in enumerate(self.of_calls):
            for way, moved in ((state.requests, self._ask), (state.responses, self._answer)):
                if way[client] and way[client][0][0] >= least:
                    must = must or way[client][0][0] == most
                    yield moved(state, client)
        for now in (*self._begun(state), *self._taken(state)):
            must = True
            yield now
        for run in state.running:
            kind, *rest = self.callbacks[run.name]["script"][run.at]
            if kind == "open" and not run.has_told:
                must = must or run.spent == rest[1]
                yield self._told(state, run)
            elif kind in ("work", "open") and run.spent >= rest[0]:
                must = must or run.spent == rest[1]
                yield self._go_on(state, run)
            elif kind == "call" and len(rest) > 2 and run.spent == rest[2]:
                must = True
                self.found.late.add(run.name)
                yield self._go_on(self._given_up(state, run.name), run)
        if not must:
            yield _later(state)

    def _strike(self, state: _State, number: int) -> _State:
        timer = self.timers[number]
        state = state._replace(strikes=_with(state.strikes, number, timer["period"]))
        if state.due[number] >= 0:
            self.found.missed.add(timer["name"])
            return state
        return state._replace(due=_with(state.due, number, 0))

    def _into(self, name: str, depth: int, queue: tuple[Any, ...], what: object) -> tuple[Any, ...]:
        if len(queue) == depth:
            self.found.lost.add(name)
            queue = queue[1:]
        self.found.longest[name] = max(self.found.longest[name], len(queue) + 1)
        return (*queue, what)

    def _arrive(self, state: _State, pair: int) -> _State:
        number = self.pairs[pair][1]
        reader = self.readers[number]
        queue = self._into(reader["name"], reader["depth"], state.queues[number], 0)
        return state._replace(
            flights=_with(state.flights, pair, state.flights[pair][1:]),
            queues=_with(state.queues, number, queue),
        )

    def _ask(self, state: _State, client: int) -> _State:
        name = self.clients[client]
        (_, is_live), *rest = state.requests[client]
        number = next(n for n, each in enumerate(self.servers) if each["service"] == self.calls[name][1])
        queue = self._into(self.servers[number]["name"], DEPTH, state.asked[number], (name, 0, is_live))
        return state._replace(
            requests=_with(state.requests, client, tuple(rest)), asked=_with(state.asked, number, queue)
        )

    def _answer(self, state: _State, client: int) -> _State:
        (_, is_live), *rest = state.responses[client]
        return state._replace(
            responses=_with(state.responses, client, tuple(rest)),
            answered=_with(state.answered, client, (*state.answered[client], is_live)),
        )

    def _is_free(self, state: _State, node: str, group: str) -> bool:
        groups = [
            self.callbacks[run.name]["group"]
            for run in state.running
            if self.callbacks[run.name]["node"] == node
        ]
        return len(groups) < self.threads[node] and (group == "reentrant" or group not in groups)

    def _begun(self, state: _State) -> Iterator[_State]:
        for number, timer in enumerate(self.timers):
            if state.due[number] >= 0 and self._is_free(state, timer["node"], timer["group"]):
                left = state._replace(due=_with(state.due, number, -1))
                yield _running(left, _Run(timer["name"], 0, 0, state.due[number]))
        for number, reader in enumerate(self.readers):
            if state.queues[number] and self._is_free(state, reader["node"], reader["group"]):
                age = state.queues[number][0]
                left = state._replace(queues=_with(state.queues, number, state.queues[number][1:]))
                yield _running(left, _Run(reader["name"], 0, 0, age))
        for number, server in enumerate(self.servers):
            if state.asked[number] and self._is_free(state, server["node"], server["group"]):
                (client, age, is_live), *rest = state.asked[number]
                left = state._replace(asked=_with(state.asked, number, tuple(rest)))
                yield _running(left, _Run(server["name"], 0, 0, age, client, is_live))

    def _taken(self, state: _State) -> Iterator[_State]:
        """Take a response, which wakes its caller unless it has given up."""
        for number, name in enumerate(self.clients):
            if not state.answered[number]:
                continue
            if self._is_free(state, self.callbacks[name]["node"], self.calls[name][2]):
                is_live, *rest = state.answered[number]
                left = state._replace(answered=_with(state.answered, number, tuple(rest)))
                if is_live:
                    self.found.ends.add(name)
                    (run,) = (each for each in left.running if each.name == name)
                    left = self._go_on(left, run)
                yield left

    def _given_up(self, state: _State, name: str) -> _State:
        client = self.clients.index(name)

        def late(messages: tuple[tuple[int, bool], ...]) -> tuple[tuple[int, bool], ...]:
            return tuple((age, False) for age, _ in messages)

        return state._replace(
            requests=_with(state.requests, client, late(state.requests[client])),
            asked=tuple(
                tuple((who, age, live and who != name) for who, age, live in queue) for queue in state.asked
            ),
            responses=_with(state.responses, client, late(state.responses[client])),
            answered=_with(state.answered, client, (False,) * len(state.answered[client])),
            running=tuple(
                sorted(run._replace(is_live=run.is_live and run.client != name) for run in state.running)
            ),
        )

    def _told(self, state: _State, run: _Run) -> _State:
        each = self.callbacks[run.name]
        runs = list(state.running)
        runs.remove(run)
        state = self._published(state._replace(running=tuple(runs)), each["node"], each["script"][run.at][3])
        return _running(state, run._replace(has_told=True))

    def _published(self, state: _State, node: str, topic: str) -> _State:
        for number, (publisher, _) in enumerate(self.pairs):
            if publisher == (node, topic):
                flight = (*state.flights[number], 0)
                state = state._replace(flights=_with(state.flights, number, flight))
        return state

    def _go_on(self, state: _State, run: _Run) -> _State:
        """End a step, and all that follow and take no time."""
        each = self.callbacks[run.name]
        runs = list(state.running)
        runs.remove(run)
        state = state._replace(running=tuple(runs))
        for at in range(run.at + 1, len(each["script"])):
            kind, *rest = each["script"][at]
            if kind == "publish":
                state = self._published(state, each["node"], rest[0])
                continue
            if kind == "call":
                client = self.clients.index(run.name)
                sent = (*state.requests[client], (0, True))
                state = state._replace(requests=_with(state.requests, client, sent))
            return _running(state, run._replace(at=at, spent=0, has_told=False))
        _note(self.found.response, run.name, run.age)
        if run.client:
            client = self.clients.index(run.client)
            sent = (*state.responses[client], (0, run.is_live))
            state = state._replace(responses=_with(state.responses, client, sent))
        return state


def _running(state: _State, run: _Run) -> _State:
    return state._replace(running=_sorted(state.running, run))


def _later(state: _State) -> _State:
    def older(ways: tuple[tuple[tuple[int, bool], ...], ...]) -> tuple[tuple[tuple[int, bool], ...], ...]:
        return tuple(tuple((age + 1, live) for age, live in way) for way in ways)

    return _State(
        tuple(left - 1 for left in state.strikes),
        tuple(age + (age >= 0) for age in state.due),
        tuple(tuple(age + 1 for age in flight) for flight in state.flights),
        tuple(tuple(age + 1 for age in queue) for queue in state.queues),
        older(state.requests),
        tuple(tuple((who, age + 1, live) for who, age, live in queue) for queue in state.asked),
        older(state.responses),
        state.answered,
        tuple(run._replace(spent=run.spent + 1, age=run.age + 1) for run in state.running),
    )
