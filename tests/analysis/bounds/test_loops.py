"""Bounds of callbacks that repeat a step with an interval, and of callbacks that ends of goals call."""

from __future__ import annotations

import os
from fractions import Fraction
from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.bounds.answers import Bounds
from dineros.analysis.bounds.losses import never_lost
from dineros.analysis.latencies.answers import Latencies
from dineros.analysis.timed.exploring import explore_timed
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, node_net, place, seconds, step
from dineros.metamodel.calls import UNLIMITED
from dineros.metamodel.elements import find
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.times.paces import Pace, paces
from dineros.metamodel.times.results import goals_ended

SEEDS = 60 * int(os.environ.get("DINEROS_EXAMPLES", "1"))
MOST_CLASSES = 20_000


def hears(model: sym.SystemModel, topic: sym.TopicChannel, depth: int, most: float) -> sym.CallbackPage:
    """Add a node that subscribes to a topic, and works for a time on each message."""
    node = node_net(model, f"node of {topic.topic}", execution="callbacks")
    page = callback(node, f"hear{topic.topic}")
    message = place(page, f"{page.id}.message")
    step(page, f"{page.id}.does", [message], [])
    page.duration = seconds(0, most)
    topic.subscribers.append(sym.SubscriberPort(place=message, limit=depth))
    return page


def topic_of(
    model: sym.SystemModel, name: str, out: pn.Place, latency: tuple[float, float]
) -> sym.TopicChannel:
    """Add a topic."""
    topic = sym.TopicChannel(id=name, topic=f"/{name}", model=model, latency=seconds(*latency))
    topic.publishers.append(sym.PublisherPort(place=out))
    return topic


def loops(
    page: sym.CallbackPage,
    start: list[pn.Place],
    end: list[pn.Place],
    out: pn.Place,
    every: tuple[float, float],
) -> sym.Transition:
    """Let a callback publish any number of times, each time after a while; return what publishes."""
    runs = place(page, f"{page.id}.runs")
    begins = step(page, f"{page.id}.begins", start, [runs])
    if page.kind == sym.CallbackKind.timer:
        begins.kind = sym.TransitionKind.start
    again = step(page, f"{page.id}.publishes", [runs], [runs, out])
    again.interval = seconds(*every)
    ends = step(page, f"{page.id}.ends", [runs], end)
    if page.kind != sym.CallbackKind.goal:
        ends.kind = sym.TransitionKind.end
    return again


def drawn(seed: int) -> sym.SystemModel:
    """Return a timer or a goal that loops, a client whose callback publishes how goals end, and readers."""
    random = Random(seed)
    model = sym.SystemModel(id="robot", middleware="ros2", times=sym.DefaultTimes(latency=seconds(0, 0)))
    threads = random.randint(1, 2)
    worker = node_net(model, "worker", execution="callbacks", threads=threads)
    least = random.randint(1, 3) / 100
    every = least, least + random.randint(0, 2) / 100
    latency = 0.0, random.choice([0, 1, 3]) / 100
    out = place(worker, "out")
    if random.random() < 0.4:
        page = callback(worker, "tick", "timer")
        page.timer, page.offset = random.randint(2, 6) / 100, seconds(0, 0)
        loops(page, [], [], out, every)
    else:
        page = callback(worker, "work", "goal")
        entry, done = place(page, "entry"), place(page, "done")
        if threads > 1:
            page.group = sym.CallbackGroup(id="free", name="free", kind="reentrant")
            worker.callbackGroups.append(page.group)
        loops(page, [entry], [done], out, every)
        node = node_net(model, "client", execution="callbacks")
        asks = callback(node, "asks", "timer")
        asks.timer, asks.offset, asks.duration = random.randint(2, 8) / 100, seconds(0, 0), seconds(0, 0)
        goal = place(node, "goal")
        goal.capacity = random.randint(1, 2)
        runs = place(asks, "asks.runs")
        step(asks, "asks.begins", [], [runs]).kind = sym.TransitionKind.start
        step(asks, "asks.sends", [runs], [goal]).kind = sym.TransitionKind.end
        step(asks, "asks.waits", [runs], []).kind = sym.TransitionKind.end
        over = callback(node, "over", "client")
        result, told = place(over, "over.result"), place(node, "told")
        step(over, "over.tells", [result], [told])
        over.duration = seconds(0, random.randint(0, 1) / 100)
        action = sym.ActionChannel(id="go", action="/go", model=model)
        action.server = sym.ActionServerPort(page=page, entry=entry, succeeded=done)
        client = sym.ActionClientPort(client="c", goal=goal, succeeded=result)
        client.outstanding = random.choice([1, 1, 2, None])
        action.clients.append(client)
        hears(model, topic_of(model, "told", told, latency), random.randint(1, 9), random.randint(0, 2) / 100)
    hears(model, topic_of(model, "out", out, latency), random.randint(1, 3), random.randint(0, 2) / 100)
    return model


