"""Simulated times lie within those that an independent program counted, and come near to them."""

from __future__ import annotations

from copy import deepcopy

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.analysis.simulated_times import robot
from dineros.analysis.timed_runs.simulating import Simulated, histogram, simulate_times
from dineros.metamodel import sym
from dineros.metamodel.build import callback, node_net, place, seconds, step
from dineros.metamodel.errors import DinerosError
from tests.support.timed_systems.counted import CHAINS, COUNTED, RESPONSES
from tests.support.timed_systems.models import System, model_of

TIGHT = 1e-9
SERVERS, TOPICS = ("look",), ("found",)
"""What no data is followed to."""


def overloaded() -> System:
    """Return system 2, whose reader takes longer than the time between two messages."""
    system = deepcopy(COUNTED[2].system)
    (log,) = (each for each in system["callbacks"] if each["name"] == "log")
    log["script"] = [["work", 5, 9]]
    return system


def within(found: Simulated, number: int) -> None:
    for name, (least, greatest) in RESPONSES.get(number, {}).items():
        if name in SERVERS:
            continue
        values = found.times[name, name].values
        assert least - TIGHT <= min(values) and max(values) <= greatest + TIGHT, name
    if number in CHAINS and CHAINS[number][1] not in TOPICS:
        first, last, least, greatest, loses = CHAINS[number]
        values = found.times[first, last].values
        assert least - TIGHT <= min(values) and max(values) <= greatest + TIGHT
        assert loses or not any(found.lost.values())


@pytest.mark.parametrize("number", COUNTED)
def test_counted_systems_keep_to_their_times(number: int) -> None:
    for seed in range(3):
        within(simulate_times(model_of(COUNTED[number].system), 2000.0, seed), number)


@settings(deadline=None, max_examples=20)
@given(seed=st.integers(0, 10**6))
def test_any_seed(seed: int) -> None:
    """A chain whose filter waits for another callback."""
    within(simulate_times(model_of(COUNTED[12].system), 500.0, seed), 12)


@pytest.mark.parametrize("number", [1, 3, 5, 11])
def test_long_runs_come_near_to_both_bounds(number: int) -> None:
    first, last, least, greatest, _ = CHAINS[number]
    values = simulate_times(model_of(COUNTED[number].system), 20_000.0, 1).times[first, last].values
    span = greatest - least
    assert min(values) < least + 0.25 * span and max(values) > greatest - 0.25 * span


def test_the_same_seed_gives_the_same_run() -> None:
    model = model_of(COUNTED[12].system)
    one, two, other = (simulate_times(model, 200.0, seed) for seed in (1, 1, 2))
    assert one.times == two.times and one.times != other.times


def test_messages_that_a_full_history_loses_are_counted() -> None:
    found = simulate_times(model_of(overloaded()), 2000.0, 1)
    first, last, *_ = CHAINS[2]
    sent, came = len(found.times["tick", "tick"].values), len(found.times[first, last].values)
    (lost,) = found.lost.values()
    assert lost > 0 and 0 <= sent - came - lost <= 3


def test_what_the_model_does_not_give_is_named() -> None:
    model = sym.SystemModel(id="half", middleware="ros2")
    eye = node_net(model, "eye", execution="callbacks")
    on_timer = callback(eye, "OnTimer", "timer", 0.1, duration=seconds(0.0, 0.02))
    image = place(on_timer, "Image")
    step(on_timer, "Grab", [], [image])
    brain = node_net(model, "brain", execution="callbacks")
    on_image = callback(brain, "OnImage")
    seen = place(on_image, "Seen")
    step(on_image, "Look", [seen], [])
    reader = sym.SubscriberPort(place=seen)
    topic = sym.TopicChannel(id="Images", topic="images", publishers=[sym.PublisherPort(place=image)])
    topic.subscribers.append(reader)
    model.channels.append(topic)
    assert simulate_times(model, 10.0, 1).missing == [
        "the duration of callback OnImage is not given",
        "the model gives no latency for topic images",
    ]


def test_a_model_without_times_is_refused() -> None:
    with pytest.raises(DinerosError, match="the model has no times"):
        simulate_times(sym.SystemModel(id="none", middleware="ros2"), 1.0)


def test_a_robot_of_twelve_nodes() -> None:
    found = simulate_times(robot(), 10.0, 1)
    assert not found.missing and not found.lost
    assert len(found.responses) == 15
    assert all(max(each.values) < 0.3 for each in found.chains)


@given(st.lists(st.floats(0, 1), min_size=1))
def test_a_histogram_counts_each_value_once(values: list[float]) -> None:
    assert sum(histogram(values)["counts"]) == len(values)
