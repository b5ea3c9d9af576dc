"""A plain program that finds reaction times and data ages, in whole units of time.

It knows no Petri nets and no observers. It says what both words mean on data itself:

* An output is the end of a run of the last callback. Its data is as old as the release that it comes from.
  The data age is how old the data of an output is when the next output comes.
* Something happens just after a release. It shows in the first output with data of a later release. The
  reaction time goes from the first release to that output.

Executors, threads, groups and histories are those of `tests.support.timed_systems.threads`. A callback may
store a value when it ends, and read values: a timer when it begins, a subscription when it ends.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from tests.support.timed_systems.threads import TOLD, Threads, _State, _with

OTHER = -1
LONGEST = 400
"""No time is measured for longer: it counts as unbounded."""


class Ages(NamedTuple):
    """The greatest reaction time and data age; None if nothing bounds it or there is none."""

    reaction: int | None
    age: int | None
    is_unbounded: bool = False


class _Marked(NamedTuple):
    """A tick or message: how long it is on its way, and what is known of the release it comes from.

    `since` is how long ago that was, where ages are asked, and whether it is a later release (1), where
    reactions are. It is `OTHER` for data of other timers.
    """

    age: int
    timer: str
    since: int

    def older(self) -> _Marked:
        return self._replace(age=self.age + 1)


class _Watch(NamedTuple):
    """What is measured: a time, and at which step."""

    time: int | None = None
    step: str = "idle"
    values: tuple[int, ...] = ()


class Reacting(Threads):
    """Explores a system, as `tests.support.timed_systems.models` reads it, from a timer to a callback.

    Parameters
    ----------
    system : dict
        The system.
    first, last : str
        A timer, and the callback whose ends are outputs.
    """

    def __init__(self, system: dict[str, Any], first: str, last: str) -> None:
        super().__init__(system)
        self.first, self.last = first, last
        self.values = sorted({each["stores"] for each in system["callbacks"] if "stores" in each})
        self.asks = ""
        self.measured: list[int] = []
        self.is_unbounded = False

    def ages(self, most: int) -> Ages:
        """Return both; `TooManyStatesError` if there are more states than `most` for one of them."""
        found: dict[str, int | None] = {}
        is_unbounded = False
        for self.asks in ("reaction", "age"):
            self.measured, self.is_unbounded = [], False
            self.explore(most)
            found[self.asks] = None if self.is_unbounded else max(self.measured, default=None)
            is_unbounded |= self.is_unbounded
        return Ages(found["reaction"], found["age"], is_unbounded)

    def explore(self, most: int) -> Any:
        """Explore from each start."""
        nothing = _Watch(values=(OTHER,) * len(self.values))
        return self._all_from([self._watched(state, nothing) for state in self._starts()], most)

    def _watched(self, state: _State, watch: _Watch) -> _State:
        return state._replace(beside=watch)

    def _tick(self, state: _State, number: int) -> _State:
        raise NotImplementedError  # `_ticks` has several outcomes

    def _ticks(self, state: _State, number: int) -> Iterator[_State]:
        """Yield what a tick leads to: a release of the first callback may be the one that is measured."""
        name = self.timers[number]["name"]
        if state.due[number] is not None:
            yield state
            return
        watch: _Watch = state.beside
        since = OTHER
        if name == self.first:
            since = 0 if self.asks == "age" else int(watch.step == "armed")
        after = state._replace(due=_with(state.due, number, _Marked(0, "", since)))
        yield after
        if name == self.first and self.asks == "reaction" and watch.step == "idle":
            yield self._watched(after, watch._replace(time=0, step="armed"))

    def _successors(self, state: _State) -> Iterator[_State]:
        must = False
        for number, left in enumerate(state.strikes):
            if left == 0:
                must = True
                yield self._strike(state, number)
            if state.late[number]:
                must = must or state.late[number][0] == self.timers[number].get("jitter", 0)
                late = _with(state.late, number, state.late[number][1:])
                yield from self._ticks(state._replace(late=late), number)
        for pair, (least, most) in enumerate(self.latency):
            if state.flights[pair] and state.flights[pair][0].age >= least:
                must = must or state.flights[pair][0].age == most
                yield self._arrive(state, pair)
        for begun in self._begun(state):
            must = True
            yield self._read_by_timer(state, begun)
        for run in state.running:
            least, most = self.callbacks[run[0]]["script"][0][1:3]
            if run[0] in self.open:
                must = must or run[1] == most
                yield self._tell(state, run)
            elif run[1] >= least:
                must = must or run[1] == most
                yield self._end(state, run)
        if not must and (later := self._later(state)) is not None:
            yield later

    def _read_by_timer(self, before: _State, begun: _State) -> _State:
        """Let a timer's callback that begins read values."""
        fresh = list(begun.running)
        for run in before.running:
            fresh.remove(run)
        ((name, works, data),) = fresh
        if "period" not in self.callbacks[name]:
            return begun
        read: Any = (name, works, self._reads(begun, name, data))
        return begun._replace(running=tuple(sorted((*before.running, read))))

    def _reads(self, state: _State, name: str, data: Any) -> Any:
        for value in self.callbacks[name].get("samples", ()):
            stored = state.beside.values[self.values.index(value)]
            if stored != OTHER:
                data = data._replace(since=stored)
        return data

    def _end(self, state: _State, run: tuple[str, int, Any]) -> _State:
        name, _, data = run
        is_told, plain = name.endswith(TOLD), name.removesuffix(TOLD)
        each = self.callbacks[plain]
        runs = list(state.running)
        runs.remove(run)
        after = state._replace(running=tuple(runs))
        if "topic" in each:
            data = self._reads(after, plain, data)
        watch: _Watch = after.beside
        if "stores" in each:
            watch = watch._replace(values=_with(watch.values, self.values.index(each["stores"]), data.since))
        if plain == self.last:
            watch = self._shown(watch, data)
        after = self._watched(after, watch)
        return after if is_told else self._publish(after, plain, data)

    def _shown(self, watch: _Watch, data: _Marked) -> _Watch:
        """Measure at an output."""
        if self.asks == "age":
            if watch.time is not None:
                self.measured.append(watch.time)
            return watch._replace(time=None if data.since == OTHER else data.since)
        if data.since == 1 and watch.step == "armed":
            assert watch.time is not None
            self.measured.append(watch.time)
            return watch._replace(time=None, step="done")
        return watch

    def _later(self, state: _State) -> Any:
        """Return the state a unit later; None if nothing more is measured."""
        watch: _Watch = state.beside
        if watch.step == "done":
            return None
        time = None if watch.time is None else watch.time + 1
        if time is not None and time > LONGEST:
            self.is_unbounded = True
            return None
        ages = self.asks == "age"

        def older(data: Any) -> Any:
            return data._replace(since=data.since + 1) if ages and data.since != OTHER else data

        values = watch.values
        if ages:
            values = tuple(OTHER if each == OTHER else each + 1 for each in values)
        return _State(
            tuple(left - 1 for left in state.strikes),
            tuple(tuple(age + 1 for age in late) for late in state.late),
            tuple(None if due is None else older(due) for due in state.due),
            tuple(tuple(older(each) for each in queue) for queue in state.queues),
            tuple(tuple(older(each.older()) for each in flight) for flight in state.flights),
            tuple(sorted((name, works + 1, older(data)) for name, works, data in state.running)),
            state.results,
            watch._replace(time=time, values=values),
        )