def compared(seed: int) -> tuple[int, int]:
    """Return how many losses bounds exclude of a random model, and how many others there are.

    No excluded loss is among the firings of the state classes.
    """
    try:
        subject = timed_base_subject(drawn(seed))
    except DinerosError as error:
        assert "on their way at once" in str(error)
        return 0, 0
    found = explore_timed(subject.timed, Budget(states=MOST_CLASSES))
    names = subject.timed.untimed.transitions
    fired = {names[transition] for transition in found.ways}
    excluded = never_lost(subject)
    assert not excluded & fired
    return len(excluded), len(fired)


@pytest.mark.long
def test_nothing_is_lost_that_is_proved_not_to_be() -> None:
    excluded = sum(compared(seed)[0] > 0 for seed in range(SEEDS))
    assert excluded > SEEDS // 10


def test_the_pace_of_a_loop() -> None:
    """Each slot has a copy of the step; a step that may fire at once has no pace."""
    model = next(
        each
        for each in map(drawn, range(40))
        if any(page.id == "worker" for page in each.pages)
        and any(isinstance(each, sym.ActionChannel) for each in each.channels)
    )
    action = next(each for each in model.channels if isinstance(each, sym.ActionChannel))
    action.instances = 3
    page, out = action.server.page, find(model, "out", pn.Place)
    assert isinstance(page, sym.CallbackPage)
    again = find(model, "work.publishes", pn.Transition)
    again.interval = seconds(0.1, 0.2)
    (pace,) = paces(page, out) or ()
    assert pace == Pace(3, Fraction(1, 10))
    assert [pace.within(Fraction(window, 100)) for window in (0, 9, 10)] == [3, 3, 6]
    again.interval = seconds(0, 0.2)
    assert paces(page, out) is None


def client_of(model: sym.SystemModel) -> sym.ActionClientPort:
    """Return the client of the only action."""
    (action,) = (each for each in model.channels if isinstance(each, sym.ActionChannel))
    (client,) = action.clients
    return client


@pytest.mark.parametrize("change", ["", "any number", "no capacity", "feedback", "managed"])
def test_when_the_ends_of_goals_are_bounded(change: str) -> None:
    model = next(
        each for each in map(drawn, range(40)) if any(isinstance(c, sym.ActionChannel) for c in each.channels)
    )
    client, over = client_of(model), find(model, "over", sym.CallbackPage)
    client.outstanding, client.goal.capacity = 2, 1
    match change:
        case "any number":
            client.outstanding = UNLIMITED
        case "no capacity":
            client.goal.capacity = None
        case "feedback":
            client.feedback = client.succeeded
            client.succeeded = None
        case "managed":
            find(model, "client", sym.NodeNet).lifecycle = sym.Lifecycle()
    ended = goals_ended(over)
    if change:
        assert ended is None
    else:
        assert ended is not None
        assert [(each.times, each.under_way) for each in ended] == [(1, 3)]


def test_goals_of_a_client_that_does_not_wait_can_take_all_threads() -> None:
    """The server accepts them all, so another callback waits for a thread; before, it had a bound without."""
    model = sym.SystemModel(id="robot", middleware="ros2")
    server = node_net(model, "server", execution="callbacks", threads=2)
    page = callback(server, "work", "goal", duration=seconds(0.03, 0.03))
    page.group = sym.CallbackGroup(id="free", name="free", kind="reentrant")
    server.callbackGroups.append(page.group)
    entry, done = place(page, "entry"), place(page, "done")
    step(page, "do", [entry], [done])
    tick = callback(server, "tick", "timer", 0.05, duration=seconds(0.01, 0.02), offset=seconds(0, 0))
    step(tick, "ticks")
    action = sym.ActionChannel(id="go", action="/go", latency=seconds(0, 0), model=model)
    action.server = sym.ActionServerPort(page=page, entry=entry, succeeded=done)
    sender = node_net(model, "sender", execution="callbacks")
    sends = callback(sender, "sends", "timer", 0.02, duration=seconds(0, 0), offset=seconds(0, 0))
    goal = place(sends, "goal")
    step(sends, "send", [], [goal])
    action.clients.append(sym.ActionClientPort(client="c", goal=goal))
    searched = Latencies(model, Budget(seconds=60)).everything().callbacks["tick"].greatest
    assert searched is not None and searched.value > Fraction(1, 50)
    assert Bounds(model).everything().callbacks["tick"].greatest is None
