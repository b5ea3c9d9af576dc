"""Bounds of counted and published systems, and of large ones."""

from __future__ import annotations

import time
from fractions import Fraction
from typing import Any

import pytest

from dineros.analysis.bounds.answers import Bounds
from dineros.analysis.latencies.answers import end_of
from dineros.analysis.latencies.results import Latency
from dineros.metamodel import sym
from dineros.metamodel.build import callback, flow, here, node_net, place, seconds, step
from dineros.metamodel.elements import channels, find, node_nets
from tests.support.timed_systems.counted import CHAINS, COUNTED, RESPONSES
from tests.support.timed_systems.models import System, model_of

OPEN_RESPONSES = {2: {"log"}, 8: {"fast", "slow"}, 15: {"look"}, 16: {"look", "spin"}}
"""What has no bound, or a high one: too much to do, or calls of services."""
TIGHT_CHAINS = {1, 3, 4, 5, 6, 11, 12, 13, 14}
"""Systems whose chain has a bound that is attained."""


def greatest(found: Latency) -> Fraction | None:
    return None if found.greatest is None else found.greatest.value


@pytest.mark.parametrize("number", COUNTED)
def test_bounds_of_counted_systems(number: int) -> None:
    model = model_of(COUNTED[number].system, 0.01)
    bounds = Bounds(model)
    everything = bounds.everything()
    for name, (_, exact) in RESPONSES.get(number, {}).items():
        bound = greatest(everything.callbacks[name])
        if name in OPEN_RESPONSES.get(number, ()):
            assert bound is None or bound * 100 >= exact
        else:
            assert bound is not None and bound * 100 == exact, "it is attained"
    for place_id, (longest, overflows) in everything.readers.items():
        name = place_id.partition(".")[0]
        if name in COUNTED[number].longest:
            assert longest >= COUNTED[number].longest[name]
            assert overflows is None or name not in COUNTED[number].lost
    for name, loses in everything.timers.items():
        assert loses is None or name not in COUNTED[number].missed
    if number in CHAINS:
        first, last, _, exact, _ = CHAINS[number]
        found = bounds.between(end_of(model, first), end_of(model, last))
        assert not found.is_exact
        bound = greatest(found)
        if number in TIGHT_CHAINS:
            assert bound is not None and bound * 100 == exact
        else:
            assert bound is None or bound * 100 >= exact


@pytest.mark.parametrize("number", [1, 3, 4, 5, 11, 12, 13])
def test_nothing_is_lost_in_counted_systems(number: int) -> None:
    found = Bounds(model_of(COUNTED[number].system, 0.01)).everything()
    assert all(overflows is False for _, overflows in found.readers.values())
    assert all(loses is False for loses in found.timers.values())


@pytest.mark.parametrize("order", ["any", "rclcpp"])
def test_the_published_system_has_the_bound_that_is_attained(order: str) -> None:
    """540 ms were simulated, and 1430 ms are the bound of its authors.

    H. Teper et al., *End-to-end timing analysis in ROS2*, RTSS 2022.
    """
    rows: list[tuple[str, int, list[str], dict[str, Any]]] = [
        ("sensor1", 10, ["s1"], {"period": 360, "offset": 0}),
        ("sensor2", 20, ["s2"], {"period": 360, "offset": 0}),
        ("process1", 10, ["p1"], {"topic": "s1", "depth": 10}),
        ("process2", 20, ["p2"], {"topic": "s2", "depth": 10}),
        ("fusion1", 30, ["f"], {"topic": "p1", "depth": 10}),
        ("fusion2", 30, [], {"topic": "p2", "depth": 10}),
        ("filter3", 30, ["g"], {"topic": "f", "depth": 10}),
        ("actuator", 30, [], {"topic": "g", "depth": 10}),
    ]
    model = model_of(
        _system([_row(name, "n", work, tells, **more) for name, work, tells, more in rows]), 0.001
    )
    for node in node_nets(model):
        node.order = order
    found = Bounds(model).between(end_of(model, "sensor1"), end_of(model, "actuator"))
    assert found.reaction is not None and found.reaction.value == Fraction(540, 1000)
    assert found.reaction == found.age and found.is_lost is False


def _row(name: str, node: str, work: int | tuple[int, int], tells: list[str], **more: Any) -> dict[str, Any]:
    least, most = work if isinstance(work, tuple) else (work, work)
    script = [["work", least, most], *(["publish", topic] for topic in tells)]
    return {"name": name, "node": node, "group": "default", "script": script, **more}


