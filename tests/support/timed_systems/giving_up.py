"""A plain program that explores a timer which calls a service with a time-out, in whole units of time.

It knows no Petri nets and no rules. The server takes requests in the order in which they arrive, and answers
each, also those whose caller has given up. The caller waits for its response until its time-out is over,
and then goes on at once. If both come at the same moment, either may be first.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

Span = tuple[int, int]


class Calling(NamedTuple):
    """A system: a timer asks, a server answers, and another timer shares the thread of the server.

    Attributes
    ----------
    period, timeout : int
        Of the caller.
    before, after : tuple of int
        How long it works before its call, and after it.
    latency : tuple of int
        Of each request and each response.
    serves : tuple of int
        How long the server works.
    beside : tuple of int or None
        Period and duration of the other timer of the server's thread; None if there is none.
    """

    period: int
    timeout: int
    before: Span
    after: Span
    latency: Span
    serves: Span
    beside: tuple[int, int] | None = None


class Seen(NamedTuple):
    """What can happen: response times, whether a call ends each way, requests that wait, lost ticks."""

    asks: set[int]
    server: set[int]
    ways: set[str]
    longest: set[int]
    lost: set[str]


class _State(NamedTuple):
    strike: int
    due: int = -1
    """Age of a tick that waits, or -1."""
    stage: str = ""
    """What the caller does: nothing, before, waits, after."""
    age: int = 0
    """Since the release of its run."""
    worked: int = 0
    """Since the stage began."""
    call: int = 0
    """Number of its call, modulo many: responses to others are dropped."""
    requests: tuple[tuple[int, int], ...] = ()
    """Calls on their way, and how long they are."""
    queue: tuple[tuple[int, int], ...] = ()
    serving: tuple[int, int, int] | None = None
    """Call, age since its arrival, work done."""
    answers: tuple[tuple[int, int], ...] = ()
    other: int = 0
    other_due: bool = False
    other_works: int = -1


DEPTH = 10
_CALLS = 64


def explored(system: Calling, most: int = 60_000) -> Seen | None:
    """Return what can happen; None if there are more than `most` states."""
    seen = Seen(set(), set(), set(), {0}, set())
    first = _State(0)
    todo, known = [first], {first}
    while todo:
        for after in _after(system, todo.pop(), seen):
            named = _renumbered(after)
            if named not in known:
                known.add(named)
                todo.append(named)
        if len(known) > most:
            return None
    return seen


def _renumbered(state: _State) -> _State:
    """Renumber calls by their order, so that equal states compare equal."""
    there = sorted(
        {each for each, _ in (*state.requests, *state.queue, *state.answers)}
        | ({state.serving[0]} if state.serving else set())
        | {state.call}
    )
    new = {old: number for number, old in enumerate(there)}
    return state._replace(
        call=new[state.call],
        requests=tuple((new[each], age) for each, age in state.requests),
        queue=tuple((new[each], age) for each, age in state.queue),
        answers=tuple((new[each], age) for each, age in state.answers),
        serving=None if state.serving is None else (new[state.serving[0]], *state.serving[1:]),
    )


def _after(system: Calling, state: _State, seen: Seen) -> Iterator[_State]:
    must = False
    if state.strike == 0:
        must = True
        if state.due >= 0:
            seen.lost.add("asks")
        yield state._replace(strike=system.period, due=max(state.due, 0))
    if system.beside is not None and state.other == 0:
        must = True
        if state.other_due:
            seen.lost.add("beside")
        yield state._replace(other=system.beside[0], other_due=True)
    if state.due >= 0 and not state.stage:
        must = True
        yield state._replace(due=-1, stage="before", age=state.due, worked=0)
    if state.stage == "before" and state.worked >= system.before[0]:
        must = must or state.worked == system.before[1]
        call = state.call + 1
        sent = (*state.requests, (call, 0))
        yield state._replace(stage="waits", worked=0, call=call, requests=sent)
    if state.stage == "waits" and state.worked == system.timeout:
        must = True
        seen.ways.add("late")
        yield state._replace(stage="after", worked=0, call=state.call + 1)
    if state.stage == "after" and state.worked >= system.after[0]:
        must = must or state.worked == system.after[1]
        seen.asks.add(state.age)
        yield state._replace(stage="", age=0, worked=0)
    least, greatest = system.latency
    if state.requests and state.requests[0][1] >= least:
        must = must or state.requests[0][1] == greatest
        queue = (*state.queue, (state.requests[0][0], 0))
        if len(queue) > DEPTH:
            seen.lost.add("requests")
        seen.longest.add(min(len(queue), DEPTH))
        yield state._replace(requests=state.requests[1:], queue=queue[-DEPTH:])
    if state.answers and state.answers[0][1] >= least:
        must = must or state.answers[0][1] == greatest
        left = state._replace(answers=state.answers[1:])
        if state.stage == "waits" and state.answers[0][0] == state.call:
            seen.ways.add("ok")
            left = left._replace(stage="after", worked=0, call=state.call + 1)
        yield left
    if state.serving is None and state.other_works < 0:
        if state.queue:
            must = True
            yield state._replace(queue=state.queue[1:], serving=(*state.queue[0], 0))
        if state.other_due:
            must = True
            yield state._replace(other_due=False, other_works=0)
    if state.serving is not None and state.serving[2] >= system.serves[0]:
        must = must or state.serving[2] == system.serves[1]
        seen.server.add(state.serving[1])
        yield state._replace(serving=None, answers=(*state.answers, (state.serving[0], 0)))
    if system.beside is not None and state.other_works == system.beside[1]:
        must = True
        yield state._replace(other_works=-1)
    if not must:
        yield _later(state)


def _later(state: _State) -> _State:
    serving = state.serving
    return state._replace(
        strike=state.strike - 1,
        due=state.due + (state.due >= 0),
        age=state.age + bool(state.stage),
        worked=state.worked + bool(state.stage),
        requests=tuple((call, age + 1) for call, age in state.requests),
        queue=tuple((call, age + 1) for call, age in state.queue),
        serving=None if serving is None else (serving[0], serving[1] + 1, serving[2] + 1),
        answers=tuple((call, age + 1) for call, age in state.answers),
        other=max(state.other - 1, 0),
        other_works=state.other_works + (state.other_works >= 0),
    )
