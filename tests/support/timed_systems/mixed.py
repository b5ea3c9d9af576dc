"""A plain program that mixes features of executors, engines, services and messages, in whole units of time.

It knows no Petri nets and no rules. Callbacks may be in reentrant groups on several threads, call a service
(with a time-out or without), publish at any moment of their work, and start with a jitter. Messages may have
lifespans, readers deadlines. A node with a `reaction` is an engine: each of its callbacks takes a message and
passes it on. An executor of one thread with an order has a wait result. What happens at the same moment may
happen in any order.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from tests.support.reachability import TooManyStatesError
from tests.support.timed_systems.threads import _note, _offsets, _with

DEPTH = 10
"""Requests that a server keeps."""


class Mixture(NamedTuple):
    """What can happen.

    Attributes
    ----------
    longest : dict from str to int
        The greatest number of messages in each history of a reader or server.
    lost, missed, expired, overdue : set of str
        Readers and servers that can lose a message or request; timers that can lose a tick; readers of which
        a message can be too old, and of which the deadline can end.
    response : dict from str to tuple of int
        Of each callback: least and greatest time from its release to its end.
    """

    longest: dict[str, int]
    lost: set[str]
    missed: set[str]
    expired: set[str]
    overdue: set[str]
    response: dict[str, tuple[int, int]]


class _Message(NamedTuple):
    age: int
    """Since its arrival; on its way and before, since it was sent."""
    since: int
    """Since it was sent."""


class _Request(NamedTuple):
    """A request or response: whose it is, which run waits for it (0: none any more), and its age."""

    client: str
    number: int
    age: int = 0


class _Run(NamedTuple):
    name: str
    at: int
    """The step that it does."""
    spent: int
    """Time in this step."""
    age: int
    """Since its release."""
    number: int = 0
    """Of a run that waits for a response: which one of its callback."""
    has_told: bool = False
    client: str = ""
    asked: int = 0
    """`client`, `asked`: of a server, whose request it is, and the number of the run that waits for it."""


class _State(NamedTuple):
    strikes: tuple[int, ...]
    jitters: tuple[tuple[int, ...], ...]
    due: tuple[int, ...]
    """By timer, how long a tick waits; -1: none does."""
    flights: tuple[tuple[_Message, ...], ...]
    queues: tuple[tuple[_Message, ...], ...]
    taking: tuple[int, ...]
    """By reader of an engine, how long it could take a message; -1: it cannot."""
    hands: tuple[tuple[int, int] | None, ...]
    """By reader of an engine, the message in hand: how long it is, and its age since its arrival."""
    watches: tuple[int, ...]
    """By reader, how long its deadline runs; -1: it does not."""
    requests: tuple[tuple[_Request, ...], ...]
    """By client, on their way."""
    asked: tuple[tuple[_Request, ...], ...]
    """By server."""
    responses: tuple[tuple[_Request, ...], ...]
    answered: tuple[tuple[_Request, ...], ...]
    """`responses`, `answered`: by client, on their way and waiting."""
    running: tuple[_Run, ...]
    results: tuple[frozenset[str], ...]
    """By node with an order: what is left of its wait result."""


class Mixed:
    """Explores a system, as `tests.support.timed_systems.models` reads it.

    A callback calls once at most. A topic has one publisher. Besides, a system may have a `lifespan` and a
    `deadline` by topic.
    """

    def __init__(self, system: dict[str, Any]) -> None:
        nodes = system["nodes"]
        self.reactions = {name: node["reaction"] for name, node in nodes.items() if "reaction" in node}
        self.threads = {name: node["threads"] for name, node in nodes.items()}
        self.ordered = [
            name for name, node in nodes.items() if node.get("order", "any") != "any" and node["threads"] == 1
        ]
        every = system["callbacks"]
        self.callbacks = {each["name"]: each for each in every}
        self.timers = [each for each in every if "period" in each]
        self.readers = [each for each in every if "topic" in each]
        self.servers = [each for each in every if "service" in each]
        self.calls = {each["name"]: step for each in every for step in each["script"] if step[0] == "call"}
        self.clients = list(self.calls)
        self.pairs = [
            (step[-1], number)
            for each in every
            for step in each["script"]
            if step[0] in ("publish", "open")
            for number, reader in enumerate(self.readers)
            if reader["topic"] == step[-1]
        ]
        latency = system["latency"]
        self.latency = [latency.get(topic, (0, 0)) for topic, _ in self.pairs]
        self.of_calls = [latency.get(self.calls[name][1], (0, 0)) for name in self.clients]
        self.lifespans = [system.get("lifespan", {}).get(each["topic"]) for each in self.readers]
        self.deadlines = [system.get("deadline", {}).get(each["topic"]) for each in self.readers]
        histories = [each["name"] for each in (*self.readers, *self.servers)]
        self.found = Mixture(dict.fromkeys(histories, 0), set(), set(), set(), set(), {})

    def explore(self, most: int) -> Mixture:
        """Return what can happen; raises `TooManyStatesError` if there are more than `most` states."""
        starts: list[tuple[int, ...]] = [()]
        for timer in self.timers:
            starts = [(*start, offset) for start in starts for offset in _offsets(timer)]

        def empty(among: list[Any]) -> tuple[Any, ...]:
            return ((),) * len(among)

        timers, readers = len(self.timers), len(self.readers)
        todo = [
            _State(
                strikes=start,
                jitters=empty(self.timers),
                due=(-1,) * timers,
                flights=empty(self.pairs),
                queues=empty(self.readers),
                taking=(-1,) * readers,
                hands=(None,) * readers,
                watches=(-1,) * readers,
                requests=empty(self.clients),
                asked=empty(self.servers),
                responses=empty(self.clients),
                answered=empty(self.clients),
                running=(),
                results=(frozenset(),) * len(self.ordered),
            )
            for start in starts
        ]
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
        for has_to, after in self._moves(state):
            must = must or has_to
            yield after
        if not must:
            yield _later(state)

    def _moves(self, state: _State) -> Iterator[tuple[bool, _State]]:
        """Yield what can happen now, and whether time stands still until something does."""
        yield from self._of_timers(state)
        for pair, (least, most) in enumerate(self.latency):
            if state.flights[pair] and state.flights[pair][0].since >= least:
                yield state.flights[pair][0].since == most, self._arrive(state, pair)
        for number, reader in enumerate(self.readers):
            yield from self._of_reader(state, number, reader["name"], self.reactions.get(reader["node"]))
        for client, (least, most) in enumerate(self.of_calls):
            for way, moved in ((state.requests, self._ask), (state.responses, self._answer)):
                if way[client] and way[client][0].age >= least:
                    yield way[client][0].age == most, moved(state, client)
        for after in (*self._begun(state), *self._taken(state)):
            yield True, after
        for run in state.running:
            kind, *rest = self.callbacks[run.name]["script"][run.at]
            left = _without(state, run)
            if kind == "open" and not run.has_told:
                told = _running(self._published(left, rest[2]), run._replace(has_told=True))
                yield run.spent == rest[1], told
            elif kind in ("work", "open") and run.spent >= rest[0]:
                yield run.spent == rest[1], self._go_on(left, run)
            elif kind == "call" and len(rest) > 2 and run.spent == rest[2]:
                yield True, self._go_on(_forgotten(left, run.name, run.number), run)

    def _of_timers(self, state: _State) -> Iterator[tuple[bool, _State]]:
        for number, timer in enumerate(self.timers):
            if state.strikes[number] == 0:
                struck = state._replace(strikes=_with(state.strikes, number, timer["period"]))
                late = (*state.jitters[number], 0)
                yield True, struck._replace(jitters=_with(state.jitters, number, late))
            if state.jitters[number]:
                first, *others = state.jitters[number]
                ticked = state._replace(jitters=_with(state.jitters, number, tuple(others)))
                if state.due[number] >= 0:
                    self.found.missed.add(timer["name"])
                else:
                    ticked = ticked._replace(due=_with(state.due, number, 0))
                yield first == timer.get("jitter", 0), ticked

    def _of_reader(
        self, state: _State, number: int, name: str, reaction: tuple[int, int] | None
    ) -> Iterator[tuple[bool, _State]]:
        span, queue = self.lifespans[number], state.queues[number]
        if span is not None and queue and queue[0].since >= span:
            self.found.expired.add(name)
            yield True, self._renewed(state._replace(queues=_with(state.queues, number, queue[1:])), number)
        if state.watches[number] >= 0 and state.watches[number] == self.deadlines[number]:
            self.found.overdue.add(name)
            yield True, state._replace(watches=_with(state.watches, number, -1))
        if reaction is None:
            return
        if state.taking[number] >= reaction[0]:
            left = state._replace(
                queues=_with(state.queues, number, queue[1:]),
                hands=_with(state.hands, number, (0, queue[0].age)),
                taking=_with(state.taking, number, -1),
            )
            yield state.taking[number] == reaction[1], left
        hand = state.hands[number]
        if hand is not None and hand[0] >= reaction[0]:
            _note(self.found.response, name, hand[1])
            left = self._renewed(state._replace(hands=_with(state.hands, number, None)), number)
            for _, topic in self.callbacks[name]["script"]:
                left = self._published(left, topic)
            yield hand[0] == reaction[1], left

    def _renewed(self, state: _State, number: int) -> _State:
        """Start or stop the time within which an engine takes a message."""
        can_take = (
            bool(state.queues[number])
            and state.hands[number] is None
            and self.readers[number]["node"] in self.reactions
        )
        taking = max(state.taking[number], 0) if can_take else -1
        return state._replace(taking=_with(state.taking, number, taking))

    def _into(self, name: str, depth: int, queue: tuple[Any, ...], what: object) -> tuple[Any, ...]:
        if len(queue) == depth:
            self.found.lost.add(name)
            queue = queue[1:]
        self.found.longest[name] = max(self.found.longest[name], len(queue) + 1)
        return (*queue, what)

    def _arrive(self, state: _State, pair: int) -> _State:
        number = self.pairs[pair][1]
        first, *rest = state.flights[pair]
        state = state._replace(flights=_with(state.flights, pair, tuple(rest)))
        reader, span = self.readers[number], self.lifespans[number]
        if span is not None and first.since > span:
            self.found.expired.add(reader["name"])
            return state
        first = _Message(0, 0 if span is None else first.since)
        if len(state.queues[number]) == reader["depth"]:
            # A message that is displaced starts the reaction again.
            state = state._replace(taking=_with(state.taking, number, -1))
        queue = self._into(reader["name"], reader["depth"], state.queues[number], first)
        return self._renewed(state._replace(queues=_with(state.queues, number, queue)), number)

    def _ask(self, state: _State, client: int) -> _State:
        first, *rest = state.requests[client]
        number = next(n for n, each in enumerate(self.servers) if each["service"] == self._called(client))
        name = self.servers[number]["name"]
        queue = self._into(name, DEPTH, state.asked[number], first._replace(age=0))
        return state._replace(
            requests=_with(state.requests, client, tuple(rest)), asked=_with(state.asked, number, queue)
        )

    def _called(self, client: int) -> str:
        service: str = self.calls[self.clients[client]][1]
        return service

    def _answer(self, state: _State, client: int) -> _State:
        first, *rest = state.responses[client]
        return state._replace(
            responses=_with(state.responses, client, tuple(rest)),
            answered=_with(state.answered, client, (*state.answered[client], first._replace(age=0))),
        )

    # ---------------------------------------------------------------------------------------------- executors

    def _is_free(self, state: _State, node: str, group: str) -> bool:
        on_node = [self.callbacks[run.name] for run in state.running]
        groups = [each["group"] for each in on_node if each["node"] == node]
        return len(groups) < self.threads[node] and (group == "reentrant" or group not in groups)

    def _ready(self, state: _State) -> Iterator[tuple[str, str, str, int]]:
        """Yield what an executor can take: a callback, its kind, its node, and its number in its kind."""
        for kind, callbacks, waiting in (
            ("timer", self.timers, tuple(age >= 0 for age in state.due)),
            ("reader", self.readers, state.queues),
            ("server", self.servers, state.asked),
        ):
            for number, each in enumerate(callbacks):
                is_engine = each["node"] in self.reactions
                if waiting[number] and not is_engine and self._is_free(state, each["node"], each["group"]):
                    yield each["name"], kind, each["node"], number

    def _begun(self, state: _State) -> Iterator[_State]:
        ready = list(self._ready(state))
        for name, kind, node, number in ready:
            left: _State | None = state
            if node in self.ordered:
                left = self._chosen(state, name, node, [each for each in ready if each[2] == node])
            if left is None:
                continue
            if kind == "timer":
                age = state.due[number]
                yield _running(left._replace(due=_with(state.due, number, -1)), _Run(name, 0, 0, age))
            elif kind == "reader":
                first, *rest = state.queues[number]
                left = left._replace(queues=_with(state.queues, number, tuple(rest)))
                if self.deadlines[number] is not None:
                    left = left._replace(watches=_with(left.watches, number, 0))
                yield _running(left, _Run(name, 0, 0, first.age))
            else:
                asked, *others = state.asked[number]
                left = left._replace(asked=_with(state.asked, number, tuple(others)))
                yield _running(left, _Run(name, 0, 0, asked.age, client=asked.client, asked=asked.number))

    def _chosen(
        self, state: _State, name: str, node: str, ready: list[tuple[str, str, str, int]]
    ) -> _State | None:
        """Return the state after an executor has chosen a callback; None if it takes another one first."""
        at, names = self.ordered.index(node), {each[0] for each in ready}
        result = state.results[at] if state.results[at] & names else frozenset(names)
        there = [each for each in ready if each[0] in result]
        first = min(("timer", "reader", "server").index(each[1]) for each in there)
        if name not in {each[0] for each in there if ("timer", "reader", "server").index(each[1]) == first}:
            return None
        return state._replace(results=_with(state.results, at, result - {name}))

    def _taken(self, state: _State) -> Iterator[_State]:
        """Take a response, which wakes the run that waits for it."""
        for client, name in enumerate(self.clients):
            if not state.answered[client]:
                continue
            if self._is_free(state, self.callbacks[name]["node"], self.calls[name][2]):
                first, *rest = state.answered[client]
                left = state._replace(answered=_with(state.answered, client, tuple(rest)))
                runs = [each for each in state.running if (each.name, each.number) == (name, first.number)]
                if first.number and runs:
                    left = self._go_on(_without(left, runs[0]), runs[0])
                yield left

    def _published(self, state: _State, topic: str) -> _State:
        for number, (published, _) in enumerate(self.pairs):
            if published == topic:
                flight = (*state.flights[number], _Message(0, 0))
                state = state._replace(flights=_with(state.flights, number, flight))
        return state

    def _go_on(self, state: _State, run: _Run) -> _State:
        """End a step, and all that follow and take no time."""
        script = self.callbacks[run.name]["script"]
        for at in range(run.at + 1, len(script)):
            kind, *rest = script[at]
            if kind == "publish":
                state = self._published(state, rest[0])
                continue
            number = 0
            if kind == "call":
                used = {each.number for each in state.running if each.name == run.name}
                number = min({*range(1, len(used) + 2)} - used)
                client = self.clients.index(run.name)
                sent = (*state.requests[client], _Request(run.name, number))
                state = state._replace(requests=_with(state.requests, client, sent))
            return _running(state, run._replace(at=at, spent=0, has_told=False, number=number))
        _note(self.found.response, run.name, run.age)
        if run.client:
            client = self.clients.index(run.client)
            sent = (*state.responses[client], _Request(run.client, run.asked))
            state = state._replace(responses=_with(state.responses, client, sent))
        return state


def _running(state: _State, run: _Run) -> _State:
    return state._replace(running=tuple(sorted([*state.running, run])))


def _without(state: _State, run: _Run) -> _State:
    runs = list(state.running)
    runs.remove(run)
    return state._replace(running=tuple(runs))


def _forgotten(state: _State, client: str, number: int) -> _State:
    """Return the state after a run has given up: no run waits for its request."""

    def late(ways: tuple[tuple[_Request, ...], ...]) -> tuple[tuple[_Request, ...], ...]:
        return tuple(
            tuple(
                each._replace(number=0) if (each.client, each.number) == (client, number) else each
                for each in way
            )
            for way in ways
        )

    running = (
        run._replace(asked=0) if (run.client, run.asked) == (client, number) else run for run in state.running
    )
    return state._replace(
        requests=late(state.requests),
        asked=late(state.asked),
        responses=late(state.responses),
        answered=late(state.answered),
        running=tuple(sorted(running)),
    )


def _later(state: _State) -> _State:
    def older(ways: tuple[tuple[_Request, ...], ...]) -> tuple[tuple[_Request, ...], ...]:
        return tuple(tuple(each._replace(age=each.age + 1) for each in way) for way in ways)

    def aged(ways: tuple[tuple[_Message, ...], ...]) -> tuple[tuple[_Message, ...], ...]:
        return tuple(tuple(_Message(age + 1, since + 1) for age, since in way) for way in ways)

    def counted(times: tuple[int, ...]) -> tuple[int, ...]:
        return tuple(time + (time >= 0) for time in times)

    return state._replace(
        strikes=tuple(left - 1 for left in state.strikes),
        jitters=tuple(tuple(late + 1 for late in each) for each in state.jitters),
        due=counted(state.due),
        flights=aged(state.flights),
        queues=aged(state.queues),
        taking=counted(state.taking),
        hands=tuple(None if hand is None else (hand[0] + 1, hand[1] + 1) for hand in state.hands),
        watches=counted(state.watches),
        requests=older(state.requests),
        asked=older(state.asked),
        responses=older(state.responses),
        answered=tuple(tuple(each._replace(age=0) for each in way) for way in state.answered),
        running=tuple(run._replace(spent=run.spent + 1, age=run.age + 1) for run in state.running),
    )
