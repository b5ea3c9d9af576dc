"""The health of a node: its marking, queues, handlers and signals, and what it waits for.

`HealthWatch.look` collects it on the node's thread, about once a second, from counters that exist anyway. A
queue, handler or signal that exceeds its budget is a `Concern`. It names the element of the model and is
logged once when it begins.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import islice
from types import MappingProxyType
from typing import Literal

from dineros.metamodel.clauses import SignalSetting
from dineros.runtime.firing.durations import HandlerTime
from dineros.runtime.nets.weights import MOST_BYTES
from dineros.runtime.nodes.core import Core
from dineros.runtime.nodes.responses import ResponseTime
from dineros.runtime.nodes.snapshot import Snapshot, snapshot

LOG = logging.getLogger("dineros.runtime")

FULL = 0.8
"""Share of its capacity above which a queue is a concern."""

MOST = 200
"""Maximum number of places, queues, handlers and so on that are reported, since listeners process them."""

RESTARTS = "DINEROS_RESTARTS"
"""Environment variable: number of restarts of a process, set by its supervisor."""

Budget = Literal["queue-fill", "handler-time", "signal-age", "place-limit", "callback-time"]


@dataclass(frozen=True, slots=True)
class QueueFill:
    """The highest fill level of a subscriber's queue since the last look.

    Attributes
    ----------
    place, channel, topic : str
        The place onto which tokens for the messages of this topic are put.
    waiting, capacity : int
        Messages that waited, and the proved capacity of the queue.
    held : int
        Messages that wait for room on their place now.
    """

    place: str
    channel: str
    topic: str
    waiting: int
    capacity: int
    held: int = 0

    @property
    def is_nearly_full(self) -> bool:
        """Whether it is above 80 %; False for a queue of one message, which is full at every message."""
        return self.capacity > 1 and self.waiting > FULL * self.capacity


@dataclass(frozen=True, slots=True)
class SignalAge:
    """Seconds since a signal was last set, or None; `limit`: the longest allowed silence, or None."""

    signal: str
    value: SignalSetting
    age: float | None
    limit: float | None
    is_stale: bool
    values: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Wait:
    """A part of the node that waits.

    Attributes
    ----------
    element : str
        The waiting part: a client, a transition, a place, or the node.
    kind : {"service", "action", "handler", "room", "proceed"}
        What it waits for: a response, a goal, the end of a handler, room on a place, or a call of `proceed`.
    on : str
        The name of the service or action, the handler, or the place.
    seconds : float
        Waiting time; 0.0 if it is not measured.
    """

    element: str
    kind: Literal["service", "action", "handler", "room", "proceed"]
    on: str
    seconds: float = 0.0


@dataclass(frozen=True, slots=True)
class Concern:
    """An exceeded budget of an element of the model, with a description."""

    budget: Budget
    element: str
    text: str


@dataclass(frozen=True, kw_only=True)
class Health(Snapshot):
    """The health of a node at one moment: its `Snapshot`, and the load of its parts.

    Attributes
    ----------
    restarts : int
        How many times its process was restarted.
    rate : float
        Firings per second since the last look.
    places : mapping of str to int
        Number of tokens on each place.
    queues, servers, ages, handlers, responses, waits, concerns
        See their classes; `servers`: name of a service -> requests served, instances, requests that wait;
        `ages`: of the signals.
    """

    restarts: int
    rate: float
    places: Mapping[str, int]
    queues: tuple[QueueFill, ...] = ()
    servers: Mapping[str, tuple[int, int, int]] = field(default_factory=dict)
    ages: tuple[SignalAge, ...] = ()
    handlers: tuple[HandlerTime, ...] = ()
    responses: tuple[ResponseTime, ...] = ()
    waits: tuple[Wait, ...] = ()
    concerns: tuple[Concern, ...] = ()


class HealthWatch:
    """Checks one node periodically, and remembers its previous state."""

    def __init__(self, core: Core) -> None:
        self._core = core
        core.measure_responses()
        self._firings = core.execution.firings
        self._looked = core.loop.clock()
        structure = core.structure
        self._limited = [
            (place, limit)
            for place, limit in enumerate(structure.limits)
            if limit is not None and structure.capacities[place] is None
        ]
        """Places without a capacity in the model that have a limit because others can fill them."""
        self._concerns: dict[tuple[Budget, str], Concern] = {}
        told = os.environ.get(RESTARTS, "")
        self._restarts = int(told) if told.isascii() and told.isdigit() and len(told) < 10 else 0

    def look(self) -> Health:
        """Return the health of the node; on its thread."""
        core, now = self._core, self._core.loop.clock()
        execution, exchange, engine = core.execution, core.exchange, core.engine
        state, passed = snapshot(core), now - self._looked
        rate = (state.firings - self._firings) / passed if passed > 0 else 0.0
        self._firings, self._looked = state.firings, now
        places = core.structure.places[:MOST]
        queues, ages = tuple(self._queues()), tuple(self._ages(now))
        handlers = tuple(replace(time) for time in islice(execution.durations, MOST))
        execution.durations.forget_longest()
        responses: tuple[ResponseTime, ...] = ()
        if (measured := core.observers.responses) is not None:
            responses = tuple(replace(time) for time in islice(measured.times.values(), MOST))
            measured.forget_longest()
        servers = {} if exchange is None else exchange.servers
        return Health(
            **vars(state),
            restarts=self._restarts,
            rate=rate,
            places=MappingProxyType({id: engine.count(place) for place, id in enumerate(places)}),
            queues=queues,
            servers={
                port.service: (each.busy, port.instances, len(each.waiting)) for port, each in servers.items()
            },
            ages=ages,
            handlers=handlers,
            responses=responses,
            waits=tuple(self._waits(state, now))[:MOST],
            concerns=self._judge(
                [*_concerns(queues, ages, handlers), *_slow(responses), *self._full_places()]
            ),
        )

    def _queues(self) -> Iterator[QueueFill]:
        core = self._core
        if core.arrivals is not None:
            for port in core.structure.ports.subscribers[:MOST]:
                waiting, held = core.arrivals.most_waiting(port), core.arrivals.held(port)
                yield QueueFill(port.place, port.channel, port.topic, waiting, max(1, port.limit), held)

    def _ages(self, now: float) -> Iterator[SignalAge]:
        core = self._core
        stale = set(core.expectations.stale)
        for number, id in enumerate(core.structure.signals[:MOST]):
            heard = core.heard.get(number)
            age = None if heard is None else max(0.0, now - heard)
            yield SignalAge(
                id,
                core.engine.signals[number],
                age,
                core.expectations.limit(number),
                id in stale,
                core.structure.ports.signals[number].values,
            )

    def _waits(self, state: Snapshot, now: float) -> Iterator[Wait]:
        core, exchange = self._core, self._core.exchange
        if state.halted is not None:
            yield Wait(core.structure.ports.node, "proceed", state.halted)
        for flight in state.in_flight:
            yield Wait(flight.transition, "handler", flight.handler, flight.seconds)
        if exchange is None:
            return
        for port, client in exchange.clients.items():
            for call in client.calls.values():
                yield Wait(port.client, "service", port.service, max(0.0, now - call.asked))
        for goals_port, goals_client in exchange.actions.clients.items():
            for _ in goals_client.goals:
                yield Wait(goals_port.client, "action", goals_port.action)
        if core.arrivals is not None:
            for subscriber in core.structure.ports.subscribers:
                if core.arrivals.held(subscriber):
                    yield Wait(subscriber.topic, "room", subscriber.place)

    def _full_places(self) -> Iterator[Concern]:
        """Yield the places at a limit that is not a capacity of the model."""
        for place, limit in islice(self._limited, MOST):
            engine, id = self._core.engine, self._core.structure.places[place]
            if engine.count(place) >= limit:
                text = (
                    f"place {id} holds {limit:,} tokens and accepts no more; the model gives it no capacity"
                )
                yield Concern("place-limit", id, text)
            elif place in engine.weights.heavy:
                held = f"{MOST_BYTES >> 20} MiB in {engine.count(place):,} tokens"
                text = f"place {id} holds {held} and accepts no more; the model gives it no capacity"
                yield Concern("place-limit", id, text)

    def _judge(self, concerns: Iterable[Concern]) -> tuple[Concern, ...]:
        """Return the exceeded budgets; log those that are new and those that are over."""
        found = {(concern.budget, concern.element): concern for concern in concerns}
        for key, concern in found.items():
            # A stale signal was logged by `stale_after` already.
            if key not in self._concerns and concern.budget != "signal-age":
                LOG.warning("%s [%s]", concern.text, concern.budget)
        for key in self._concerns.keys() - found.keys():
            if key[0] == "queue-fill":
                LOG.info("the queue of %s is below %g %% again", key[1], 100 * FULL)
        self._concerns = found
        return tuple(found.values())


def _slow(responses: tuple[ResponseTime, ...]) -> Iterator[Concern]:
    """Yield callbacks that exceeded their declared time, or lost ticks, since the last look."""
    for time in responses:
        said = []
        most = None if time.declared is None else time.declared[1]
        if most is not None and time.longest_run > most:
            said.append(
                f"the callback {time.callback} took {time.longest_run:.3g} s; declared: at most {most:g} s"
            )
        if time.lost_lately:
            ticks = "1 tick" if time.lost_lately == 1 else f"{time.lost_lately:,} ticks"
            said.append(f"the timer of {time.callback} lost {ticks}")
        if said:
            yield Concern("callback-time", time.callback, "; ".join(said))


def _concerns(
    queues: tuple[QueueFill, ...], ages: tuple[SignalAge, ...], handlers: tuple[HandlerTime, ...]
) -> Iterator[Concern]:
    for queue in queues:
        if queue.is_nearly_full:
            text = (
                f"the queue of {queue.place} (topic {queue.topic}) held {queue.waiting} of {queue.capacity}"
            )
            yield Concern("queue-fill", queue.place, text)
    for load in handlers:
        if load.budget is not None and load.longest > load.budget:
            text = (
                f"the handler {load.handler} of {load.transition} took {load.longest:.3g} s, "
                f"its budget is {load.budget:g} s"
            )
            yield Concern("handler-time", load.transition, text)
    for signal in ages:
        if signal.is_stale:
            text = f"the signal {signal.signal} is stale: not set for {signal.limit or 0:g} s"
            yield Concern("signal-age", signal.signal, text)
