"""Response times and latencies, against what an independent program counted in whole units of time."""

from __future__ import annotations

from copy import deepcopy
from fractions import Fraction
from pathlib import Path

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.latencies.answers import Latencies, end_of
from dineros.analysis.latencies.paths import callback_pages
from dineros.analysis.latencies.results import Latency
from dineros.metamodel import sym
from dineros.metamodel.build import seconds
from dineros.metamodel.elements import channels, find, node_nets, transitions
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files import load
from tests.support.timed_systems.counted import CHAINS, COUNTED, RESPONSES
from tests.support.timed_systems.models import model_of

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"


def asked(model: sym.SystemModel, seconds: float = 100) -> Latencies:
    return Latencies(model, Budget(seconds=seconds))


def units(found: Latency) -> tuple[object, object]:
    """Return the bounds in hundredths of a second."""
    assert found.is_exact and not found.reason
    least, greatest = found.least, found.greatest
    return (
        None if least is None else least.value * 100,
        None if greatest is None else greatest.value * 100,
    )


@pytest.mark.long
@pytest.mark.parametrize("number", COUNTED)
def test_counted_systems_have_their_times(number: int) -> None:
    model = model_of(COUNTED[number].system, 0.01)
    latencies = asked(model)
    everything = latencies.everything()
    for name, wanted in RESPONSES.get(number, {}).items():
        assert units(everything.callbacks[name]) == wanted, name
    longest = {name.partition(".")[0]: most for name, (most, _) in everything.readers.items()}
    lost = {name.partition(".")[0] for name, (_, loses) in everything.readers.items() if loses}
    heard = {name: most for name, most in longest.items() if name in COUNTED[number].longest}
    assert heard == COUNTED[number].longest
    assert lost == set(COUNTED[number].lost)
    assert {name for name, loses in everything.timers.items() if loses} == set(COUNTED[number].missed)
    if number in CHAINS:
        first, last, least, greatest, loses = CHAINS[number]
        found = latencies.between(end_of(model, first), end_of(model, last))
        assert (*units(found), found.is_lost) == (least, greatest, loses)
        # Two observers that have little in common: Günzel et al. show that both are equal.
        assert found.reaction is not None and found.reaction == found.age
        if not loses:  # the event just misses a release, and the next one has the greatest latency
            (period,) = [
                each["period"] for each in COUNTED[number].system["callbacks"] if each["name"] == first
            ]
            assert found.reaction.value * 100 == period + greatest


@pytest.mark.long
@pytest.mark.parametrize("order", ["any", "rclcpp"])
def test_a_published_system_reacts_as_its_authors_saw(order: str) -> None:
    """Two sensors, filters and a fusion on a thread: 540 ms were simulated, 1430 ms are the bound.

    H. Teper et al., *End-to-end timing analysis in ROS2*, RTSS 2022.
    """
    callbacks = [
        {"name": name, "node": "n", "group": "default", "script": [["work", work, work], *told], **released}
        for name, work, told, released in (
            ("sensor1", 10, [["publish", "s1"]], {"period": 360, "offset": 0}),
            ("sensor2", 20, [["publish", "s2"]], {"period": 360, "offset": 0}),
            ("process1", 10, [["publish", "p1"]], {"topic": "s1", "depth": 10}),
            ("process2", 20, [["publish", "p2"]], {"topic": "s2", "depth": 10}),
            ("fusion1", 30, [["publish", "f"]], {"topic": "p1", "depth": 10}),
            ("fusion2", 30, [], {"topic": "p2", "depth": 10}),
            ("filter3", 30, [["publish", "g"]], {"topic": "f", "depth": 10}),
            ("actuator", 30, [], {"topic": "g", "depth": 10}),
        )
    ]
    topics = dict.fromkeys(("s1", "s2", "p1", "p2", "f", "g"), (0, 0))
    system = {"nodes": {"n": {"threads": 1}}, "latency": topics, "chains": [], "callbacks": callbacks}
    model = model_of(system, 0.001)
    for node in node_nets(model):
        node.order = order
    found = asked(model).between(end_of(model, "sensor1"), end_of(model, "actuator"))
    assert found.reaction is not None and found.reaction.value == Fraction(540, 1000)


