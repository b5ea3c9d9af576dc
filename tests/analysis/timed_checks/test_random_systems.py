"""Random systems of ROS 2: what a check proves without all state classes never happens in one of them.

A plain program that knows no nets explores each system with several executors, threads, groups and lifespans.
State classes must find the same. So must the counters of time, if the system is small enough for them. Bounds
of response times, the net without its times, and parts of the net must never exclude what happens.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from random import Random
from typing import Any, NamedTuple

import numpy as np
import pytest

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.bounds.losses import never_lost
from dineros.analysis.latencies.parts import Parts
from dineros.analysis.latencies.paths import callback_pages
from dineros.analysis.timed.exploring import Explored, explore_timed
from dineros.analysis.timed.integers.counting import all_markings
from dineros.analysis.timed.integers.net import integer_net
from dineros.analysis.timed.reductions.parts import part_of_firing
from dineros.analysis.timed.timed_subject import TimedSubject, timed_base_subject
from dineros.analysis.timed_checks.without_times import without_times
from dineros.metamodel import sym
from dineros.metamodel.build import seconds
from dineros.metamodel.elements import channels, find, node_nets
from dineros.metamodel.errors import DinerosError
from tests.analysis.bounds.test_no_bound_is_too_low import drawn
from tests.support.reachability import TooManyStatesError
from tests.support.ros2_systems.deserted_services import Asking, ask
from tests.support.timed_systems.aging import Aging
from tests.support.timed_systems.models import System, model_of
from tests.transformations.rules.test_goals_in_time import Drive, driving

SEEDS = 12 * int(os.environ.get("DINEROS_EXAMPLES", "1"))
MOST_STATES = 8_000
CLASSES = Budget(seconds=20, states=20_000)
COUNTERS = Budget(seconds=10, states=200_000)
LOST = (".drop", ".expire", ".stale")
"""Ends of the names of transitions that lose a message."""


class Facts(NamedTuple):
    """The longest histories, and what can be lost: messages in full histories, ticks, messages by age."""

    longest: dict[str, int]
    lost: set[str]
    missed: set[str]
    expired: set[str]


def drawn_with_lifespans(seed: int) -> System:
    """Return nodes of up to three threads; every other topic has a lifespan."""
    system, draw = drawn(seed, most_threads=3), Random(seed)
    system["lifespan"] = {topic: draw.randint(1, 14) for topic in system["latency"] if draw.random() < 0.5}
    return system


def drawn_with_writers(seed: int) -> System:
    """Return systems of which topics may have several publishers, or none."""
    system, draw = drawn(seed, most_threads=2), Random(seed)
    system["lifespan"] = {}
    for number, each in enumerate(system["callbacks"]):
        each["script"][1][1] = f"t{draw.randint(0, number)}"
    return system


def model_with_lifespans(system: System) -> sym.SystemModel:
    model = model_of(system)
    for topic in channels(model, sym.TopicChannel):
        if topic.topic in system["lifespan"]:
            topic.qos = sym.QualityOfService(lifespan=float(system["lifespan"][topic.topic]))
    return model


def by_program(system: dict[str, Any]) -> Facts:
    program = Aging(system)
    found = program.explore(MOST_STATES)
    return Facts(found.longest, found.lost, found.missed, program.expired)


def fired(subject: TimedSubject, found: Explored) -> set[str]:
    return {subject.timed.untimed.transitions[t] for t in found.ways}


def by_classes(subject: TimedSubject, found: Explored) -> Facts:
    happens, parts = fired(subject, found), Parts(subject)
    index = {name: at for at, name in enumerate(subject.timed.untimed.places)}
    longest, lost, expired = {}, set(), set()
    for reader, queue in parts.histories.items():
        name = str(reader.place.id).removesuffix(".heard")
        longest[name] = int(found.markings[:, index[queue.load]].max())
        if happens & set(queue.drops):
            lost.add(name)
        if any(f".{name}.heard." in each and each.endswith(LOST[1:]) for each in happens):
            expired.add(name)
    missed = {str(page.id) for page, loses in parts.lost_ticks.items() if loses in happens}
    return Facts(longest, lost, missed, expired)


def require_possible(subject: TimedSubject, found: Explored) -> int:
    """Require that no method that needs no classes excludes what they found; return how much is excluded."""
    happens = fired(subject, found)
    bounded = never_lost(subject)
    proof = without_times(subject, Budget(seconds=10))
    assert not (bounded | proof.dead) & happens
    assert proof.most is None or proof.most >= int(found.markings.max(initial=0))
    assert not (proof.has_no_deadlock and found.ends)
    names, excluded = subject.timed.untimed.transitions, bounded | proof.dead
    for transition, name in enumerate(names):
        part = part_of_firing(subject.timed, transition) if name.endswith(LOST) else None
        seen = None if part is None else explore_timed(part.net, Budget(seconds=5))
        if seen is not None and seen.is_complete and transition not in seen.ways:
            assert name not in happens
            excluded = excluded | {name}
    return len(excluded)


def is_confirmed(subject: TimedSubject, found: Explored) -> bool:
    """Require that counters of time find the same markings and firings; return whether they ended."""
    places = subject.timed.untimed.places
    try:
        markings, firings = all_markings(integer_net(subject.timed), places, COUNTERS)
    except (BudgetExceededError, DinerosError):
        return False  # too many states, or too many units of time
    assert firings == found.ways.keys()
    assert np.array_equal(markings, np.unique(found.markings, axis=0))
    return True


@pytest.mark.long
@pytest.mark.parametrize("made", [drawn_with_lifespans, drawn_with_writers])
def test_threads_and_groups(made: Callable[[int], System]) -> None:
    systems = excluded = expired = confirmed = 0
    for seed in range(SEEDS):
        system = made(seed)
        try:
            facts = by_program(system)
        except TooManyStatesError:
            continue
        subject = timed_base_subject(model_with_lifespans(system))
        found = explore_timed(subject.timed, CLASSES)
        if not found.is_complete:
            continue
        systems += 1
        assert by_classes(subject, found) == facts, seed
        excluded += require_possible(subject, found)
        confirmed += is_confirmed(subject, found)
        expired += len(facts.expired)
    assert systems >= SEEDS / 3
    assert excluded > 0 and confirmed > 0
    assert (expired > 0) == (made is drawn_with_lifespans)


def asking(seed: int) -> sym.SystemModel:
    """Return clients of one service, some with time-outs; its node may be managed, or have two threads."""
    draw = Random(seed)
    kinds: list[Asking] = ["once", "waits", "gives up", "engine", "engine gives up"]
    server = draw.choice([None, None, sym.Lifecycle(), sym.Lifecycle(deactivates=True)])
    clients = [draw.choice(kinds) for _ in range(draw.randint(1, 2))]
    model = ask(server, clients, threads=draw.randint(1, 2), times=draw.randint(1, 2))
    least = draw.choice([0.0, 0.0, 0.5, 1.0])
    model.channels[0].latency = seconds(least, least + draw.choice([0.0, 0.5, 1.0]))
    work = draw.choice([0.0, 0.5, 1.5])
    page = find(model, "Serve")
    assert isinstance(page, sym.CallbackPage)
    page.duration = draw.choice([None, seconds(work, work + draw.choice([0.0, 0.5]))])
    model.times = draw.choice([None, sym.DefaultTimes(reaction=seconds(0, 0.5))])
    return model


def acting(seed: int) -> sym.SystemModel:
    """Return a node that sends goals to a server, and may cancel one."""
    draw = Random(seed)
    lag, work = draw.randint(0, 2), draw.randint(0, 4)
    latency, works = (lag, lag + draw.randint(0, 2)), (work, work + draw.randint(0, 3))
    drive = Drive(draw.randint(4, 16), latency, works, draw.randint(1, 2))
    cancels = draw.random() < 0.6
    return driving(
        drive,
        *draw.choice([("callbacks", "net"), ("net", "net"), ("callbacks",) * 2][: 3 - cancels]),
        cancels=cancels,
    )


def mixed(seed: int) -> sym.SystemModel:
    """Return a system with best-effort topics, shallow writer histories, managed nodes, and orders."""
    system, draw = drawn_with_writers(seed), Random(seed)
    model = model_of(system)
    for topic in channels(model, sym.TopicChannel):
        if draw.random() < 0.3:
            topic.qos = sym.QualityOfService(reliability="bestEffort")
        for writer in topic.publishers:
            writer.limit = draw.randint(1, 3)
        if draw.random() < 0.2:
            topic.latency = draw.choice([None, seconds(1, None)])
    for node in node_nets(model):
        if draw.random() < 0.2:
            node.lifecycle = sym.Lifecycle(deactivates=draw.random() < 0.5)
        elif node.threads == 1 and draw.random() < 0.5:
            node.order = draw.choice([sym.CallbackOrder.rclcpp, sym.CallbackOrder.rclpy])
    for page in callback_pages(model):
        if draw.random() < 0.1:
            page.duration = None
    return model


@pytest.mark.long
@pytest.mark.parametrize("made", [asking, acting, mixed])
def test_other_systems(made: Callable[[int], sym.SystemModel]) -> None:
    systems = excluded = confirmed = 0
    for seed in range(SEEDS):
        subject = timed_base_subject(made(seed))
        found = explore_timed(subject.timed, CLASSES)
        if not found.is_complete:
            continue
        systems += 1
        excluded += require_possible(subject, found)
        confirmed += is_confirmed(subject, found)
    assert systems >= SEEDS / 3
    assert excluded > 0
    assert confirmed > 0 or made is mixed, "most mixed systems have too many units of time"
