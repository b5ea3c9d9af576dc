"""Latencies of actions and durations of goals: bounds that are counted by hand, and a plain program."""

from __future__ import annotations

from collections import deque
from random import Random
from typing import NamedTuple

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.bounded import read_bounded
from dineros.analysis.timed.durations.bounded_response import decide_bounded
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.metamodel import sym
from dineros.metamodel.build import callback, flow, node_net, place, seconds, step
from dineros.metamodel.constraints import validate
from tests.transformations.rules.test_times import explored

pytestmark = pytest.mark.usefixtures("own_time")

Span = tuple[int, int]


class Drive(NamedTuple):
    """A timer sends goals to a server with some slots."""

    period: int
    latency: Span
    work: Span
    slots: int = 1


def driving(
    drive: Drive, server: str = "callbacks", client: str = "callbacks", cancels: bool = False
) -> sym.SystemModel:
    """Return the model; engines take up to 1 to react."""
    model = sym.SystemModel(id="driving", middleware="ros2")
    driver = node_net(model, "driver", execution=server)
    page = callback(driver, "Drive", "goal")
    target, there = place(page, "Target"), place(page, "There")
    arrive = step(page, "Arrive", [target], [there])
    if server == "callbacks":
        driver.executor, driver.threads = "multi", drive.slots + 1
        page.duration = seconds(*drive.work)
    else:
        driver.reaction = seconds(0, 1)
    sender = node_net(model, "sender", execution=client)
    done, goal = place(sender, "Done"), place(sender, "Goal")
    if client == "callbacks":
        tick = callback(sender, "OnTick", "timer", drive.period)
        tick.offset = tick.duration = seconds(0, 0)
        goal = place(tick, "GoalOfTick")
        step(tick, "Go", [], [goal])
        over = callback(sender, "OnResult", "client")
        over.duration = seconds(0, 0)
        done = place(over, "DoneOfResult")
        step(over, "Note", [done])
    else:
        sender.reaction = seconds(0, 1)
        step(sender, "Go", [place(sender, "Wishes", 2)], [goal])
        step(sender, "Note", [done])
    action = sym.ActionChannel(
        id="Act",
        action="/drive",
        instances=drive.slots,
        latency=seconds(*drive.latency),
        server=sym.ActionServerPort(page=page, entry=target, succeeded=there),
        clients=[sym.ActionClientPort(client="sender", goal=goal, succeeded=done)],
        model=model,
    )
    if cancels:
        action.server.cancel, action.server.canceled = place(page, "Stop"), place(page, "Stopped")
        flow(target, brake := step(page, "Brake", [action.server.cancel]), action.server.canceled)
        brake.interval, arrive.interval, page.duration = seconds(0, 0), seconds(*drive.work), None
        port = action.clients[0]
        port.cancel, port.canceled = place(sender, "Recall"), done
        step(sender, "Stop!", [place(sender, "Alarm", 1)], [port.cancel]).interval = seconds(0, None)
    assert [str(each) for each in validate(model) if each.severity == "error"] == []
    return model


def comes_within(model: sym.SystemModel, first: str, last: str, bound: int) -> bool:
    net = timed_base_subject(model).timed
    formula = read_bounded(f'G (fired("{first}") -> F[<={bound}] (fired("{last}")))')
    assert formula is not None
    answer = decide_bounded(net, formula, budget=Budget(seconds=120))
    assert answer.status in ("holds", "violated"), answer.reason
    return answer.status == "holds"


SEND, RESULT, ANY, ACCEPT = (
    f"Act.client.sender.{each}" for each in ("send", "result.There", "result.There.any", "accept[1]")
)


@pytest.mark.parametrize(
    ("latency", "work"), [((0, 1), (3, 5)), ((0, 0), (4, 4)), ((2, 3), (0, 6)), ((0, 2), (1, 1))]
)
def test_a_result_comes_after_two_latencies_and_the_work(latency: Span, work: Span) -> None:
    """The client asks for the result once it knows of the acceptance, so four latencies are needed."""
    model = driving(Drive(30, latency, work))
    most = 2 * latency[1] + max(work[1], 2 * latency[1])
    results = f'{RESULT}") | fired("{ANY}'
    assert comes_within(model, SEND, results, most)
    assert not comes_within(model, SEND, results, most - 1)


def test_a_result_comes_not_before_the_least_work() -> None:
    model = driving(Drive(30, (0, 1), (3, 5)))
    net = timed_base_subject(model).timed
    early, late = (
        read_bounded(f'G (fired("{ACCEPT}") -> G[<={bound}] !(fired("{RESULT}") | fired("{ANY}")))')
        for bound in (2, 3)
    )
    assert early is not None and late is not None
    assert decide_bounded(net, early).status == "holds"
    assert decide_bounded(net, late).status == "violated"


