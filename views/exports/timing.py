"""Times of the steps of a trace in nanoseconds, and its calls of services and goals of actions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from dineros.views.traces.building import TraceBuilder
from dineros.views.traces.lanes import Lane
from dineros.views.traces.steps import Step

FIRING = 1_000_000
"""Nanoseconds of one firing if a trace has no times."""


def times_of(builder: TraceBuilder) -> list[int]:
    """Return the time of each step: non-decreasing, since the epoch if it is known."""
    times: list[int] = []
    for number, step in enumerate(builder.steps):
        time = number * FIRING if step.time is None else round(step.time * 1e9)
        times.append(max(time, times[-1]) if times else time)
    return times


def marks_of(builder: TraceBuilder) -> Iterator[tuple[int, Step, Lane, str, list[int]]]:
    """Yield every mark: index of the step, step, lane, letter, and the values."""
    for index, step in enumerate(builder.steps):
        for lane, letter, *values in step.marks:
            yield index, step, builder.lanes.all[lane], letter, values


@dataclass
class Call:
    """A client's call of a service, or a goal, by indices of steps; None: the step did not happen.

    Those of one client that overlap have different levels, from 0.
    """

    lane: Lane
    request: int | None = None
    serve: int | None = None
    reply: int | None = None
    response: int | None = None
    given_up: int | None = None
    instance: int | None = None
    end: int | None = None
    level: int = 0

    @property
    def over(self) -> int | None:
        """The end of its client's wait."""
        return self.given_up if self.response is None else self.response

    @property
    def is_goal(self) -> bool:
        """Whether it is a goal of an action."""
        return self.lane.group == "actions"


def calls_of(builder: TraceBuilder) -> list[Call]:
    """Return the calls of all services, and all goals, in the order they begin."""
    calls: dict[tuple[int, int], Call] = {}
    names = {"q": "request", "s": "serve", "r": "reply", "a": "response", "g": "given_up"}
    for index, _, lane, letter, values in marks_of(builder):
        if lane.kind != "client" or letter not in names:
            continue
        call = calls.setdefault((lane.index, values[0]), Call(lane))
        setattr(call, names[letter], index)
        if letter == "s":
            call.instance = values[1]
        elif letter == "a" and len(values) > 1:
            call.end = values[1]
    found = list(calls.values())
    _set_levels(found)
    return found


def _set_levels(calls: Iterable[Call]) -> None:
    """Assign different levels to overlapping calls of one client."""
    over: dict[int, list[int | None]] = {}  # of each lane and level: when its last call was over
    for call in calls:
        begin = call.request if call.request is not None else call.serve or 0
        levels = over.setdefault(call.lane.index, [])
        free = (level for level, end in enumerate(levels) if end is not None and end <= begin)
        call.level = next(free, len(levels))
        levels[call.level : call.level + 1] = [call.over]
