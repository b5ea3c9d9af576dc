"""Orders of executors: what the rules make of them is what a plain program finds that knows no nets."""

from __future__ import annotations

import copy
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.metamodel import pn, pnm, sym
from dineros.metamodel.build import flow, here, place, read
from dineros.metamodel.elements import channels, find, node_nets
from dineros.metamodel.times.orders import is_ignored, keeps_order, why_any
from dineros.transformations.flattening.flatten import flatten
from tests.support.timed_systems.counted import COUNTED
from tests.support.timed_systems.executors import Explorer, Facts
from tests.support.timed_systems.models import System, model_of
from tests.support.timed_systems.responses import may_take
from tests.transformations.rules.test_times import explored, fired


def timer(name: str, period: int, work: tuple[int, int], **more: Any) -> dict[str, Any]:
    script = [["work", *work], *(["publish", topic] for topic in more.pop("tells", ()))]
    return {
        "name": name, "node": "n", "period": period, "offset": 0, "group": "default", "script": script, **more
    }  # fmt: skip


def reader(name: str, topic: str, depth: int, work: tuple[int, int]) -> dict[str, Any]:
    return {
        "name": name, "node": "n", "topic": topic, "depth": depth, "group": "default",
        "script": [["work", *work]],
    }  # fmt: skip


def system(*callbacks: dict[str, Any], latency: dict[str, tuple[int, int]] | None = None) -> System:
    nodes = {each["node"]: {"threads": 1, "order": "rclcpp"} for each in callbacks}
    return {"nodes": nodes, "latency": latency or {}, "chains": [], "callbacks": list(callbacks)}


def facts(made: System) -> tuple[dict[str, int], set[str], set[str]]:
    found = explored(model_of(made, 0.01))
    top = dict(zip(found.net.untimed.places, found.markings.max(axis=0).tolist(), strict=True))
    longest = {
        name.split(".")[-3]: most
        for name, most in top.items()
        if ".reader." in name and name.endswith(".heard.Load")
    }
    names = found.net.untimed.transitions
    drops = {names[t] for t in found.ways if ".reader." in names[t] and names[t].endswith(".drop")}
    return longest, {name.split(".")[-3] for name in drops}, fired(found, ".miss")


def net_of(made: System, sporadic: bool = False) -> pnm.PetriNetModel:
    net = flatten(model_of(made), "none", times=True).net
    for each in made["callbacks"]:
        if sporadic:
            interval = find(net, f"{each['name']}.strike", pn.Transition).interval
            assert interval is not None
            interval.latest = None
    return net


THREE = [("a", 10, 1), ("b", 1000, 23), ("c", 100, 19)]
"""Name, least distance of strikes, duration: known greatest response times are 43, 44, 44."""


@pytest.mark.long
@pytest.mark.parametrize(("callback", "greatest"), [("a", 43), ("b", 44), ("c", 44)])
def test_response_times_with_a_wait_result_are_those_that_are_attained(callback: str, greatest: int) -> None:
    made = system(*(timer(name, distance, (work, work)) for name, distance, work in THREE))
    assert may_take(net_of(made, sporadic=True), callback, greatest)
    assert not may_take(net_of(made, sporadic=True), callback, greatest + 0.5)


def in_order(number: int, order: str) -> System:
    made = copy.deepcopy(COUNTED[number].system)
    for node in made["nodes"].values():
        node["order"] = order
    return made


@pytest.mark.long
@pytest.mark.parametrize("number", [1, 2, 3, 4, 5, 6, 7, 8, 11, 12, 14])
@pytest.mark.parametrize("order", ["any", "rclcpp"])
def test_counted_systems_have_the_facts_in_an_order(number: int, order: str) -> None:
    expected = Explorer(in_order(number, order)).explore()
    assert facts(in_order(number, order)) == (expected.longest, expected.lost, expected.missed)
    if order == "any":
        assert expected.longest == COUNTED[number].longest
        assert expected.lost == set(COUNTED[number].lost)
        assert expected.missed == set(COUNTED[number].missed)


