"""Chains through values that a callback stores and another one reads, against a program without nets."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget
from dineros.analysis.latencies.answers import Latencies, end_of
from dineros.analysis.latencies.results import Latency
from dineros.analysis.latencies.stores import stored_values
from dineros.metamodel import sym
from dineros.metamodel.build import place, step
from dineros.metamodel.elements import find, node_nets
from tests.support.timed_systems.models import System, model_of
from tests.support.timed_systems.sampled import SampledExplorer


def called(name: str, node: str, least: float, most: float, *topics: str, **more: Any) -> dict[str, Any]:
    script = [["work", least, most], *(["publish", topic] for topic in topics)]
    return {"name": name, "node": node, "group": "default", "script": script} | more


def system_of(callbacks: list[dict[str, Any]], latency: dict[str, tuple[int, int]]) -> System:
    nodes = {each["node"]: {"threads": 1} for each in callbacks}
    return {"nodes": nodes, "latency": latency, "chains": [], "callbacks": callbacks}


def between(model: sym.SystemModel, first: str, last: str) -> Latency:
    return Latencies(model, Budget(seconds=100)).between(end_of(model, first), end_of(model, last))


def assert_as_explored(system: System, first: str, last: str) -> None:
    try:
        wanted = SampledExplorer(system, first, last).explore(60_000)
    except ValueError:
        reject()  # there are too many states for a plain program
    found = between(model_of(system), first, last)
    assert found.is_exact and not found.reason
    assert (found.least and found.least.value, found.greatest and found.greatest.value) == (
        wanted.least,
        wanted.greatest,
    )
    assert found.is_lost == wanted.lost
    assert (found.age and found.age.value) == wanted.age
    if found.reaction is not None:  # two observers that have little in common
        assert found.reaction == found.age


@st.composite
def sampling(draw: st.DrawFn) -> System:
    """A sensor's messages are stored; a timer or another subscription reads them."""

    def work() -> tuple[int, int]:
        least = draw(st.integers(0, 2))
        return least, least + draw(st.integers(0, 1))

    period = draw(st.integers(4, 6))
    other = draw(st.sampled_from([period, 2 * period, period + 2]))
    with_pose = draw(st.booleans())
    node = draw(st.sampled_from(["a", "b"]))
    callbacks = [
        called("sense", "a", *work(), "scan", period=period, offset=0),
        called("store", "b", *work(), topic="scan", depth=draw(st.integers(1, 2)), stores="last"),
    ]
    if draw(st.booleans()):
        callbacks.append(called("tick", node, *work(), "go", period=other, offset=draw(st.integers(0, 3))))
        sampler = called("sample", "b", *work(), topic="go", depth=1, samples=["last"])
    else:
        sampler = called(
            "sample", "b", *work(), period=other, offset=draw(st.integers(0, 3)), samples=["last"]
        )
    callbacks.append(sampler)
    if with_pose:
        sampler["script"].append(["publish", "pose"])
        callbacks.append(called("act", "c", *work(), topic="pose", depth=1))
    latency = {topic: draw(st.sampled_from([(0, 0), (0, 1), (1, 1)])) for topic in ("scan", "go", "pose")}
    return system_of(callbacks, latency)


@settings(max_examples=12, deadline=None)
@given(sampling())
def test_random_systems_have_the_times_that_a_plain_program_finds(system: System) -> None:
    last = system["callbacks"][-1]["name"]
    assert_as_explored(system, "sense", last)


def teper(fusion: str, actuator: str, period: int, sampling: int) -> sym.SystemModel:
    """Two sensors, filters, a fusion and an actuator on a thread; the last two sample (T) or do not (S).

    H. Teper et al., *End-to-end timing analysis in ROS2*, RTSS 2022.
    """
    callbacks = [
        called("sensor1", "n", 10, 10, "s1", period=period, offset=0),
        called("sensor2", "n", 20, 20, "s2", period=period, offset=0),
        called("process1", "n", 10, 10, "p1", topic="s1", depth=10),
        called("process2", "n", 20, 20, "p2", topic="s2", depth=10),
        called("filter3", "n", 30, 30, "g", topic="f", depth=10),
        called("fusion2", "n", 30, 30, topic="p2", depth=10, stores="second"),
    ]
    if fusion == "S":
        callbacks.append(called("fusion1", "n", 30, 30, "f", topic="p1", depth=10, samples=["second"]))
    else:
        callbacks.append(called("fusion1", "n", 30, 30, topic="p1", depth=10, stores="first"))
        fuse = called("fuse", "n", 30, 30, "f", period=sampling, offset=0, samples=["first", "second"])
        callbacks.append(fuse)
    if actuator == "S":
        callbacks.append(called("actuator", "n", 30, 30, topic="g", depth=10))
    else:
        callbacks.append(called("command", "n", 30, 30, topic="g", depth=10, stores="newest"))
        callbacks.append(called("actuator", "n", 30, 30, period=sampling, offset=0, samples=["newest"]))
    model = model_of(system_of(callbacks, {}), 0.001)
    for node in node_nets(model):
        node.order = sym.CallbackOrder.rclcpp
    return model


