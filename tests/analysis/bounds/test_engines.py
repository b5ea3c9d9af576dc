"""Histories that nodes of the execution `net` read: no bound is below what a plain explorer finds."""

from __future__ import annotations

import os
from random import Random

import pytest

from dineros.analysis.bounds.answers import Bounds
from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, inhibit, node_net, place, seconds, step
from dineros.metamodel.callbacks.groups import callback_page_of
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.elements import node_net_of
from tests.analysis.timed_checks.test_engines_in_chains import At, Chain, Stage, drawn, model_of, successors

SEEDS = 150 * int(os.environ.get("DINEROS_EXAMPLES", "1"))
MOST_STATES = 20_000


def longest(chain: Chain) -> tuple[list[int], set[int]] | None:
    """Return how many messages wait at most in each stage, and which overflow; None if there is too much."""
    lost: set[int] = set()
    first = (0, -1, tuple(At() for _ in chain.stages))
    todo, seen = [first], {first}
    while todo:
        for after in successors(chain, todo.pop(), lost):
            if after not in seen:
                seen.add(after)
                todo.append(after)
        if len(seen) > MOST_STATES:
            return None
    return [max(state[2][number].waiting for state in seen) for number in range(len(chain.stages))], lost


def readers(model: sym.SystemModel) -> list[sym.SubscriberPort]:
    return [
        port for topic in model.channels if isinstance(topic, sym.TopicChannel) for port in topic.subscribers
    ]


def test_no_bound_is_too_low() -> None:
    proved = safe = systems = 0
    for seed in range(SEEDS):
        chain = drawn(Random(seed))
        exact = longest(chain)
        if exact is None:
            continue
        systems += 1
        model = model_of(chain)
        bounds = Bounds(model)
        for number, port in enumerate(readers(model)):
            most = bounds.longest(port)
            assert most is None or most >= exact[0][number], (seed, chain)
            never = bounds.never_overflows(port)
            assert not (never and number in exact[1]), (seed, chain)
            proved += never
            safe += number not in exact[1]
    assert systems > SEEDS * 0.8 and proved > 0.6 * safe, (systems, proved, safe)


def plain() -> sym.SystemModel:
    """Return a timer of 50 ms, and a node that takes its messages within twice 10 ms."""
    return model_of(Chain(5, 0, (Stage((0, 1), 1, 1),)))


def never_overflows(model: sym.SystemModel) -> bool:
    bounds = Bounds(model)
    (port,) = readers(model)
    (told,) = (found for name, found in bounds.everything().readers.items() if name == port.place.id)
    assert (told[1] is False) == bounds.never_overflows(port)
    return bounds.never_overflows(port)


def test_a_message_that_is_taken_before_the_next_one_comes() -> None:
    assert never_overflows(plain())
    assert not never_overflows(model_of(Chain(1, 0, (Stage((0, 1), 1, 1),))))


@pytest.mark.parametrize("change", ["inhibits", "needs", "clause", "back", "no reaction", "shared", "full"])
def test_what_may_wait_has_no_bound(change: str) -> None:
    """Something else decides when the only transition that takes messages fires."""
    model = plain()
    (port,) = readers(model)
    page = callback_page_of(port.place)
    assert page is not None
    node = node_net_of(page)
    assert node is not None
    (move,) = [each for each in page.objects if isinstance(each, sym.Transition)]
    other = place(page, "Other", 1)
    if change == "inhibits":
        inhibit(other, move)
    elif change == "needs":
        pn.Arc(source=other, target=move, page=page)
    elif change == "clause":
        node.signals.append(sym.InputSignal(id="Signal", name="Signal"))
        set_clause(move, "Signal")
    elif change == "back":
        step(page, "Back", [port.place], [port.place])
    elif change == "no reaction":
        node.reaction = None
    elif change == "shared":
        step(page, "Long", [port.place]).duration = seconds(0, 1)
    else:
        other.capacity = 1
        pn.Arc(source=move, target=other, page=page)
    assert not never_overflows(model)


def test_another_publisher_of_a_place_restarts_the_clock() -> None:
    """A place of a publisher has room for one message: what a clock counts begins again after each."""
    model = plain()
    (port,) = readers(model)
    page = callback_page_of(port.place)
    assert page is not None
    (move,) = [each for each in page.objects if isinstance(each, sym.Transition)]
    out = place(page, "Out")
    pn.Arc(source=move, target=out, page=page)
    topic = sym.TopicChannel(id="More", topic="more", latency=seconds(0, 0), model=model)
    topic.publishers.append(sym.PublisherPort(place=out, limit=5))
    bounds = Bounds(model)
    assert bounds.never_overflows(port)
    step(page, "Busy", [], [out])
    assert not Bounds(model).never_overflows(port)


def test_what_callbacks_of_executors_publish() -> None:
    """A timer's callback publishes twice: two messages wait, and the third comes after they are gone."""
    model = sym.SystemModel(id="both", middleware="ros2")
    page = callback(node_net(model, "robot", execution="callbacks"), "OnTick", "timer", 0.1)
    page.offset, page.duration = seconds(0, 0), seconds(0, 0.01)
    out = place(page, "Out")
    pn.Arc(source=step(page, "Say"), target=out, page=page, weight=2)
    net = node_net(model, "engine")
    net.reaction = seconds(0, 0.01)
    heard = place(net, "Heard")
    step(net, "Take", [heard])
    topic = sym.TopicChannel(id="Topic", topic="t", latency=seconds(0, 0.01), model=model)
    topic.publishers.append(sym.PublisherPort(place=out, limit=5))
    topic.subscribers.append(sym.SubscriberPort(place=heard, limit=2))
    assert never_overflows(model)
    assert Bounds(model).longest(topic.subscribers[0]) == 2
    topic.subscribers[0].limit = 1
    assert not never_overflows(model)
