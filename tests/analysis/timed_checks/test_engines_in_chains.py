"""Chains of node nets with reactions and latencies: what their histories lose, against a plain explorer.

The explorer counts time in whole units. It knows a timer, ticks, messages on their way in order, histories
and reactions; it has no Petri net.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.timed_checks.timed_check import check_timed
from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, node_net, place, step
from dineros.metamodel.times.rates import on_the_way

UNIT = 0.01


@dataclass(frozen=True)
class Stage:
    """A topic to a node that takes its messages, and passes them on if there is another stage."""

    latency: tuple[int, int]
    depth: int
    reaction: int


@dataclass(frozen=True)
class Chain:
    """A timer whose node publishes within its reaction, and what follows."""

    period: int
    reaction: int
    stages: tuple[Stage, ...]


@dataclass(frozen=True)
class At:
    """What a stage holds: ages of messages on their way, how many wait, and ages of what is possible."""

    sent: tuple[int, ...] = ()
    waiting: int = 0
    take: int = -1
    hand: int = -1

    def renewed(self, waiting: int, hand: int, is_restarted: bool) -> At:
        """Return it with the clock of the next taking as it must be."""
        can_take = waiting > 0 and hand < 0
        take = -1 if not can_take else 0 if is_restarted or self.take < 0 else self.take
        return replace(self, waiting=waiting, hand=hand, take=take)


State = tuple[int, int, tuple[At, ...]]
"""Time to the next strike, age of the tick that is due or -1, and the stages."""


def overflowing(chain: Chain) -> set[int]:
    """Return the numbers of the stages whose history can be full when a message arrives."""
    found: set[int] = set()
    todo: list[State] = [(0, -1, tuple(At() for _ in chain.stages))]
    seen = set(todo)
    while todo:
        state = todo.pop()
        for after in successors(chain, state, found):
            if after not in seen:
                seen.add(after)
                todo.append(after)
    return found


def successors(chain: Chain, state: State, found: set[int]) -> list[State]:
    """Return what can be next: something happens now, or a unit of time passes if nothing has to."""
    left, due, at = state
    last = len(at) - 1
    after: list[State] = []

    def put(number: int, stage: At, others: tuple[At, ...] = at) -> tuple[At, ...]:
        return (*others[:number], stage, *others[number + 1 :])

    def sent_to(number: int, others: tuple[At, ...]) -> tuple[At, ...]:
        return put(number, replace(others[number], sent=(*others[number].sent, 0)), others)

    if left == 0:
        after.append((chain.period, max(due, 0), at))
    if due >= 0:
        after.append((left, -1, sent_to(0, at)))
    for number, (stage, here) in enumerate(zip(chain.stages, at, strict=True)):
        if here.sent and here.sent[0] >= stage.latency[0]:
            is_full = here.waiting == stage.depth
            found |= {number} if is_full else set()
            got = replace(here, sent=here.sent[1:])
            after.append(
                (left, due, put(number, got.renewed(min(here.waiting + 1, stage.depth), here.hand, is_full)))
            )
        if here.take >= 0:
            after.append((left, due, put(number, here.renewed(here.waiting - 1, 0, True))))
        if here.hand >= 0:
            gone = put(number, here.renewed(here.waiting, -1, False))
            after.append((left, due, gone if number == last else sent_to(number + 1, gone)))
    has_to = left == 0 or due == chain.reaction
    for stage, here in zip(chain.stages, at, strict=True):
        has_to |= bool(here.sent) and here.sent[0] == stage.latency[1]
        has_to |= stage.reaction in (here.take, here.hand)
    if not has_to:
        later = tuple(
            replace(
                here,
                sent=tuple(age + 1 for age in here.sent),
                take=here.take + (here.take >= 0),
                hand=here.hand + (here.hand >= 0),
            )
            for here in at
        )
        after.append((left - 1, due + (due >= 0), later))
    return after


def seconds(first: int, last: int) -> pn.TimeInterval:
    return pn.TimeInterval(earliest=first * UNIT, latest=last * UNIT)


def model_of(chain: Chain) -> sym.SystemModel:
    """Return the chain as a system model."""
    model = sym.SystemModel(id="chain", middleware="ros2")
    first = node_net(model, "first")
    first.reaction = seconds(0, chain.reaction)
    page = callback(first, "Timer", "timer", chain.period * UNIT)
    page.offset = seconds(0, 0)
    out = place(page, "Out")
    step(page, "Say", [], [out])
    for number, stage in enumerate(chain.stages):
        node = node_net(model, f"node{number}")
        node.reaction = seconds(0, stage.reaction)
        page = callback(node, f"On{number}")
        heard = place(page, f"Heard{number}")
        topic = sym.TopicChannel(id=f"Topic{number}", topic=f"t{number}", latency=seconds(*stage.latency))
        topic.publishers.append(sym.PublisherPort(place=out, limit=5))
        topic.subscribers.append(sym.SubscriberPort(place=heard, limit=stage.depth))
        model.channels.append(topic)
        is_last = number == len(chain.stages) - 1
        out = place(page, f"Out{number}")
        step(page, f"Do{number}", [heard], [] if is_last else [out])
        if is_last:
            page.objects.remove(out)
    return model


def drawn(random: Random) -> Chain:
    """Return a random chain of one or two stages."""
    stages = []
    for _ in range(random.choice((1, 1, 2))):
        least = random.randint(0, 2)
        stages.append(
            Stage((least, least + random.randint(0, 3)), random.randint(1, 2), random.randint(0, 2))
        )
    return Chain(random.randint(3, 7), random.randint(0, 2), tuple(stages))


@pytest.mark.parametrize("seed", range(20))
def test_histories_lose_what_the_explorer_says(seed: int) -> None:
    chain = drawn(Random(seed))
    model = model_of(chain)
    for topic in model.channels:
        assert isinstance(topic, sym.TopicChannel)
        assert on_the_way(topic.publishers[0], topic.subscribers[0]) > 0
    report = check_timed(model, Budget(seconds=60))
    lost = {
        each.elements[0]
        for each in report.findings
        if each.rule == "queue-overflow" and each.message.startswith("reader history")
    }
    expected = {f"Topic{number}" for number in overflowing(chain)}
    assert lost == expected, chain
    proved = {
        number
        for number in range(len(chain.stages))
        for line in report.proved
        if f"reader history of Heard{number} " in line and "never overflows" in line
    }
    assert {f"Topic{number}" for number in proved} == {
        f"Topic{n}" for n in range(len(chain.stages))
    } - expected


def test_what_nothing_bounds_stays_open() -> None:
    """A node that may publish a message at any time, and one that holds any number of messages."""
    model = model_of(Chain(5, 1, (Stage((0, 2), 2, 1), Stage((0, 2), 2, 1))))
    first, second = model.channels
    assert isinstance(first, sym.TopicChannel) and isinstance(second, sym.TopicChannel)
    ends = second.publishers[0], second.subscribers[0]
    assert on_the_way(*ends) > 0
    first.subscribers[0].inHand = -1
    assert on_the_way(*ends) == 0
    first.subscribers[0].inHand = None
    page = first.subscribers[0].place.page
    again = sym.Transition(id="Again", page=page)
    pn.Arc(source=again, target=first.subscribers[0].place, page=page)
    assert on_the_way(*ends) == 0
