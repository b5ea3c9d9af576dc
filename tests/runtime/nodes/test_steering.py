"""A node in this process is steered: what it could do is seen at once, also while a handler keeps it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import pytest

from dineros.metamodel import sym
from dineros.metamodel.errors import FeatureValueError, UnknownElementError
from dineros.runtime import Net
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.firing.handlers import Firing
from dineros.runtime.nodes.core import NOT_ACTIVE
from dineros.runtime.nodes.steering import Outlook, SteeredNet, SteeringError
from dineros.transformations.flattening.split import split
from tests.support.ros2_systems.managed_systems import talk
from tests.support.systems.talker import talker


def until(condition: Callable[[], bool]) -> None:
    for _ in range(800):
        if condition():
            return
        time.sleep(0.025)
    raise AssertionError("it did not happen")


@pytest.fixture
def net() -> Net:
    """The node that says three words while its button is pressed."""
    return Net(next(each for each in split(talker()) if each.node.id == "talker"))


def test_signals_pausing_and_proceeding(net: Net) -> None:
    steered = SteeredNet(net)
    assert steered.look() == Outlook("running", None, {"Button": False}, [])  # nobody runs it yet
    with net:
        steered.pause("for a test")
        steered.set_signals({"Button": True}, "test")
        paused = Outlook("halted", "for a test", {"Button": True}, ["Say"])
        until(lambda: steered.look() == paused)
        for wrong in ({"Buttons": True}, {"Button": "yes"}):
            with pytest.raises((UnknownElementError, FeatureValueError)):
                steered.set_signals(wrong, "test")
        assert net.count("Words") == 3
        steered.proceed()
        until(lambda: steered.look() == Outlook("running", None, {"Button": True}, []))
        assert net.count("Words") == 0
    assert steered.look() == Outlook("ended", "stopped", {"Button": True}, [])


def test_of_a_busy_node_is_seen_what_it_was_in_before(net: Net, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing piles up meanwhile; a handler that is known to block it is named instead."""
    monkeypatch.setattr("dineros.runtime.nodes.steering.PATIENCE", 0.01)
    begun, release = threading.Event(), threading.Event()

    @net.handler("Say")
    def say(firing: Firing) -> None:
        begun.set()
        release.wait(20)

    net.watchdog = None
    steered = SteeredNet(net)
    try:
        with net:
            until(lambda: steered.look().signals == {"Button": False})
            steered.set_signals({"Button": True}, "test")
            assert begun.wait(10)
            for _ in range(5):
                assert steered.look() == Outlook("running", None, {"Button": False}, [])
            assert len(net.core.loop._inbox) == 1
            steered.pause("for a test")  # it is done when the handler returns
            release.set()
            until(lambda: steered.look() == Outlook("halted", "for a test", {"Button": True}, ["Say"]))
            assert net.count("Words") == 2
    finally:
        release.set()


def test_a_node_that_a_handler_blocks_says_so(net: Net) -> None:
    release = threading.Event()

    @net.handler("Say")
    def say(firing: Firing) -> None:
        release.wait(20)

    net.watchdog = 0.05
    steered = SteeredNet(net)
    try:
        with net:
            steered.set_signals({"Button": True}, "test")
            until(lambda: net.status.state == "blocked")
            seen = steered.look()
            assert (seen.state, seen.signals, seen.enabled) == ("blocked", None, None)
            release.set()
            until(lambda: steered.look() == Outlook("running", None, {"Button": True}, []))
    finally:
        release.set()


def test_a_managed_node_that_is_not_active_does_not_proceed() -> None:
    """Also not where it was paused before it was deactivated, which then is why it is halted."""
    model = talk(sym.Lifecycle(deactivates=True, pauses=True), None, tokens=3, depth=3)
    with LocalApplication(split(model), seed=1) as application:
        net = application.nets["talker"]
        steered = SteeredNet(net)
        steered.pause("for a test")
        net.change_state("deactivate")
        assert steered.look().reason == "for a test"
        with pytest.raises(SteeringError, match=f"{NOT_ACTIVE} .activate it"):
            steered.proceed()
        application.run(lambda app: False, timeout=1)
        assert net.count("Words") == 3
        net.change_state("activate")
        application.run(lambda app: False, timeout=1)
        assert net.count("Words") == 3  # it is paused still
        steered.proceed()
        application.run(lambda app: False, timeout=1)
        assert net.count("Words") == 0
        others = SteeredNet(net, lambda: False)  # its state is not the model's
        with pytest.raises(SteeringError, match=NOT_ACTIVE):
            others.proceed()