def _system(callbacks: list[dict[str, Any]], latency: tuple[int, int] = (0, 0)) -> System:
    nodes = {each["node"]: {"threads": 1} for each in callbacks}
    topics = {step[1] for each in callbacks for step in each["script"] if step[0] == "publish"}
    return {"nodes": nodes, "latency": dict.fromkeys(topics, latency), "chains": [], "callbacks": callbacks}


def chain(length: int, nodes: int, period: int) -> System:
    """Return a chain of callbacks that work for 1 to 3, some on each node, one after another."""
    callbacks = []
    for number in range(length):
        more: dict[str, Any] = {"topic": f"t{number - 1}", "depth": 10}
        if number == 0:
            more = {"period": period, "offset": "any"}
        callbacks.append(_row(f"c{number}", f"n{number * nodes // length}", (1, 3), [f"t{number}"], **more))
    return _system(callbacks, (0, 1))


def test_a_chain_of_sixty_callbacks() -> None:
    began = time.monotonic()
    model = model_of(chain(60, 20, 100), 0.001)
    found = Bounds(model).between(end_of(model, "c0"), end_of(model, "c59"))
    assert time.monotonic() - began < 10, "it takes a fifth of a second"
    assert found.least is not None and found.least.value == Fraction(60, 1000)
    bound = greatest(found)
    assert bound is not None and Fraction(239, 1000) <= bound <= Fraction(450, 1000)
    assert found.is_lost is False and found.reaction is not None


def test_a_busy_node_of_the_order_rclcpp_starves_nobody() -> None:
    """The timer takes all time that there is; the messages have a bound, as wait results hold one tick."""
    rows = [
        _row("fast", "a", 10, [], period=10, offset=0),
        _row("tell", "b", 1, ["t"], period=1000, offset=0),
        _row("log", "a", 5, [], topic="t", depth=2),
    ]
    model = model_of(_system(rows), 0.001)
    assert greatest(Bounds(model).everything().callbacks["log"]) is None
    for node in node_nets(model):
        node.order = sym.CallbackOrder.rclcpp
    found = Bounds(model).everything()
    bound = greatest(found.callbacks["log"])
    assert bound is not None and Fraction(15, 1000) <= bound <= Fraction(45, 1000)
    assert found.readers["log.heard"][1] is False and found.timers["fast"] is None


def open_reason(model: sym.SystemModel, name: str = "act") -> str:
    return Bounds(model).everything().callbacks[name].reason


def test_what_is_not_bounded_is_named() -> None:
    def changed(change: str) -> sym.SystemModel:
        model = model_of(COUNTED[12].system, 0.01)
        page = find(model, "filter", sym.CallbackPage)
        topic = next(each for each in channels(model, sym.TopicChannel) if each.topic == "scan")
        node = next(each for each in node_nets(model) if each.id == "b")
        move = find(model, "filter.do", sym.Transition)
        match change:
            case "duration":
                page.duration = None
            case "latency":
                topic.latency = None
            case "managed":
                node.lifecycle = sym.Lifecycle()
            case "engine":
                node.execution = sym.Execution.net
            case "state":
                flow(place(page, "words", tokens=1), move)
            case "other publisher":
                engine = node_net(model, "engine")
                out = place(engine, "out")
                always = place(engine, "always", tokens=1)
                step(engine, "tell", [always], [out, always])
                topic.publishers.append(sym.PublisherPort(place=out, limit=10))
            case "messages at the start":
                topic.publishers[0].place.tokens = 1
            case "period":
                find(model, "other", sym.CallbackPage).timer = None
            case "circle":
                back = place(find(model, "act", sym.CallbackPage), "back")
                flow(find(model, "act.do", sym.Transition), back)
                topic.publishers.append(sym.PublisherPort(place=back, limit=10))
                for name in ("filter", "act"):
                    find(model, name, sym.CallbackPage).duration = seconds(0, 0.01)
        return model

    assert open_reason(changed("nothing"), "other") == ""
    before = " (callback filter can run before callback other)"
    expected = {
        "duration": "the duration of callback filter is not given" + before,
        "latency": "the model gives no latency for topic scan" + before,
        "managed": "node b is managed: its callbacks run only in some states",
        "state": "callback filter may have to wait for other callbacks" + before,
        "other publisher": "nothing bounds how often topic scan is published: by transition tell of node",
        "messages at the start": "topic scan has messages at the start" + before,
        "circle": "messages flow in a circle, and callback act has no least duration" + before,
    }
    for change, reason in expected.items():
        assert reason in open_reason(changed(change), "other"), change
    assert "the period of callback other is not given" in open_reason(changed("period"), "filter")
    assert open_reason(changed("engine"), "filter") == "the reaction of node b is not given"
    assert greatest(Bounds(changed("engine")).everything().callbacks["act"]) is not None, (
        "its history is short"
    )
    assert any(
        each.startswith("place filter.heard holds") or "reaction of node b is not given" in each
        for each in Bounds(changed("engine")).everything().reasons.values()
    )


