"""A plain program that explores goals which call a service, in whole units of time. It knows no Petri nets.

Each of some engines sends one goal to an action, whose slots each have a thread. A goal works, calls a
service, waits for the response and works again. The service has a node of its own with one thread.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from random import Random
from typing import NamedTuple, TypeVar

from dineros.metamodel import sym
from dineros.metamodel.build import callback, here, node_net, place, seconds, step
from dineros.metamodel.constraints import validate
from tests.support.reachability import explored

Span = tuple[int, int]
_T = TypeVar("_T", int, tuple[str, int])


@dataclass(frozen=True)
class GoalCalls:
    """A system. All times are in units."""

    clients: int
    reaction: int
    """The most time in which a client sends its goal."""
    before: Span
    """Work of a goal before it calls."""
    after: Span
    serve: Span
    """Work of the service."""
    slots: int
    latency: Span = (0, 0)
    """Of each goal."""
    way: Span = (0, 0)
    """Of each request and each response."""

    @classmethod
    def drawn(cls, random: Random) -> GoalCalls:
        """Return a random system."""

        def span(most: int, wider: int) -> Span:
            least = random.randint(0, most)
            return least, least + random.randint(0, wider)

        times = span(1, 1), span(1, 1), span(3, 1)
        ways = random.choice([(0, 0), (0, 1), (0, 2)]), random.choice([(0, 0), (0, 0), (1, 1), (0, 1)])
        return cls(random.randint(1, 3), random.randint(0, 2), *times, random.randint(1, 3), *ways)

    def model(self, is_shared: bool) -> sym.SystemModel:
        """Return the model; the slots share the places of the call, or each has its own."""
        model = sym.SystemModel(id="m", middleware="ros2")
        driver = node_net(model, "driver", execution="callbacks")
        driver.executor, driver.threads = sym.Executor.multi, self.slots + 2
        page = callback(driver, "Drive", "goal")
        goal, there = place(page, "Goal"), place(page, "There")
        request, response = (place(driver if is_shared else page, each) for each in ("Ask", "Answer"))
        for number, (before, after, work) in enumerate(
            [(goal, request, self.before), (response, there, self.after)]
        ):
            made = step(page, f"Step{number}", [here(before, page)], [here(after, page)])
            made.interval = seconds(*work)
        look = callback(node_net(model, "eye", execution="callbacks"), "Look", "server")
        look.duration = seconds(*self.serve)
        entry, exit_ = place(look, "In"), place(look, "Out")
        step(look, "See", [entry], [exit_])
        sym.ServiceChannel(
            id="look",
            service="/look",
            latency=seconds(*self.way),
            server=sym.ServerPort(page=look, entry=entry, exit=exit_),
            clients=[sym.ClientPort(client="driver", request=request, response=response)],
            model=model,
        )
        action = sym.ActionChannel(
            id="Act",
            action="/act",
            instances=self.slots,
            latency=seconds(*self.latency),
            server=sym.ActionServerPort(page=page, entry=goal, succeeded=there),
            model=model,
        )
        for number in range(self.clients):
            sender = node_net(model, f"sender{number}")
            sender.reaction = seconds(0, self.reaction)
            sent, done = place(sender, f"Send{number}"), place(sender, f"Done{number}")
            step(sender, f"Go{number}", [place(sender, f"Wish{number}", 1)], [sent])
            action.clients.append(sym.ActionClientPort(client=str(sender.id), goal=sent, succeeded=done))
        assert [str(each) for each in validate(model) if each.severity == "error"] == []
        return model


class _State(NamedTuple):
    time: int
    """Until the last client sends its goal."""
    waiting: int
    """Clients that have not sent their goal."""
    flights: tuple[int, ...]
    """Ages of goals on their way, and of those that have arrived and wait for a slot (-1)."""
    goals: tuple[tuple[str, int], ...]
    """Phase (`before`, `call`, `after`) and time in it, by goal that a slot works on."""
    requests: tuple[int, ...]
    asked: tuple[int, ...]
    """Ages of requests since they arrived, in order; the server works on the first one."""
    spent: int
    responses: tuple[int, ...]


class Explorer:
    """Explores a system.

    Attributes
    ----------
    response : tuple of int, int
        Least and greatest time from the arrival of a request to the end of its service.
    """

    def __init__(self, system: GoalCalls, most_states: int) -> None:
        self._system = system
        self.response: tuple[int, int] | None = None
        start = _State(system.reaction, system.clients, (), (), (), (), 0, ())
        explored([start], self._successors, most_states)

    def _successors(self, state: _State) -> Iterator[_State]:
        """Yield what may happen now; time passes unless something must."""
        system, must = self._system, False
        if state.waiting:
            must |= state.time == 0
            yield state._replace(waiting=state.waiting - 1, flights=_put(state.flights, 0))
        if -1 in state.flights and len(state.goals) < system.slots:
            goals = _put(state.goals, ("before", 0))
            yield state._replace(flights=_without(state.flights, -1), goals=goals)
            return
        for age in {age for age in state.flights if age >= system.latency[0]}:
            must |= age == system.latency[1]
            yield state._replace(flights=_put(_without(state.flights, age), -1))
        for age in {age for age in state.requests if age >= system.way[0]}:
            must |= age == system.way[1]
            asked = (*state.asked, 0)
            yield state._replace(requests=_without(state.requests, age), asked=asked)
        for age in {age for age in state.responses if age >= system.way[0]}:
            must |= age == system.way[1]
            goals = _put(_without(state.goals, ("call", 0)), ("after", 0))
            yield state._replace(responses=_without(state.responses, age), goals=goals)
        if state.asked and state.spent >= system.serve[0]:
            must |= state.spent == system.serve[1]
            least, most = self.response or (state.asked[0],) * 2
            self.response = min(least, state.asked[0]), max(most, state.asked[0])
            yield state._replace(asked=state.asked[1:], spent=0, responses=_put(state.responses, 0))
        for phase, spent in set(state.goals):
            least, most = {"before": system.before, "after": system.after}.get(phase, (99, 99))
            if spent >= least:
                must |= spent == most
                goals = _without(state.goals, (phase, spent))
                if phase == "before":
                    goals = _put(goals, ("call", 0))
                    yield state._replace(goals=goals, requests=_put(state.requests, 0))
                else:
                    yield state._replace(goals=goals)
        if not must:
            yield state._replace(
                time=max(0, state.time - 1),
                flights=tuple(age if age < 0 else age + 1 for age in state.flights),
                goals=tuple((phase, spent + (phase != "call")) for phase, spent in state.goals),
                requests=_older(state.requests),
                asked=_older(state.asked),
                spent=min(state.spent + bool(state.asked), system.serve[1]),
                responses=_older(state.responses),
            )


def _older(ages: tuple[int, ...]) -> tuple[int, ...]:
    return tuple(age + 1 for age in ages)


def _put(among: tuple[_T, ...], one: _T) -> tuple[_T, ...]:
    longer = list(among)
    longer.append(one)
    return tuple(sorted(longer))


def _without(among: tuple[_T, ...], one: _T) -> tuple[_T, ...]:
    left = list(among)
    left.remove(one)
    return tuple(left)
