"""Runs of a callback share the clock of a transition: its interval stays where that excludes nothing."""

from __future__ import annotations

from itertools import product

import pytest

from dineros.analysis.timed_checks.timed_check import check_timed
from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, flow, node_net, place, seconds, step
from dineros.metamodel.elements import find
from dineros.metamodel.times.shared import holds_for_all_runs, latest_holds_for_all_runs

NEVER = "reader history of Data (topic /data) never overflows"


def reading(period: int, work: int, threads: int, depth: int) -> sym.SystemModel:
    """A reentrant callback takes a message that comes each period, works in [0, work], and then ends."""
    model = sym.SystemModel(id="reading", middleware="ros2")
    source = callback(node_net(model, "source", execution="callbacks"), "OnSend", "timer")
    source.timer, source.offset, source.duration = float(period), seconds(0, 0), seconds(0, 0)
    sent = place(source, "Sent")
    step(source, "Send", [], [sent])
    node = node_net(model, "reader", execution="callbacks", threads=threads)
    page = callback(node, "OnData")
    page.group = sym.CallbackGroup(id="both", kind="reentrant")
    node.callbackGroups.append(page.group)
    data, works, rests = place(page, "Data"), place(page, "Works"), place(page, "Rests")
    step(page, "Begin", [data], [works]).interval = seconds(0, 0)
    step(page, "Work", [works], [rests]).interval = seconds(0, work)
    step(page, "End", [rests]).interval = seconds(0, 0)
    sym.TopicChannel(
        id="Topic",
        topic="/data",
        publishers=[sym.PublisherPort(place=sent, limit=1)],
        subscribers=[sym.SubscriberPort(place=data, limit=depth)],
        latency=seconds(0, 0),
        model=model,
    )
    return model


def overflows(period: int, work: int, threads: int, depth: int) -> bool:
    """Explore it in whole units of time, with a clock for each run."""
    # Time since the last message, waiting messages, ages of runs.
    start: tuple[int, int, tuple[int, ...]] = (0, 0, (0,))
    seen, left = {start}, [start]
    while left:
        since, waiting, ages = left.pop()
        after: list[tuple[int, int, tuple[int, ...]]] = []
        for number in range(len(ages)):
            others = ages[:number] + ages[number + 1 :]
            after.append((since, waiting - 1, (*others, 0)) if waiting else (since, 0, others))
        if since == period:
            if len(ages) < threads:
                after.append((0, waiting, (*ages, 0)))
            elif waiting == depth:
                return True
            else:
                after.append((0, waiting + 1, ages))
        elif all(age < work for age in ages):
            after.append((since + 1, waiting, tuple(age + 1 for age in ages)))
        for since, waiting, ages in after:
            state = since, waiting, tuple(sorted(ages))
            if state not in seen:
                seen.add(state)
                left.append(state)
    return False


@pytest.mark.parametrize("threads", [2, 3])
def test_no_history_is_proved_that_overflows_with_a_clock_for_each_run(threads: int) -> None:
    proved = 0
    for period, work, depth in product((1, 2, 3), (0, 1, 3), (1, 2)):
        report = check_timed(reading(period, work, threads, depth))
        if NEVER in report.proved:
            proved += 1
            assert not overflows(period, work, threads, depth), (period, work, depth)
    assert proved >= 8


def interval_holds(model: sym.SystemModel, name: str) -> bool:
    return holds_for_all_runs(find(model, name, pn.Transition))


def test_where_one_clock_is_enough() -> None:
    model = reading(2, 1, 2, 1)
    assert interval_holds(model, "Work") and interval_holds(model, "End")
    work = find(model, "Work", pn.Transition)
    work.interval = seconds(1, 1)
    assert not interval_holds(model, "Work") and latest_holds_for_all_runs(work)


def test_a_run_that_another_step_ends_leaves_its_clock_to_others() -> None:
    """Only what fires at once needs no clock."""
    model = reading(2, 1, 2, 1)
    page = find(model, "OnData", sym.CallbackPage)
    step(page, "GiveUp", [find(model, "Works", pn.Place)])
    assert not interval_holds(model, "Work")
    find(model, "Work", pn.Transition).interval = seconds(0, 0)
    assert interval_holds(model, "Work")


def test_tokens_of_two_runs_can_be_joined() -> None:
    model = reading(2, 1, 2, 1)
    page = find(model, "OnData", sym.CallbackPage)
    other = place(page, "Other")
    flow(find(model, "Begin", pn.Transition), other)
    flow(other, find(model, "End", pn.Transition))
    assert not interval_holds(model, "End")


def test_a_response_is_joined_with_a_token_of_another_run() -> None:
    """What the middleware puts on a place belongs to one run, too."""
    model = reading(2, 1, 2, 1)
    page = find(model, "OnData", sym.CallbackPage)
    asked, answered = place(page, "Asked"), place(page, "Answered")
    work, end = find(model, "Work", pn.Transition), find(model, "End", pn.Transition)
    flow(work, asked)
    look = callback(node_net(model, "eye", execution="callbacks"), "Look", "server")
    entry, exit_ = place(look, "In"), place(look, "Out")
    step(look, "See", [entry], [exit_])
    sym.ServiceChannel(
        id="look",
        service="/look",
        server=sym.ServerPort(page=look, entry=entry, exit=exit_),
        clients=[sym.ClientPort(client="reader", request=asked, response=answered)],
        model=model,
    )
    assert interval_holds(model, "Work"), "a callback that calls a service"
    flow(answered, end)
    assert not interval_holds(model, "End")