def test_an_order_saves_a_timer_its_ticks() -> None:
    """Figure 8: in any order, both timers can lose ticks; from a wait result, only the fast one."""
    assert fired(explored(model_of(in_order(8, "any"), 0.01)), ".miss") == {"fast", "slow"}
    assert fired(explored(model_of(in_order(8, "rclpy"), 0.01)), ".miss") == {"fast"}


def test_all_orders_are_explored_where_something_else_decides_what_can_begin() -> None:
    def node_of(change: str) -> sym.NodeNet:
        made = model_of(system(timer("tick", 10, (1, 2), tells=["t"]), reader("log", "t", 2, (1, 1))), 0.01)
        (node,) = node_nets(made)
        page = find(made, "tick", sym.CallbackPage)
        (channel,) = channels(made, sym.TopicChannel)
        match change:
            case "threads":
                node.executor, node.threads = sym.Executor.multi, 2
            case "managed":
                node.lifecycle = sym.Lifecycle()
            case "words":
                flow(place(page, "words", tokens=3), find(made, "tick.do", sym.Transition))
            case "value" | "value that a test takes away":
                value = place(node, "value", tokens=1)
                read(here(value, page), find(made, "tick.do", sym.Transition))
                if change != "value":
                    flow(
                        here(value, find(made, "log", sym.CallbackPage)), find(made, "log.do", sym.Transition)
                    )
            case "in hand":
                channel.subscribers[0].inHand = 2
            case "engine":
                node.execution = sym.Execution.net
        return node

    assert keeps_order(node_of("nothing")) and not is_ignored(node_of("nothing"))
    assert keeps_order(node_of("value")), "it is always there"
    expected = {
        "threads": "several threads",
        "managed": "managed node",
        "words": "only in some states",
        "value that a test takes away": "only in some states",
        "in hand": "one at a time",
        "engine": "does not run callbacks",
    }
    for change, reason in expected.items():
        assert not keeps_order(node_of(change)) and is_ignored(node_of(change))
        assert reason in why_any(node_of(change))


@st.composite
def systems(draw: st.DrawFn) -> System:
    """Draw a node with up to four timers and subscriptions, and perhaps a node that publishes to it."""
    callbacks: list[dict[str, Any]] = []

    def work() -> tuple[int, int]:
        least = draw(st.integers(0, 3))
        return least, least + draw(st.integers(0, 2))

    topics = []
    if draw(st.booleans()):
        callbacks.append(timer("outside", draw(st.integers(4, 8)), (0, 1), node="m", tells=["u"]))
        topics.append("u")
    for number in range(draw(st.integers(1, 2))):
        more: dict[str, Any] = {"offset": draw(st.sampled_from([0, 1, "any"]))}
        if number == 0 and draw(st.booleans()):
            more["tells"] = ["t"]
            topics.append("t")
        callbacks.append(timer(f"timer{number}", draw(st.integers(3, 7)), work(), **more))
    for number in range(draw(st.integers(1, 2)) if topics else 0):
        depth = draw(st.integers(1, 2))
        callbacks.append(reader(f"reader{number}", draw(st.sampled_from(topics)), depth, work()))
    latency = {topic: draw(st.sampled_from([(0, 0), (0, 1), (1, 2)])) for topic in topics}
    return system(*callbacks, latency=latency)


def explore(made: System) -> Facts | None:
    try:
        return Explorer(made).explore(30_000)
    except ValueError:
        return None


@pytest.mark.long
@given(systems())
def test_random_systems_have_the_facts(made: System) -> None:
    expected = explore(made)
    if expected is None:
        return
    assert facts(made) == (expected.longest, expected.lost, expected.missed)
    for each in made["callbacks"]:
        if "period" in each and each["node"] == "n" and each["name"] in expected.response:
            _, greatest = expected.response[each["name"]]
            assert may_take(net_of(made), each["name"], greatest)
            assert not may_take(net_of(made), each["name"], greatest + 0.5)
