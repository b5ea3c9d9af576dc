"""A plain program that explores goals of one client which overlap, in whole units of time. It knows no nets.

A client learns that a goal is accepted, asks for its result, and takes the result when the goal is over and
the server has that request. Each message has its own latency, and each goal its own slot and thread.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from random import Random
from typing import NamedTuple

from dineros.metamodel import sym
from dineros.metamodel.build import callback, inhibit, node_net, place, seconds, step
from dineros.metamodel.constraints import validate

Span = tuple[int, int]


@dataclass(frozen=True)
class GoalResults:
    """A system. All times are in units."""

    goals: int
    apart: Span
    """Until the first goal is sent, and between goals."""
    work: Span
    latency: int
    """Most latency of each message; the least is 0."""
    slots: int
    is_engine: bool
    """Whether the client is an engine with a limit of goals under way, or has a timer and no limit."""

    @classmethod
    def drawn(cls, random: Random) -> GoalResults:
        """Return a random system."""
        is_engine = random.random() < 0.5
        least, shortest = random.randint(1, 3), random.randint(0, 4)
        return cls(
            random.randint(1, 3),
            (least, least + random.randint(0, 1) * is_engine),
            (shortest, shortest + random.randint(0, 2)),
            random.randint(0, 2),
            random.randint(1, 2),
            is_engine,
        )

    def model(self, horizon: int) -> sym.SystemModel:
        """Return the model, with a clock that counts the units up to a horizon."""
        model = sym.SystemModel(id="m", middleware="ros2")
        driver = node_net(model, "driver", execution="callbacks")
        driver.executor, driver.threads = sym.Executor.multi, self.slots + 2
        page = callback(driver, "Drive", "goal")
        page.duration = seconds(*self.work)
        goal, there = place(page, "Goal"), place(page, "There")
        step(page, "Work", [goal], [there])
        sender = node_net(model, "sender", execution="net" if self.is_engine else "callbacks")
        if self.is_engine:
            sender.reaction = seconds(0, 0)
            sent, done = place(sender, "Sent"), place(sender, "Done")
            step(sender, "Go", [place(sender, "Wishes", self.goals)], [sent]).interval = seconds(*self.apart)
        else:
            tick = callback(sender, "OnTick", "timer", self.apart[0])
            tick.offset, tick.duration = seconds(self.apart[0], self.apart[0]), seconds(0, 0)
            sent, wishes = place(tick, "Sent"), place(tick, "Wishes", self.goals)
            step(tick, "Go", [wishes], [sent])
            inhibit(wishes, step(tick, "Skip"))
            over = callback(sender, "OnResult", "client")
            over.duration = seconds(0, 0)
            got, done = place(over, "Got"), place(sender, "Done")
            step(over, "Note", [got], [done])
        clock = node_net(model, "clock")
        step(clock, "Pass", [place(clock, "Left", horizon)], [place(clock, "Now")]).interval = seconds(1, 1)
        port = sym.ActionClientPort(client="sender", goal=sent, succeeded=done if self.is_engine else got)
        if self.is_engine:
            port.outstanding = self.goals
        sym.ActionChannel(
            id="Act",
            action="/act",
            instances=self.slots,
            latency=seconds(0, self.latency),
            server=sym.ActionServerPort(page=page, entry=goal, succeeded=there),
            clients=[port],
            model=model,
        )
        assert [str(each) for each in validate(model) if each.severity == "error"] == []
        return model


class _Goal(NamedTuple):
    phase: str
    """`way`, `queue`, `work` or `over`."""
    spent: int
    """Time in that phase; when the goal is over, since the server could send the result."""
    request: str = "none"
    """`learning` of the acceptance, `fetching` the result, or `known` to the server."""
    since: int = 0
    """Time in that phase of the request."""


class _State(NamedTuple):
    now: int
    left: int
    """Goals that are not sent."""
    spent: int
    """Time since the last one was sent."""
    goals: tuple[_Goal, ...]
    results: int


def results_by_time(system: GoalResults, horizon: int) -> set[tuple[int, int]]:
    """Return all pairs of a time and of the number of results that the client has at that time."""
    start = _State(0, system.goals, 0, (), 0)
    known, todo = {start}, [start]
    while todo:
        for after in _successors(system, todo.pop(), horizon):
            if after not in known:
                known.add(after)
                todo.append(after)
    return {(each.now, each.results) for each in known}


def _successors(system: GoalResults, state: _State, horizon: int) -> Iterator[_State]:
    """Yield what may happen now; time passes unless something must."""
    must = False
    if state.left and state.spent >= system.apart[0]:
        must |= state.spent == system.apart[1]
        yield state._replace(left=state.left - 1, spent=0, goals=_put(state.goals, _Goal("way", 0)))
    is_free = sum(each.phase == "work" for each in state.goals) < system.slots
    for goal in set(state.goals):
        others = list(state.goals)
        others.remove(goal)
        for after, is_due in _moves(system, goal, is_free):
            must |= is_due
            if after is None:
                yield state._replace(goals=tuple(others), results=state.results + 1)
            else:
                yield state._replace(goals=_put(tuple(others), after))
    if not must and state.now < horizon:
        goals = tuple(sorted(map(_older, state.goals)))
        yield state._replace(now=state.now + 1, spent=min(state.spent + 1, system.apart[1]), goals=goals)


def _moves(system: GoalResults, goal: _Goal, is_free: bool) -> Iterator[tuple[_Goal | None, bool]]:
    """Yield what may become of a goal next (None: its client has the result), and whether it must now."""
    latency = system.latency
    if goal.phase == "way":
        yield goal._replace(phase="queue", spent=0), goal.spent == latency
    if goal.phase == "queue" and is_free:
        yield _Goal("work", 0, "learning"), True
    if goal.phase == "work" and goal.spent >= system.work[0]:
        yield goal._replace(phase="over", spent=0), goal.spent == system.work[1]
    if goal.request == "learning":
        yield goal._replace(request="fetching", since=0), goal.since == latency
    if goal.request == "fetching":
        yield goal._replace(request="known", since=0), goal.since == latency
    if goal.phase == "over" and goal.request == "known":
        yield None, goal.spent == latency


def _older(goal: _Goal) -> _Goal:
    passes = goal.phase in ("way", "work") or (goal.phase == "over" and goal.request == "known")
    asks = goal.request in ("learning", "fetching")
    return goal._replace(spent=goal.spent + passes, since=goal.since + asks)


def _put(among: tuple[_Goal, ...], one: _Goal) -> tuple[_Goal, ...]:
    return tuple(sorted((*among, one)))
