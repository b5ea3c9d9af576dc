"""Lifespans of messages: what is too old is not taken. A plain program that knows no nets finds the same."""

from __future__ import annotations

from collections import deque
from random import Random
from typing import NamedTuple

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.latencies.answers import Latencies
from dineros.analysis.timed_checks.timed_check import check_timed
from dineros.metamodel import sym
from dineros.metamodel.build import callback, node_net, place, seconds, step
from dineros.metamodel.constraints import validate
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.times.rates import ages_at_once
from tests.transformations.rules.test_times import explored


class Talk(NamedTuple):
    """A timer publishes for a slow reader; times in milliseconds."""

    period: int
    latency: tuple[int, int]
    depth: int
    work: tuple[int, int]
    lifespan: int


def model_of(talk: Talk) -> sym.SystemModel:
    model = sym.SystemModel(id="talk", middleware="ros2")
    timer = callback(node_net(model, "talker", execution="callbacks"), "OnTimer", "timer", talk.period / 1000)
    timer.offset = timer.duration = seconds(0, 0)
    said = place(timer, "Said")
    step(timer, "Say", [], [said])
    page = callback(node_net(model, "listener", execution="callbacks"), "OnWord")
    page.duration = seconds(*(bound / 1000 for bound in talk.work))
    heard = place(page, "Heard")
    step(page, "Hear", [heard])
    topic = sym.TopicChannel(id="Words", topic="/words", model=model)
    topic.latency = seconds(*(bound / 1000 for bound in talk.latency))
    topic.qos = sym.QualityOfService(lifespan=talk.lifespan / 1000)
    topic.publishers.append(sym.PublisherPort(place=said, limit=talk.depth))
    topic.subscribers.append(sym.SubscriberPort(place=heard, limit=talk.depth))
    assert [each for each in validate(model) if each.severity == "error"] == []
    return model


class Facts(NamedTuple):
    """The longest history, and whether a message can be displaced, and be too old."""

    longest: int
    overflows: bool
    expires: bool


def by_net(talk: Talk) -> Facts:
    found = explored(model_of(talk))
    names, places = found.net.untimed.transitions, found.net.untimed.places
    fired = {names[t] for t in found.ways}
    load = places.index("Words.reader.Heard.Load")
    return Facts(
        int(found.markings[:, load].max()),
        "Words.reader.Heard.drop" in fired,
        any(name.endswith((".expire", ".stale")) for name in fired),
    )


class State(NamedTuple):
    """Ages of messages on their way and in the history; how long the reader has worked, or -1; the clock."""

    sent: tuple[int, ...]
    held: tuple[int, ...]
    worked: int
    clock: int


class Plain:
    """Explores all behaviours in whole units of time, on the meaning of ROS."""

    def __init__(self, talk: Talk) -> None:
        self._talk = talk
        self._overflows = self._expires = False
        self._longest = 0

    def facts(self) -> Facts:
        first = State((), (), -1, self._talk.period)
        seen, todo = {first}, deque([first])
        while todo:
            state = todo.popleft()
            self._longest = max(self._longest, len(state.held))
            for after in self._next(state):
                if after not in seen:
                    seen.add(after)
                    todo.append(after)
        return Facts(self._longest, self._overflows, self._expires)

    def _next(self, state: State) -> list[State]:
        talk = self._talk
        found = []
        if state.clock == talk.period:
            found.append(state._replace(sent=(*state.sent, 0), clock=0))
        if state.sent and state.sent[0] >= talk.latency[0]:  # in order
            sent, age = state.sent[1:], state.sent[0]
            if age > talk.lifespan:
                self._expires = True
                found.append(state._replace(sent=sent))
            elif len(state.held) == talk.depth:
                self._overflows = True
                found.append(state._replace(sent=sent, held=(*state.held[1:], age)))
            else:
                found.append(state._replace(sent=sent, held=(*state.held, age)))
        is_idle = state.worked < 0
        if state.held and state.held[0] >= talk.lifespan:
            self._expires = True
            found.append(state._replace(held=state.held[1:]))
        if is_idle and state.held:
            found.append(state._replace(held=state.held[1:], worked=0))
        if state.worked >= talk.work[0]:
            found.append(state._replace(worked=-1))
        late = (
            state.clock >= talk.period
            or (bool(state.sent) and state.sent[0] >= talk.latency[1])
            or (is_idle and bool(state.held))
            or state.worked >= talk.work[1]
            or (bool(state.held) and state.held[0] >= talk.lifespan)
        )
        if not late:
            found.append(
                State(
                    tuple(age + 1 for age in state.sent),
                    tuple(age + 1 for age in state.held),
                    state.worked if is_idle else state.worked + 1,
                    state.clock + 1,
                )
            )
        return found


KNOWN = [
    (Talk(10, (0, 1), 5, (2, 5), 20), Facts(1, False, False)),
    # The reader works for 25: a message waits until it is 10 old, and another one has come by then.
    (Talk(10, (0, 0), 5, (25, 25), 10), Facts(2, False, True)),
    (Talk(10, (0, 0), 5, (25, 25), 9), Facts(1, False, True)),
    # On their way longer than they live: nothing is ever taken.
    (Talk(10, (8, 8), 5, (1, 1), 7), Facts(0, False, True)),
    # The same work without lifespans fills any history.
    (Talk(10, (0, 0), 2, (25, 25), 40), Facts(2, True, False)),
]


@pytest.mark.parametrize(("talk", "facts"), KNOWN)
def test_facts_that_are_counted_by_hand(talk: Talk, facts: Facts) -> None:
    assert by_net(talk) == Plain(talk).facts() == facts


@pytest.mark.long
@pytest.mark.parametrize("seed", range(24))
def test_random_systems_have_the_facts_of_a_plain_program(seed: int) -> None:
    draw = Random(seed)
    least, lag = draw.randint(0, 8), draw.randint(0, 3)
    period = draw.randint(2, 6)
    talk = Talk(
        period, (lag, lag + draw.randint(0, 3)), draw.randint(1, 3),
        (least, least + draw.randint(0, 4)), draw.randint(1, 3 * period),
    )  # fmt: skip
    assert by_net(talk) == Plain(talk).facts(), talk


def test_a_message_that_is_too_old_on_its_way_is_not_taken() -> None:
    found = explored(model_of(KNOWN[3][0]))
    assert "Words.reader.Heard.out" not in {found.net.untimed.transitions[t] for t in found.ways}


def test_a_lifespan_of_one_side_alone_may_count_or_not() -> None:
    """Implementations differ: messages may go, and nothing says that they do."""
    talk = Talk(10, (0, 0), 2, (25, 25), 10)
    model = model_of(talk)
    topic = model.channels[0]
    assert isinstance(topic, sym.TopicChannel)
    topic.qos = None
    topic.publishers[0].qos = sym.QualityOfService(lifespan=0.01)
    assert ages_at_once(topic.publishers[0], topic.subscribers[0]) == 0
    rules = {each.rule for each in check_timed(model).findings}
    assert {"message-expires", "queue-overflow"} <= rules


def test_a_check_reports_messages_that_are_too_old() -> None:
    sick, healthy = (check_timed(model_of(Talk(10, (0, 0), 5, (work, work), 10))) for work in (25, 5))
    assert {each.rule for each in sick.findings} == {"message-expires"}
    assert healthy.findings == []
    assert "no message is older than its lifespan before it is taken" in healthy.proved


def test_latencies_do_not_follow_lifespans() -> None:
    with pytest.raises(DinerosError, match="has a lifespan"):
        Latencies(model_of(KNOWN[0][0]), Budget(seconds=60))
