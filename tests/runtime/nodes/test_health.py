"""How a node fares: what its handlers take, what it waits for, how full its queues were, and as metrics."""

from __future__ import annotations

import logging
import threading
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.metamodel import rtm, sym
from dineros.metamodel.build import flow
from dineros.runtime import Net
from dineros.runtime.firing.handlers import HandlerError
from dineros.runtime.nodes.health import RESTARTS, Health, HealthWatch, QueueFill
from dineros.runtime.nodes.snapshot import snapshot
from dineros.runtime.ros.channels.quality import FillMeter
from dineros.runtime.ros.metrics import metrics_text
from dineros.transformations.flattening.split import split


def mill(grains: int = 1) -> rtm.RuntimeModel:
    wish, grind, full = sym.Place(id="Wish", tokens=grains), sym.Transition(id="Grind"), sym.Place(id="Full")
    node = sym.NodeNet(id="mill", objects=[wish, grind, full], signals=[sym.InputSignal(id="Open")])
    flow(wish, grind, full)
    (part,) = split(sym.SystemModel(id="kitchen", pages=[node]))
    return part


def health_after(net: Net, firings: int) -> tuple[HealthWatch, Health]:
    watch = HealthWatch(net.core)
    with net:
        net.wait_for(lambda state: state.firings == firings, timeout=30)
    return watch, watch.look()


@pytest.mark.parametrize("thread", [False, True])
def test_a_slow_handler_is_a_concern_once_and_fails_nothing(
    thread: bool, caplog: pytest.LogCaptureFixture
) -> None:
    net = Net(mill(), seed=1)
    net.handler("Grind", name="turn", budget=0.001, thread=thread)(lambda firing: time.sleep(0.02))
    watch, health = health_after(net, 1)
    assert [(each.budget, each.element) for each in health.concerns] == [("handler-time", "Grind")]
    (load,) = health.handlers
    assert (load.handler, load.calls, load.slow) == ("turn", 1, 1)
    assert load.longest >= load.budget == 0.001  # type: ignore[operator]
    assert health.failures == 0
    assert "Grind" in caplog.text
    again = watch.look()
    assert again.concerns == ()
    assert again.handlers[0].mean > 0
    assert caplog.text.count("[handler-time]") == 1


def test_a_quick_handler_is_none_and_a_budget_is_above_0(caplog: pytest.LogCaptureFixture) -> None:
    net = Net(mill(), seed=1)
    net.handler("Grind", budget=60.0)(lambda firing: None)
    with caplog.at_level(logging.WARNING, "dineros.runtime"):
        assert health_after(net, 1)[1].concerns == ()
    assert caplog.text == ""
    with pytest.raises(HandlerError):
        net.handler("Grind", name="other", budget=0.0)(lambda firing: None)


def test_what_runs_is_told_as_a_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(RESTARTS, "3")
    net, gate = Net(mill(), seed=1), threading.Event()

    @net.handler("Grind", thread=True)
    def turn(firing: object) -> None:
        gate.wait(30)

    watch = HealthWatch(net.core)
    with net:
        net.wait_for(lambda state: bool(state.in_flight), timeout=30)
        net.signal("Open").set(True)
        net.wait_for(lambda state: state.signals["Open"], timeout=30)
        health = net.core.loop.call(watch.look)
        gate.set()
    (wait,) = health.waits
    assert (wait.element, wait.kind, wait.on) == ("Grind", "handler", "turn")
    (signal,) = health.ages
    assert signal.value
    assert signal.age is not None
    assert health.restarts == 3


@given(
    st.lists(st.tuples(st.integers(1, 5), st.integers(0, 12)), max_size=40).map(
        lambda steps: [(sum(step for step, _ in steps[: i + 1]), wait) for i, (_, wait) in enumerate(steps)]
    )
)
def test_the_fill_of_a_history_is_what_a_watcher_would_have_counted(messages: list[tuple[int, int]]) -> None:
    """Messages come at times and are taken in order, each no sooner than so long after it came."""
    taken: list[int] = []
    for came, wait in messages:
        taken.append(max(came + wait, taken[-1] if taken else 0))
    counted = max(
        (
            sum(came <= now < gone or came == now for (came, _), gone in zip(messages, taken, strict=True))
            for now, _ in messages
        ),
        default=0,
    )
    meter = FillMeter(1000)
    with pytest.MonkeyPatch.context() as patch:
        for (came, _), gone in zip(messages, taken, strict=True):
            patch.setattr(time, "time_ns", lambda gone=gone: gone)
            meter.took(came)
    assert meter.most_since() == counted
    assert meter.most_since() == 0


@pytest.mark.parametrize(
    ("waiting", "capacity", "expected"), [(8, 10, False), (9, 10, True), (1, 1, False), (2, 2, True)]
)
def test_a_queue_is_nearly_full_above_80_percent(waiting: int, capacity: int, expected: bool) -> None:
    assert QueueFill("P", "C", "/t", waiting, capacity).is_nearly_full is expected


@given(st.text(), st.text(), st.integers(0, 5))
def test_metrics_are_lines_whatever_the_names_hold(place: str, node: str, tokens: int) -> None:
    health = health_of({place: tokens})
    text = metrics_text(node, health)
    lines = text.split("\n")[:-1]
    assert all(line.startswith(("# HELP dineros_", "# TYPE dineros_", "dineros_")) for line in lines)
    assert sum(line.startswith("dineros_place_tokens{") for line in lines) == 1
    assert metrics_text(node, None) == ""


def health_of(places: dict[str, int]) -> Health:
    core = Net(mill(), seed=1).core
    return Health(**vars(snapshot(core)), restarts=0, rate=0.0, places=places)