def test_a_value_that_is_kept_does_not_stop_a_run() -> None:
    """One of two places is always marked, so that one of two steps is always possible."""
    model = model_of(COUNTED[11].system, 0.01)
    page = find(model, "filter", sym.CallbackPage)
    node = next(each for each in node_nets(model) if each.id == "b")
    idle, busy = place(node, "idle", tokens=1), place(node, "busy")
    move = find(model, "filter.do", sym.Transition)
    heard = find(model, "filter.heard", sym.Place)
    refer = {each: here(each, page) for each in (idle, busy)}
    flow(refer[idle], move, refer[busy])
    assert "may have to wait" in open_reason(model, "filter")
    other = sym.Transition(id="filter.again", page=page)
    flow(heard, other)
    flow(refer[busy], other, refer[idle])
    found = Bounds(model)
    bound = greatest(found.everything().callbacks["filter"])
    assert bound == Fraction(6, 100)
    whole = found.between(end_of(model, "sense"), end_of(model, "act"))
    assert greatest(whole) == Fraction(11, 100)
    assert whole.reaction is None, "not each scan makes a pose"
    busy_elsewhere = callback(node, "steals")
    step(busy_elsewhere, "steal", [busy])
    assert "may have to wait" in open_reason(model, "filter")


@pytest.mark.parametrize(
    ("threads", "group", "is_bounded"), [(2, "{}", False), (3, "{}", True), (3, "reentrant", False)]
)
def test_callbacks_of_unknown_durations_can_take_all_threads(
    threads: int, group: str, is_bounded: bool
) -> None:
    rows = [_row(name, "n", 1, [], period=10, offset=0, group=group.format(name)) for name in ("a", "b")]
    rows.append(_row("c", "n", 1, [], period=10, offset=0, group="c"))
    model = model_of({**_system(rows), "nodes": {"n": {"threads": threads}}}, 0.01)
    for name in ("a", "b"):
        page = find(model, name)
        assert isinstance(page, sym.CallbackPage)
        page.duration = None
    found = Bounds(model).everything()
    assert (greatest(found.callbacks["c"]) is not None) is is_bounded
    assert (found.timers["c"] is False) is is_bounded


def with_guard(is_always_possible: bool) -> sym.SystemModel:
    """Return system 1, whose log works 2 to 5, with a guard on a step or on a shorter way beside it."""
    model = model_of(COUNTED[1].system, 0.01)
    model.tokenType = sym.TokenType(id="Value", fields=[sym.TokenField(name="wide", kind="boolean")])
    page = find(model, "log")
    does = find(model, "log.do")
    assert isinstance(page, sym.CallbackPage) and isinstance(does, sym.Transition)
    does.guard = "wide = true"
    if is_always_possible:
        heard = find(model, "log.heard")
        assert isinstance(heard, sym.Place)
        step(page, "log.else", [heard], [])
    return model


@pytest.mark.parametrize(
    ("kind", "values", "guards", "is_bounded"),
    [
        ("boolean", None, ["wide = true", "wide = false"], True),
        ("boolean", None, ["wide = true", "wide = true"], False),
        ("integer", "A=0, B=1, C=2", ["wide = 'A'", "wide > 0"], True),
        ("integer", "A=0, B=1, C=2", ["wide = 'A'", "wide = 'B'"], False),
        ("integer", None, ["wide = 1", "not wide = 1"], True),
        ("integer", None, ["wide = 1", "wide > 1"], False),
    ],
)
def test_guards_that_choose_between_branches_keep_no_run_back(
    kind: str, values: str | None, guards: list[str], is_bounded: bool
) -> None:
    model = with_guard(is_always_possible=True)
    assert model.tokenType is not None
    (wide,) = model.tokenType.fields
    wide.kind, wide.values = kind, values
    for name, guard in zip(("log.do", "log.else"), guards, strict=True):
        each = find(model, name)
        assert isinstance(each, sym.Transition)
        each.guard = guard
    bounds = Bounds(model).everything().callbacks["log"]
    assert bounds.greatest is None or bounds.greatest.value == Fraction(5, 100)
    assert (bounds.greatest is not None) is is_bounded


def test_a_guard_can_keep_a_run_back() -> None:
    bounds = Bounds(with_guard(is_always_possible=False)).everything().callbacks["log"]
    assert bounds.greatest is None and bounds.reason == "callback log may have to wait for other callbacks"
    assert greatest(Bounds(with_guard(is_always_possible=True)).everything().callbacks["log"]) == Fraction(
        5, 100
    )
