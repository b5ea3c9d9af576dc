"""A plain program that follows data through callbacks that store values and others that read them later.

It knows no Petri nets and no observers: every message, value and output carries the time since the release
that its data comes from. Nodes have one thread, and take what is ready in any order; each callback works
once, and then publishes or stores. A timer reads stored values when its callback begins, a subscription when
its callback ends.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from tests.support.reachability import explored

Data = tuple[int, bool] | None
"""Time since the release; whether no output has come of it before."""


class Times(NamedTuple):
    """Least and greatest time to the first output, whether data is lost before, greatest age of an output."""

    least: int | None
    greatest: int | None
    lost: bool
    age: int | None


class _State(NamedTuple):
    strikes: tuple[int, ...]
    due: tuple[tuple[Data] | None, ...]
    queues: tuple[tuple[Data, ...], ...]
    flights: tuple[tuple[tuple[int, Data], ...], ...]
    running: tuple[tuple[str, int, Data] | None, ...]
    values: tuple[Data, ...]
    shown: Data


class SampledExplorer:
    """Explores a system, as `tests.support.timed_systems.models` reads it, from a callback to another one."""

    def __init__(self, system: dict[str, Any], first: str, last: str) -> None:
        self.first, self.last = first, last
        self.nodes = list(system["nodes"])
        self.callbacks = {each["name"]: each for each in system["callbacks"]}
        self.timers = [each for each in system["callbacks"] if "period" in each]
        self.readers = [each for each in system["callbacks"] if "topic" in each]
        self.values = sorted({each["stores"] for each in system["callbacks"] if "stores" in each})
        self.pairs = [
            (writer["name"], number)
            for writer in system["callbacks"]
            for step in writer["script"]
            if step[0] == "publish"
            for number, reader in enumerate(self.readers)
            if reader["topic"] == step[1]
        ]
        self.latency = [system["latency"].get(self.readers[n]["topic"], (0, 0)) for _, n in self.pairs]
        self.times: list[int] = []
        self.ages: list[int] = []
        self.lost = False

    def explore(self, most: int = 300_000) -> Times:
        """Return the times; `TooManyStatesError` if there are more states than `most`."""
        starts = [
            _State(
                tuple(timer["offset"] for timer in self.timers),
                (None,) * len(self.timers),
                ((),) * len(self.readers),
                ((),) * len(self.pairs),
                (None,) * len(self.nodes),
                (None,) * len(self.values),
                None,
            )
        ]
        explored(starts, self.successors, most)
        return Times(
            min(self.times, default=None),
            max(self.times, default=None),
            self.lost,
            max(self.ages, default=None),
        )

    def successors(self, state: _State) -> Iterator[_State]:
        """Yield what can come next; time passes only if nothing has to happen."""
        must = False
        for number, left in enumerate(state.strikes):
            if left == 0:
                must = True
                yield self._strike(state, number)
        for pair, (least, most) in enumerate(self.latency):
            if state.flights[pair] and state.flights[pair][0][0] >= least:
                must = must or state.flights[pair][0][0] == most
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
            return state._replace(strikes=strikes)
        data: Data = (0, True) if timer["name"] == self.first else None
        return state._replace(strikes=strikes, due=_with(state.due, number, (data,)))

    def _arrive(self, state: _State, pair: int) -> _State:
        number = self.pairs[pair][1]
        (_, data), *rest = state.flights[pair]
        queue = (*state.queues[number], data)
        if len(queue) > self.readers[number]["depth"]:
            self._lose(queue[0])
            queue = queue[1:]
        return state._replace(
            flights=_with(state.flights, pair, tuple(rest)), queues=_with(state.queues, number, queue)
        )

    def _lose(self, data: Data) -> None:
        self.lost = self.lost or (data is not None and data[1])

    def _begin(self, state: _State, node: int) -> Iterator[_State]:
        name = self.nodes[node]
        for number, timer in enumerate(self.timers):
            due = state.due[number]
            if timer["node"] == name and due is not None:
                begun = state._replace(due=_with(state.due, number, None))
                data, begun = self._read(begun, timer, due[0])
                yield begun._replace(running=_with(state.running, node, (timer["name"], 0, data)))
        for number, reader in enumerate(self.readers):
            if reader["node"] == name and state.queues[number]:
                data, *rest = state.queues[number]
                begun = state._replace(queues=_with(state.queues, number, tuple(rest)))
                yield begun._replace(running=_with(state.running, node, (reader["name"], 0, data)))

    def _read(self, state: _State, callback: dict[str, Any], data: Data) -> tuple[Data, _State]:
        for name in callback.get("samples", ()):
            number = self.values.index(name)
            value = state.values[number]
            if value is not None:
                data = value
                state = state._replace(values=_with(state.values, number, (value[0], False)))
        return data, state

    def _end(self, state: _State, node: int) -> _State:
        running = state.running[node]
        assert running is not None
        name, _, data = running
        callback = self.callbacks[name]
        state = state._replace(running=_with(state.running, node, None))
        if "topic" in callback:
            data, state = self._read(state, callback, data)
        if "stores" in callback:
            number = self.values.index(callback["stores"])
            self._lose(state.values[number])
            state = state._replace(values=_with(state.values, number, data))
        for number, (writer, _) in enumerate(self.pairs):
            if writer == name:
                flight = (*state.flights[number], (0, data))
                state = state._replace(flights=_with(state.flights, number, flight))
        if name == self.last:
            if state.shown is not None:
                self.ages.append(state.shown[0])
            if data is not None and data[1]:
                self.times.append(data[0])
            state = state._replace(shown=data)
        return state

    def _pass(self, state: _State) -> _State:
        return _State(
            tuple(left - 1 for left in state.strikes),
            tuple(None if due is None else (_older(due[0]),) for due in state.due),
            tuple(tuple(map(_older, queue)) for queue in state.queues),
            tuple(tuple((age + 1, _older(data)) for age, data in flight) for flight in state.flights),
            tuple(None if one is None else (one[0], one[1] + 1, _older(one[2])) for one in state.running),
            tuple(map(_older, state.values)),
            _older(state.shown),
        )


def _older(data: Data) -> Data:
    return None if data is None else (data[0] + 1, data[1])


def _with(values: tuple[Any, ...], number: int, value: Any) -> tuple[Any, ...]:
    return (*values[:number], value, *values[number + 1 :])
