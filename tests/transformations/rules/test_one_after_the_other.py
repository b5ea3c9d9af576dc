"""Messages whose number nothing bounds: the first one arrives within the latency after the one before.

A node publishes messages of a pool at any time. A plain explorer in whole units of time knows all runs of it,
of messages that arrive in order, and of a node net that takes them.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, replace
from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.bounded import read_bounded
from dineros.analysis.timed.durations.bounded_response import decide_bounded
from dineros.analysis.timed.durations.stopping import always_within
from dineros.analysis.timed.goals import find_timed_firing
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.metamodel import sym
from dineros.metamodel.build import callback, flow, node_net, place, seconds, step
from dineros.metamodel.times.rates import on_the_way

LONGEST = 60
"""Units after which a message counts as one that is never used."""


@dataclass(frozen=True)
class Pool:
    """A system: `messages` of a pool, their latency, the depth of the reader, its reaction."""

    messages: int
    earliest: int
    latest: int
    depth: int
    reaction: int


@dataclass(frozen=True)
class State:
    """Messages that are left, ages of those on the way, those in the history, and the one in the node."""

    left: int
    ages: tuple[int, ...] = ()
    waiting: int = 0
    has: bool = False
    takes: int = 0
    uses: int = 0
    since: int | None = None
    """Units since the publication that is watched."""


def explored(system: Pool) -> tuple[int, bool]:
    """Return the longest time from a publication to the next use, and whether a message is displaced."""
    first = State(system.messages)
    seen, todo = {first}, deque([first])
    longest, is_displaced = -1, False
    while todo:
        state = todo.popleft()
        for after, used, displaced in _steps(system, state):
            is_displaced |= displaced
            if used is not None:
                longest = max(longest, used)
            if after not in seen and (after.since is None or after.since <= LONGEST):
                seen.add(after)
                todo.append(after)
            elif after.since is not None and after.since > LONGEST:
                longest = LONGEST
    return longest, is_displaced


def _steps(system: Pool, state: State) -> Iterator[tuple[State, int | None, bool]]:
    if state.left:
        sent = replace(state, left=state.left - 1, ages=(*state.ages, 0))
        yield sent, None, False
        if state.since is None:
            yield replace(sent, since=0), None, False
    if state.ages and state.ages[0] >= system.earliest:
        is_full = state.waiting == system.depth
        waiting = min(system.depth, state.waiting + 1)
        takes = 0 if is_full or not state.waiting else state.takes
        yield replace(state, ages=state.ages[1:], waiting=waiting, takes=takes), None, is_full
    if state.waiting and not state.has:
        yield replace(state, waiting=state.waiting - 1, has=True, takes=0, uses=0), None, False
    if state.has:
        used = replace(state, has=False, takes=0, since=None if state.since is None else -1)
        if state.since is None or state.since >= 0:
            yield (replace(used, since=None), state.since, False)
    must_arrive = any(age == system.latest for age in state.ages)
    must_take = state.waiting and not state.has and state.takes == system.reaction
    must_use = state.has and state.uses == system.reaction
    if not (must_arrive or must_take or must_use):
        yield (
            replace(
                state,
                ages=tuple(age + 1 for age in state.ages),
                takes=state.takes + 1 if state.waiting and not state.has else 0,
                uses=state.uses + 1 if state.has else 0,
                since=None if state.since is None else state.since + 1,
            ),
            None,
            False,
        )


def model_of(system: Pool) -> sym.SystemModel:
    """Return the model; the watched time begins with a publication."""
    model = sym.SystemModel(id="pool", middleware="ros2")
    sender = node_net(model, "sender")
    sent = place(sender, "Sent")
    move = step(sender, "Send", [place(sender, "Left", system.messages)], [sent])
    move.interval = seconds(0.0, None)
    taker = node_net(model, "taker")
    page = callback(taker, "OnHeard")
    heard = place(page, "Heard")
    flow(heard, step(page, "Use"))
    for net, latest in ((sender, 0), (taker, system.reaction)):
        net.reaction = seconds(0.0, float(latest))
    topic = sym.TopicChannel(
        id="Topic", topic="/topic", latency=seconds(float(system.earliest), float(system.latest))
    )
    topic.publishers.append(sym.PublisherPort(place=sent, limit=system.messages))
    topic.subscribers.append(sym.SubscriberPort(place=heard, limit=system.depth))
    model.channels.append(topic)
    assert on_the_way(topic.publishers[0], topic.subscribers[0]) == 0
    return model


def drawn(seed: int) -> Pool:
    random = Random(seed)
    earliest = random.randint(0, 2)
    return Pool(
        random.choice((1, 2, 2, 3, 3)),
        earliest,
        earliest + random.randint(0, 3),
        random.randint(1, 2),
        random.randint(0, 2),
    )


@pytest.mark.parametrize("seed", range(200))
def test_no_run_is_missing(seed: int) -> None:
    """No bound below the longest time is proved, and what can be displaced is found."""
    system = drawn(seed)
    longest, is_displaced = explored(system)
    subject = timed_base_subject(model_of(system))
    if is_displaced:
        found = find_timed_firing(subject.timed, "Topic.reader.Heard.drop", subject.names, Budget(seconds=60))
        assert found.status == "reachable", system
    for bound in (longest - 1, longest):
        if bound < 0:
            continue
        formula = read_bounded(f"G (fired(Send) -> X F[<={bound}] fired(Use))")
        assert formula is not None
        exact = decide_bounded(subject.timed, formula, subject.names, Budget(seconds=60)).status
        proved = always_within(subject.timed, formula, subject.names, Budget(seconds=60))
        if bound < longest:
            assert (exact, proved) == ("violated", None), system
        elif system.messages == 1:
            assert exact == "holds" and proved is not None, system


def test_one_message_takes_its_latency_and_two_reactions() -> None:
    assert explored(Pool(1, 0, 5, 1, 2)) == (9, False)
    subject = timed_base_subject(model_of(Pool(1, 0, 5, 1, 2)))
    for bound, expected in ((9, "holds"), (8, "violated")):
        formula = read_bounded(f"G (fired(Send) -> X F[<={bound}] fired(Use))")
        assert formula is not None
        assert decide_bounded(subject.timed, formula, subject.names).status == expected


def test_messages_that_may_be_lost_have_no_bound() -> None:
    """One that is lost would leave the time of the next one at that of the first one."""
    model = model_of(Pool(2, 0, 5, 1, 2))
    (topic,) = model.channels
    assert isinstance(topic, sym.TopicChannel)
    topic.qos = sym.QualityOfService(reliability=sym.Reliability.bestEffort)
    net = timed_base_subject(model).timed
    number = net.untimed.transitions.index("Topic.writer.Sent.Heard.out")
    assert net.intervals[number].latest is None