def test_engines_take_goals_and_results_within_latency_and_reaction() -> None:
    """Each of four messages takes 2 + 1: the goal, the acceptance, the request for the result, the result.

    The server arrives within 1 meanwhile.
    """
    model = driving(Drive(30, (0, 2), (0, 0)), "net", "net")
    assert comes_within(model, SEND, RESULT, 12)
    assert not comes_within(model, SEND, RESULT, 11)


def test_a_goal_that_is_recalled_is_over_soon() -> None:
    """The server hears of it within 2 and stops at once; the client takes the result within 2 + 1.

    A goal that is not recalled takes 40. A recall that comes too late begins the time of the result again.
    """
    model = driving(Drive(100, (0, 2), (40, 40)), "callbacks", "net", cancels=True)
    stopped = "Act.client.sender.result.Stopped"
    ask = "Act.client.sender.cancel[1]"
    net = timed_base_subject(model).timed
    for bound, expected in ((2, "holds"), (1, "violated")):
        ends = ("Act.client.sender.over.There", "Act.client.sender.over.Stopped")
        over = " | ".join(f'("{place}" >= 1)' for place in ends)
        formula = read_bounded(f'G (fired("{ask}") -> X F[<={bound}] ({over}))')
        assert formula is not None
        assert decide_bounded(net, formula, budget=Budget(seconds=120)).status == expected
    assert comes_within(model, ACCEPT, f'{RESULT}") | fired("{stopped}', 46)


class State(NamedTuple):
    """Ages of goals on their way, of work, of results on their way; goals that wait; the clock."""

    goals: tuple[int, ...]
    waiting: int
    works: tuple[int, ...]
    results: tuple[int, ...]
    clock: int


def facts_of(drive: Drive) -> tuple[int, int, int]:
    """Return the most goals that are sent and not accepted, slots that work, and results on their way."""
    low, high = drive.latency
    first = State((), 0, (), (), drive.period)
    seen, todo, most = {first}, deque([first]), (0, 0, 0)
    while todo:
        one = todo.popleft()
        now = len(one.goals) + one.waiting, len(one.works), len(one.results)
        most = max(most[0], now[0]), max(most[1], now[1]), max(most[2], now[2])
        after = []
        if one.clock == drive.period:
            after.append(one._replace(goals=(*one.goals, 0), clock=0))
        if one.goals and one.goals[0] >= low:
            after.append(one._replace(goals=one.goals[1:], waiting=one.waiting + 1))
        if one.waiting and len(one.works) < drive.slots:
            after.append(one._replace(waiting=one.waiting - 1, works=(*one.works, 0)))
        for age in {age for age in one.works if age >= drive.work[0]}:
            left = list(one.works)
            left.remove(age)
            after.append(one._replace(works=tuple(left), results=(*one.results, 0)))
        if one.results and one.results[0] >= low:
            after.append(one._replace(results=one.results[1:]))
        must = (
            one.clock == drive.period
            or (bool(one.goals) and one.goals[0] >= high)
            or (one.waiting > 0 and len(one.works) < drive.slots)
            or any(age >= drive.work[1] for age in one.works)
            or (bool(one.results) and one.results[0] >= high)
        )
        if not must:
            after.append(
                State(
                    *(tuple(age + 1 for age in one.goals), one.waiting),
                    tuple(sorted((age + 1 for age in one.works), reverse=True)),
                    tuple(age + 1 for age in one.results),
                    one.clock + 1,
                )
            )
        for each in after:
            if each not in seen:
                seen.add(each)
                todo.append(each)
    return most


def facts_of_net(drive: Drive) -> tuple[int, int, int]:
    found = explored(driving(drive))
    places, top = found.net.untimed.places, found.markings.max(axis=0).tolist()
    goals, results = (
        top[places.index(f"Act.client.sender.{name}")] if f"Act.client.sender.{name}" in places else 0
        for name in ("requested", "results.Load")
    )
    slots = [number for number, name in enumerate(places) if name.endswith(".executing")]
    return int(goals), int(found.markings[:, slots].sum(axis=1).max()), int(results)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(24))
def test_the_net_can_do_all_that_a_plain_program_does(seed: int) -> None:
    """And no more, while one goal is under way at a time.

    In the program, a server knows at once that the result is asked for. In the net, goals with latencies that
    follow each other more quickly have results at any time, so too many markings are possible.
    """
    draw = Random(seed)
    least = draw.randint(0, 2)
    latency = (least, least + draw.randint(0, 2))
    shortest = draw.randint(0, 5)
    work = (shortest, shortest + draw.randint(0, 3))
    slots = draw.randint(1, 2)
    total = 2 * latency[1] + max(work[1], 2 * latency[1])
    period = draw.choice([total + 1, max(1, work[1] // slots + 1)] if latency[1] == 0 else [total + 1])
    drive = Drive(period, latency, work, slots)
    plain, net = facts_of(drive), facts_of_net(drive)
    assert all(ours >= theirs for ours, theirs in zip(net, plain, strict=True)), (drive, plain, net)
    if period > total:
        assert net == plain == (1, 1, 1)
