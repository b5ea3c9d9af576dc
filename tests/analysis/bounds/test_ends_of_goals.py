"""How often ends of goals call a callback, against all firing sequences of the net without times.

The rule (`dineros.metamodel.times.results`) says: from any moment on, a callback is called at most as often
as goals are sent from then on, and as goals are under way or wait to be sent, each a certain number of times.
So no path through the reachability graph is longer than that, if each call counts one and each goal that is
sent counts minus its number of calls. The longest paths are computed for each marking.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from random import Random
from typing import NamedTuple

import numpy as np
import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.bounds.losses import never_lost
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.models import compile_net
from dineros.analysis.timed.exploring import explore_timed
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, node_net, place, seconds, step
from dineros.metamodel.callbacks.groups import callback_page_of
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import channels, find
from dineros.metamodel.times.rates import on_the_way
from dineros.metamodel.times.results import goals_ended
from dineros.transformations.flattening.flatten import flatten

SEEDS = 40 * int(os.environ.get("DINEROS_EXAMPLES", "1"))
MOST_MARKINGS = 1_000
ENDS = ("succeeded", "aborted", "rejected")


def drawn(seed: int) -> sym.SystemModel:
    """Return one or two clients of an action, whose answers call up to two callbacks of their node."""
    random = Random(seed)
    model = sym.SystemModel(id="robot", middleware="ros2")
    slots = random.randint(1, 2)
    worker = node_net(model, "worker", execution="callbacks", threads=random.randint(1, 2))
    work = callback(worker, "work", "goal")
    entry, done, failed = (place(work, name) for name in ("entry", "done", "failed"))
    step(work, "does", [entry], [done])
    action = sym.ActionChannel(id="go", action="/go", instances=slots, model=model)
    action.server = sym.ActionServerPort(page=work, entry=entry, succeeded=done)
    if random.random() < 0.4:
        step(work, "fails", [entry], [failed])
        action.server.aborted = failed
    action.server.mayReject = random.random() < 0.4
    node = node_net(model, "client", execution="callbacks", threads=random.randint(1, 2))
    pages = [callback(node, name, "client") for name in ("over", "other")]
    pages[1].group = sym.CallbackGroup(id="own", name="own", kind="exclusive")
    node.callbackGroups.append(pages[1].group)
    for page in pages:
        step(page, f"{page.id}.never", [place(page, f"{page.id}.empty")], [])
    for number in range(random.choice([1, 1, 2])):
        asks = callback(node, f"asks{number}", "timer", 1.0)
        goal = place(node, f"goal{number}")
        goal.capacity = random.randint(1, 2)
        runs = place(asks, f"asks{number}.runs")
        step(asks, f"asks{number}.begins", [], [runs]).kind = sym.TransitionKind.start
        step(asks, f"asks{number}.sends", [runs], [goal]).kind = sym.TransitionKind.end
        step(asks, f"asks{number}.waits", [runs], []).kind = sym.TransitionKind.end
        client = sym.ActionClientPort(client=f"c{number}", goal=goal)
        client.outstanding = random.choice([1, 1, 2])
        possible = {"aborted": action.server.aborted is not None, "rejected": action.server.mayReject}
        for name in ("accepted", *ENDS):
            if not possible.get(name, True):
                continue
            nowhere = [None] * (1 if name != "accepted" or client.outstanding == 1 else 5)
            called = random.choice([pages[0], pages[0], pages[1], *nowhere])
            if called is not None:
                told = place(called, f"{called.id}.{name}{number}")
                step(called, f"{told.id}.noted", [told], [])
                setattr(client, name, told)
        action.clients.append(client)
    assert [str(each) for each in validate(model) if each.severity == "error"] == []
    return model


def longest_path(net: CompiledNet, weights: Mapping[int, int]) -> float | None:
    """Return the greatest weight of firings in a row, from any marking; None: there are too many markings."""
    start = tuple(net.initial.tolist())
    numbers, todo = {start: 0}, [start]
    before, after, weight = [], [], []
    for marking in todo:
        for transition in range(len(net.transitions)):
            if net.is_enabled(transition, marking):
                successor = tuple(net.fire(transition, marking))
                if successor not in numbers:
                    numbers[successor] = len(numbers)
                    todo.append(successor)
                before.append(numbers[marking])
                after.append(numbers[successor])
                weight.append(weights.get(transition, 0))
        if len(numbers) > MOST_MARKINGS:
            return None
    found = np.zeros(len(numbers), int)
    for _ in range(len(numbers) + 1):
        better = found.copy()
        np.maximum.at(better, before, np.asarray(weight) + found[after])
        if (better == found).all():
            return float(found.max())
        found = better
    return float("inf")


class Compared(NamedTuple):
    """The bound of a rule, and the exact value."""

    bound: int
    exact: float


def compared(model: sym.SystemModel, page: sym.CallbackPage) -> Compared | None:
    """Return how often a callback can be called at most for goals sent before; None: not known."""
    ended = goals_ended(page)
    if ended is None:
        return None
    net = compile_net(flatten(model).net)
    called = {net.places.index(str(each.id)) for each in page.eAllContents() if isinstance(each, pn.Place)}
    goals = {net.places.index(str(each.goal.id)): each.times for each in ended}
    weights = {
        number: sum(change.get(at, 0) > 0 for at in called)
        - sum(times * max(0, change.get(at, 0)) for at, times in goals.items())
        for number, change in enumerate(net.delta)
    }
    exact = longest_path(net, weights)
    return None if exact is None else Compared(sum(each.times * each.under_way for each in ended), exact)


def test_no_callback_is_called_more_often() -> None:
    tight = 0
    for seed in range(SEEDS):
        model = drawn(seed)
        for name in ("over", "other"):
            found = compared(model, find(model, name, sym.CallbackPage))
            if found is not None:
                assert found.exact <= found.bound, (seed, name, found)
                tight += found.exact == found.bound
    assert tight > SEEDS / 4, tight


def test_acceptances_of_several_goals_pile_up() -> None:
    """The client takes results while a slow callback keeps its group."""
    model = drawn(2)
    (action,) = channels(model, sym.ActionChannel)
    (client,) = action.clients
    client.outstanding = 1
    assert client.accepted is not None and client.succeeded is not None
    page = find(model, "over", sym.CallbackPage)
    assert goals_ended(page) is not None
    client.outstanding = 2
    assert goals_ended(page) is None


def shared_goal(client: sym.ActionClientPort) -> None:
    action = client.channel
    assert action is not None
    action.clients.append(sym.ActionClientPort(client="another", goal=client.goal))


def marked_answer(client: sym.ActionClientPort) -> None:
    assert client.succeeded is not None
    client.succeeded.tokens = 1


@pytest.mark.parametrize("change", [shared_goal, marked_answer])
def test_goals_and_answers_from_elsewhere_are_not_bounded(
    change: Callable[[sym.ActionClientPort], None],
) -> None:
    model = drawn(4)
    (action,) = channels(model, sym.ActionChannel)
    page = callback_page_of(action.clients[0].succeeded)
    assert page is not None and goals_ended(page) is not None
    change(action.clients[0])
    assert goals_ended(page) is None


def with_bursts(depth: int) -> sym.SystemModel:
    """Return a client whose callback of results waits 180 ms for its group, while goals gather."""
    model = sym.SystemModel(id="robot", middleware="ros2")
    model.times = sym.DefaultTimes(latency=seconds(0, 0), duration=seconds(0, 0))
    worker = node_net(model, "worker", execution="callbacks")
    work = callback(worker, "work", "goal")
    entry, done = place(work, "entry"), place(work, "done")
    step(work, "does", [entry], [done])
    node = node_net(model, "client", execution="callbacks", threads=2)
    asks = callback(node, "asks", "timer", 0.03)
    asks.offset = seconds(0, 0)
    goal, told, runs = place(node, "goal"), place(node, "told"), place(asks, "asks.runs")
    goal.capacity = 3
    step(asks, "asks.begins", [], [runs]).kind = sym.TransitionKind.start
    step(asks, "asks.sends", [runs], [goal]).kind = sym.TransitionKind.end
    step(asks, "asks.waits", [runs], []).kind = sym.TransitionKind.end
    over, slow = callback(node, "over", "client"), callback(node, "slow", "timer", 0.21)
    over.group = slow.group = sym.CallbackGroup(id="own", name="own", kind="exclusive")
    node.callbackGroups.append(over.group)
    result = place(over, "result")
    step(over, "over.tells", [result], [told])
    slow.offset, slow.duration = seconds(0, 0), seconds(0.18, 0.18)
    step(slow, "slow.does", [], [])
    action = sym.ActionChannel(id="go", action="/go", model=model)
    action.server = sym.ActionServerPort(page=work, entry=entry, succeeded=done)
    client = sym.ActionClientPort(client="c", goal=goal, succeeded=result)
    client.outstanding = 1
    action.clients.append(client)
    hears = callback(node_net(model, "hearer", execution="callbacks"), "hears")
    message = place(hears, "message")
    step(hears, "hears.does", [message], [])
    topic = sym.TopicChannel(id="told.topic", topic="/told", model=model)
    topic.publishers.append(sym.PublisherPort(place=told))
    topic.subscribers.append(sym.SubscriberPort(place=message, limit=depth))
    return model


@pytest.mark.parametrize(
    ("depth", "loses", "proves"), [(4, True, False), (7, False, False), (8, False, True)]
)
def test_a_burst_of_results(depth: int, loses: bool, proves: bool) -> None:
    """The run under way, a goal under way, three that wait, and a goal of a run, a tick and a strike: 8."""
    subject = timed_base_subject(with_bursts(depth))
    names = subject.timed.untimed.transitions
    found = explore_timed(subject.timed, Budget(states=1_000_000))
    (drop,) = [each for each in names if ".reader." in each and each.endswith(".drop")]
    assert found.is_complete
    assert (names.index(drop) in found.ways, drop in never_lost(subject)) == (loses, proves)


def test_each_message_of_a_burst_has_a_clock() -> None:
    """As many as above; with fewer, messages would wait for one another, and none would be lost."""
    (topic,) = channels(with_bursts(4), sym.TopicChannel)
    assert on_the_way(topic.publishers[0], topic.subscribers[0]) == 8
