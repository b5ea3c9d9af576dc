"""Bounds of one lane: how long a task can wait there, with what can be released.

**Any order.** Let an instance x of a task c be released at r, and begin at b. Let t be the last moment up to
r at which no instance that takes time and was released before t waits or runs in the lane; x is the q-th
instance of c that is released from t on. From t to b the lane always works, as an executor is never idle
while something is ready, and all that it works on was released from t on. If b came after t + S, the lane
would have worked for more than S on what was released in [t, t + S]: on the other tasks, and on the q - 1
instances of c before x, since a history is first in, first out. So b is at most t + S, for the least S with

    sum over other tasks j of  within_j(S) * C_j  +  (q - 1) * C_c  <=  S,

and r is at least t + span_c(q). The response time of x is at most S + C_c - span_c(q). If all work that is
released before t + L can be done by t + L, then t + L would be such a moment, so r is before t + L: only the
q up to before_c(L) matter. If all curves are periodic and the lane is not overloaded, the bound of q
repeats after their least common multiple H; then the q up to before_c(H) are enough. This is the busy period
of Lehoczky (1990), for tasks that do not preempt one another and run in any order, with event models as in
Casini et al. (2019). Work that takes no time is left out: an executor does it in no time.

If each release of c follows one of a series of moments with the period T, the first of the q comes not later
than the latest moment for it, and x is due q - 1 periods later. So x ends within S + C_c - (q - 1) * T after
the latest moment at which it can be released: in a chain, the spread of releases counts once. (Of releases
that overtake one another, the n-th counts as that of the n-th moment.)

**Full histories.** Whatever is released, no more waits than the histories hold, and a tick of each timer. So
from r on, the lane works at most on the run that is under way, on what waited at r, and on what is released
of the other tasks until x begins. This bounds x even if its own messages come too often to be taken. Clients
that wait hold as many requests as they have outstanding; the one that a server works on is among them.

**Wait results.** An executor with a wait result takes each callback that was ready once, before it looks
again (Tang et al. 2020, Blass et al. 2021). So the rest of the result in which x arrives takes at most the
sum W of all C, and so does each later one. If at most n messages wait in the history of c, x among them, x
is in the n-th later result at the latest. Its callback begins at most n * W + (W - C_c) after its release; a
timer's callback, of which one tick waits, after W + the work of the other timers, which go before messages.

**Several threads.** A callback that could run waits for a thread only while all m threads work on other
lanes. The runs that they work on in a window of length S were released at most their response time before it.
So this takes at most ``sum within_j(S + R_j) * C_j / m`` of the window, for j in other lanes; it takes
nothing if less than m runs of other lanes can overlap at all. A lane of which nothing is known may always
have a thread. A reentrant callback waits for nothing else.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import astuple, dataclass
from fractions import Fraction
from functools import reduce

from dineros.analysis.bounds.curves import Curve
from dineros.analysis.bounds.tasks import Lane, Task
from dineros.metamodel import sym
from dineros.metamodel.callbacks.groups import threads_of

MOST_STEPS = 20_000
"""Steps of an iteration towards a bound."""
MOST_INSTANCES = 5_000
"""Limit of the instances of a task that are examined, one by one."""


@dataclass(frozen=True)
class Waited:
    """Bounds of a task, in units of time."""

    start: int
    """From its release to its beginning."""
    response: int
    """To its end."""
    longest: int
    """How many of its messages wait at once, however deep its history is."""
    delay: int
    """From the latest moment at which its release can come, by its curve, to its end."""

    def least(self, other: Waited) -> Waited:
        """Return the smaller one of each pair of bounds."""
        return Waited(*map(min, zip(astuple(self), astuple(other), strict=True)))


@dataclass(frozen=True)
class Around:
    """The facts known so far about all tasks."""

    curves: Mapping[Task, Curve | None]
    """Releases; None if nothing bounds them."""
    responses: Mapping[Task, int | None]
    """Response times; None if nothing bounds them."""
    nodes: Mapping[sym.NodeNet, list[Lane]]

    def curve(self, task: Task) -> Curve:
        """Return the curve of a task that has one."""
        found = self.curves[task]
        assert found is not None
        return found


def waited(task: Task, around: Around) -> Waited | None:
    """Return bounds of a task; None if there are none."""
    lane = task.lane
    found: list[Waited | None] = []
    if lane.reason or any(each.work is None for each in lane.tasks):
        return None
    curve = around.curves[task]
    if curve is not None and not curve.terms:
        return _waited(task, 0, 0)
    if lane.keeps_order:
        found.append(_in_turn(task, around))
    if (shared := _shared(task, around)) is not None:
        others = [each for each in lane.tasks if each is not task and each.most]
        if not lane.is_exclusive:
            found.append(_reentrant(task, around, shared))
        elif all(around.curves[each] is not None for each in others):
            with_curves = [(around.curve(each), each) for each in others]
            if sum((each.rate * other.most for each, other in with_curves), shared.load) < 1:
                found.append(_with_full_histories(task, around, with_curves, shared))
                found.append(_in_any_order(task, around, with_curves, shared))
    known = [each for each in found if each is not None]
    if not known:
        return None
    return reduce(Waited.least, known)


def _waited(task: Task, start: int, longest: int) -> Waited:
    return Waited(start, start + task.most, longest, start + task.most)


def _in_turn(task: Task, around: Around) -> Waited:
    """Return bounds by wait results."""
    tasks = task.lane.tasks
    whole = sum(each.most for each in tasks)
    if task.is_timer:
        timers = sum(each.most for each in tasks if each.is_timer)
        return _waited(task, whole + timers - task.most, 1)
    depth = task.held
    assert depth is not None, "a node that keeps an order has no servers"
    start = depth * whole + whole - task.most
    curve = around.curves[task]
    longest = depth + 1
    while curve is not None and (waiting := max(1, curve.within(start))) < longest:
        # The number that waits is too small for a displacement; then x is in an earlier wait result.
        longest = waiting
        start = min(longest, depth) * whole + whole - task.most
    return _waited(task, start, longest)


@dataclass(frozen=True)
class _Shared:
    """How long a lane can wait for a thread in a window, and which part of a long one; 0: never."""

    within: Callable[[int], int]
    load: Fraction


_ALONE = _Shared(lambda window: 0, Fraction(0))


def are_alone(lanes: list[Lane]) -> bool:
    """Return whether the lanes of a node need not share threads: there is one for each."""
    threads = threads_of(lanes[0].node)
    return threads == 1 or (len(lanes) <= threads and all(each.is_exclusive for each in lanes))


def _shared(task: Task, around: Around) -> _Shared | None:
    """Return how long a lane waits for a thread in a window; None if nothing bounds it."""
    lanes, threads = around.nodes[task.lane.node], threads_of(task.lane.node)
    if are_alone(lanes):
        return _ALONE
    others: list[tuple[Curve, int, int, int]] = []
    at_once = 0
    is_known = True
    for lane in lanes:
        if lane is task.lane and lane.is_exclusive:
            continue
        is_open = any(each.work is None for each in lane.tasks)
        if is_open and lane.most_at_once is None:
            return None
        taking = [each for each in lane.tasks if each.most]
        if is_open:
            at_once += lane.most_at_once or 0
        elif lane.is_exclusive:
            at_once += bool(taking)
        for each in taking:
            response, curve = around.responses[each], around.curves[each]
            if response is None or curve is None:
                is_open = True
                if lane.is_exclusive:
                    continue
                return None
            itself = int(each is task)
            others.append((curve, response, each.most, itself))
            if not lane.is_exclusive:
                at_once += max(0, curve.within(response) - itself)
        is_known = is_known and not is_open
    if at_once < threads:
        return _ALONE
    if not is_known:
        return None

    def taken(window: int) -> int:
        work = sum(
            (curve.within(window + response) - itself) * most for curve, response, most, itself in others
        )
        return -(-work // threads)

    load = sum((curve.rate * most for curve, _, most, _ in others), Fraction(0)) / threads
    return _Shared(taken, load)


def least_window(need: Callable[[int], int], start: int = 0) -> int | None:
    """Return the least window that has what it needs, from a lower bound on; None if it is too far."""
    window = start
    for _ in range(MOST_STEPS):
        needed = need(window)
        if needed <= window:
            return window
        window = needed
    return None


def _reentrant(task: Task, around: Around, shared: _Shared) -> Waited | None:
    start = least_window(shared.within) if shared.load < 1 else None
    curve, held = around.curves[task], task.held
    if start is None or (curve is None and held is None):
        return None
    return _waited(task, start, (held or 0) + 1 if curve is None else curve.within(start))


_Others = list[tuple[Curve, Task]]


def _with_full_histories(task: Task, around: Around, others: _Others, shared: _Shared) -> Waited | None:
    """Return bounds that hold however often the task is released."""
    running = max((each.most for each in task.lane.tasks if not each.is_held), default=0)
    held = task.held
    held_by_others = [other.held * other.most for _, other in others if other.held is not None]
    if held is None or len(held_by_others) < len(others):
        return None
    waiting = (held - 1) * task.most + sum(held_by_others)

    def need(window: int) -> int:
        released = sum(curve.within(window) * other.most for curve, other in others)
        return running + waiting + released + shared.within(window)

    start = least_window(need)
    if start is None:
        return None
    curve = around.curves[task]
    return _waited(task, start, held + 1 if curve is None else curve.within(start))


def _in_any_order(task: Task, around: Around, others: _Others, shared: _Shared) -> Waited | None:
    """Return bounds by the instances of a busy period."""
    curve = around.curves[task]
    most = None if curve is None else _instances(task, curve, others, shared)
    if curve is None or most is None:
        return None

    def start_of(number: int, least: int) -> int | None:
        own = (number - 1) * task.most

        def need(window: int) -> int:
            released = sum(each.within(window) * other.most for each, other in others)
            return own + released + shared.within(window)

        return least_window(need, least)

    period = curve.one_period
    window = start = longest = delay = 0
    for number in range(1, most + 1):
        found = start_of(number, window)
        if found is None:
            return None
        window = found
        start = max(start, window - curve.span(number))
        longest = max(longest, curve.within(window) - number + 1)
        delay = max(delay, window - (curve.span(number) if period is None else (number - 1) * period))
    return Waited(start, start + task.most, longest, delay + task.most)


def _instances(task: Task, curve: Curve, others: _Others, shared: _Shared) -> int | None:
    """Return how many instances of a task must be examined; None if nothing bounds them."""
    if not task.most:
        return 1
    tasks = [(curve, task), *others]
    load = sum((each.rate * other.most for each, other in tasks), shared.load)
    if load > 1:
        return None
    found = []
    if load < 1:
        busy = least_window(
            lambda window: (
                sum(each.before(window) * other.most for each, other in tasks) + shared.within(window)
            ),
            max(1, sum(each.within(0) * other.most for each, other in tasks)),
        )
        if busy is not None:
            found.append(curve.before(busy))
    if shared is _ALONE:
        found.append(curve.before(math.lcm(*(period for each, _ in tasks for _, period, _ in each.terms))))
    return min(found) if found and min(found) <= MOST_INSTANCES else None