def test_from_and_to_topics() -> None:
    model = model_of(COUNTED[11].system, 0.01)
    latencies = asked(model)
    found = latencies.between(end_of(model, "scan"), end_of(model, "/pose"))
    assert units(found) == (3, 7), "the way of the scan, and the work of the filter"


def test_what_is_missing_is_named() -> None:
    model = model_of(COUNTED[11].system, 0.01)
    page = find(model, "filter")
    assert isinstance(page, sym.CallbackPage)
    page.duration = None
    found = asked(model, 12).between(end_of(model, "sense"), end_of(model, "act"))
    assert found.greatest is None and found.least is not None and found.least.value == Fraction(2, 100)
    assert found.reason == "the duration of callback filter is not given"
    assert found.is_lost is not False, "what takes longer than the clock runs is not followed"
    model = model_of(COUNTED[11].system, 0.01)
    (scan,) = [each for each in channels(model, sym.TopicChannel) if each.topic == "scan"]
    scan.latency = None
    found = asked(model, 12).between(end_of(model, "sense"), end_of(model, "act"))
    assert found.reason == "the model gives no latency for topic scan"


def test_a_publisher_that_waits_for_room_is_followed() -> None:
    """Without a latency, what the writer hands on has a place with room for one message."""
    model = load(EXAMPLES / "callbacks" / "sensor.sym.xmi")
    assert isinstance(model, sym.SystemModel)
    for page in callback_pages(model):
        page.duration = seconds(0, 0.001)
    found = asked(model, 12).between(end_of(model, "OnTimer"), end_of(model, "OnScan"))
    assert found.least is not None and found.reason == "the model gives no latency for topic scans"


def test_a_callback_beside_it_without_a_duration_is_named() -> None:
    model = model_of(COUNTED[7].system, 0.01)
    page = find(model, "slow")
    assert isinstance(page, sym.CallbackPage)
    page.duration = None
    fast = asked(model).everything().callbacks["fast"]
    assert fast.greatest is None and "duration of callback slow is not given" in fast.reason


def calling(group: str = "default", clients: int = 1) -> sym.SystemModel:
    """Return a timer's callback that waits for a response, with a duration instead of intervals."""
    system = deepcopy(COUNTED[15].system)
    ask = system["callbacks"][0]
    ask["group"] = group
    system["callbacks"] += [
        {**ask, "name": f"ask{number}", "script": ask["script"][:3]} for number in range(1, clients)
    ]
    model = model_of(system, 0.01)
    for transition in transitions(model):
        transition.interval = None
    for page in callback_pages(model):
        page.duration = page.duration or seconds(0, 0.02)
    return model


def test_stretches_between_waits_give_safe_bounds() -> None:
    """Two stretches of up to 2 each are not longer than 2 together: the true greatest time is 8."""
    found = asked(calling()).everything().callbacks["ask"]
    assert found.greatest is not None and found.greatest.value == Fraction(10, 100)
    assert not found.is_exact and not found.reason


def test_the_order_of_requests_of_several_clients_is_not_kept() -> None:
    found = asked(calling(clients=2)).everything().callbacks["look"]
    assert not found.is_exact


def test_overlapping_runs_that_wait_are_not_told_apart() -> None:
    found = asked(calling("reentrant")).everything().callbacks["ask"]
    assert found.least is None and found.greatest is None and not found.is_exact
    assert found.reason == "runs of callback ask overlap and wait, so they cannot be distinguished"


def test_wrong_questions_are_refused() -> None:
    model = model_of(COUNTED[1].system, 0.01)
    with pytest.raises(DinerosError, match="no data flows from callback log to callback tick"):
        asked(model).between(end_of(model, "log"), end_of(model, "tick"))
    with pytest.raises(DinerosError, match="no callback or topic is called tock"):
        end_of(model, "tock")
    with pytest.raises(DinerosError, match="the model has no times"):
        asked(sym.SystemModel(id="empty", middleware="ros2"))
    with pytest.raises(DinerosError, match="for ROS 2 only"):
        asked(sym.SystemModel(id="empty", middleware="ros1"))


def test_a_limit_of_classes_ends_a_small_search_too() -> None:
    model = model_of(COUNTED[2].system, 0.01)
    for most in (1, 50):
        few = Latencies(model, Budget(states=most))
        assert few.reason == "there are too many state classes" and few.everything().callbacks == {}
    assert asked(model).reason == ""