@pytest.mark.parametrize(
    ("fusion", "actuator", "period", "sampling", "simulated", "bound", "exact"),
    [
        ("S", "S", 360, 720, 540, 1430, 540),
        ("S", "T", 420, 840, 1320, 2900, 1320),
        ("T", "S", 420, 840, 1470, 2900, 1470),
        ("T", "T", 480, 960, 2490, 4730, 2490),
    ],
)
def test_published_systems_react_between_what_was_simulated_and_the_bound(
    fusion: str, actuator: str, period: int, sampling: int, simulated: int, bound: int, exact: int
) -> None:
    found = between(teper(fusion, actuator, period, sampling), "sensor1", "actuator")
    assert found.reaction is not None and found.reaction == found.age
    assert simulated <= found.reaction.value * 1000 <= bound
    assert found.reaction.value * 1000 == exact


def simple(**sampler: Any) -> System:
    """A value is stored at 2, 12, 22, ..., and read at 5, 25, ..."""
    return system_of(
        [
            called("sense", "a", 1, 1, "scan", period=10, offset=0),
            called("store", "b", 1, 1, topic="scan", depth=2, stores="last"),
            called("sample", "b", 1, 1, period=20, offset=5, samples=["last"], **sampler),
        ],
        {"scan": (0, 0)},
    )


def test_every_other_value_is_displaced_unread() -> None:
    found = between(model_of(simple()), "sense", "sample")
    assert found.least is not None and found.greatest is not None
    assert found.least.value == found.greatest.value == 6 and found.is_lost
    assert (
        found.reaction is not None and found.reaction.value == 26
    )  # just after 20: 30 is stored, 40 is read


def test_a_place_with_several_values_is_not_followed() -> None:
    model = model_of(simple())
    value = find(model, "last.value")
    assert isinstance(value, sym.Place)
    value.tokens = 2
    found = between(model, "sense", "sample")
    assert (
        found.greatest is None
        and found.reason == "place last.value holds several values, which cannot be distinguished"
    )


def test_what_another_callback_may_replace_gives_a_safe_bound() -> None:
    system = simple()
    system["callbacks"].append(called("other", "b", 1, 1, period=20, offset=15, stores="last"))
    found = between(model_of(system), "sense", "sample")
    assert not found.is_exact and found.reaction is None
    assert found.greatest is not None and found.greatest.value >= 6


def test_a_lock_is_no_way_of_data() -> None:
    model = model_of(simple())
    node = find(model, "b")
    assert isinstance(node, sym.NodeNet)
    lock = place(node, "lock", tokens=1)
    for name in ("store", "sample"):
        page = find(model, name)
        assert isinstance(page, sym.CallbackPage)
        holds = place(page, f"{name}.holds")
        step(page, f"{name}.lock", [lock], [holds])
        step(page, f"{name}.unlock", [holds], [lock])
    assert [(each.place.id, each.reader.id) for each in stored_values(model)] == [("last.value", "sample")]


@pytest.mark.parametrize(
    ("on_the_way", "exact"), [(0, (58.2, 72.3, 58.2)), (1, (59.2, 74.3, 61.2))], ids=["at once", "up to 1 ms"]
)
def test_chains_on_two_threads(on_the_way: int, exact: tuple[float, ...]) -> None:
    """Three chains of callbacks in one process: others measured 44, 54 and 60 ms.

    Every order is explored here. The third one cannot take longer than its own work and that of the first, if
    messages take no time: then the measured 60 ms hold 1.8 ms of the middleware and the machine.

    X. Jiang et al., *Real-time scheduling and analysis of processing chains on multi-threaded executor in
    ROS 2*, RTSS 2022.
    """
    chains = [(100, (23.1, 7.9)), (100, (20.6, 17.9, 6.6)), (160, (1.7, 11.0, 6.6, 7.9))]
    callbacks, latency = [], {}
    for number, (period, works) in enumerate(chains):
        for at, work in enumerate(works):
            topic = f"t{number}{at}"
            latency[topic] = (0, on_the_way)
            released = {"topic": topic, "depth": 2} if at else {"period": period, "offset": 0}
            topics = [f"t{number}{at + 1}"] if at + 1 < len(works) else []
            name = f"c{number}{at}"
            callbacks.append(called(name, "n", work, work, *topics, group=name, **released))
    system = {"nodes": {"n": {"threads": 2}}, "latency": latency, "chains": [], "callbacks": callbacks}
    latencies = Latencies(model_of(system, 0.001), Budget(seconds=100))
    found = []
    for number, (_, works) in enumerate(chains):
        ends = (end_of(latencies.model, name) for name in (f"c{number}0", f"c{number}{len(works) - 1}"))
        found.append(latencies.between(*ends, with_ages=False))
    assert all(each.is_exact for each in found)
    assert tuple(each.greatest and float(each.greatest.value * 1000) for each in found) == exact
