"""A handler that blocks its node: it is named, and the node ends all the same."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Iterator

import pytest

from dineros.metamodel.errors import DinerosError
from dineros.runtime import Change, Firing, Net, Node
from dineros.runtime.journal.recording import ListRecorder
from tests.runtime.tiny import events, tiny

SECONDS = 60.0


@pytest.fixture
def gate() -> Iterator[threading.Event]:
    """Open at the end, so that no thread stays."""
    made = threading.Event()
    yield made
    made.set()


def wait_until(condition: object) -> None:
    assert callable(condition)
    end = time.monotonic() + SECONDS
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_a_handler_that_blocks_is_named_once_with_its_stack(
    gate: threading.Event, caplog: pytest.LogCaptureFixture
) -> None:
    net = Net(tiny({"pick": "a -> b"}, {"a": 1}), watchdog=0.1)

    @net.handler("pick")
    def close_gripper(firing: Firing) -> None:
        gate.wait(SECONDS)

    with net, caplog.at_level(logging.INFO, "dineros"):
        wait_until(lambda: net.status.state == "blocked")
        status = net.status
        assert status.blocked is not None
        assert (status.blocked.transition, status.blocked.handler) == ("pick", "close_gripper")
        assert "in close_gripper\n    gate.wait(SECONDS)" in status.blocked.stack
        assert "in _go_on" not in status.blocked.stack  # nothing of the engine
        time.sleep(0.5)  # several more looks
        gate.set()
        net.wait_for(lambda state: state.count("b") == 1, SECONDS)
        assert (net.status.state, net.status.blocked) == ("running", None)
    errors = [record.getMessage() for record in caplog.records if record.levelno == logging.ERROR]
    assert len(errors) == 1
    assert "the handler close_gripper of pick has blocked the node node for 0." in errors[0]
    assert "gate.wait(SECONDS)" in errors[0]
    assert "the handler close_gripper of pick has returned after" in caplog.text


@pytest.mark.parametrize("what", ["selection", "callback"])
def test_other_code_on_the_nodes_thread_is_named_too(gate: threading.Event, what: str) -> None:
    net = Net(tiny({"go": "a -> b"}, {"a": 1}), watchdog=0.1)

    def dawdle(told: object) -> None:
        if not isinstance(told, Change) or told.event == "fire":
            gate.wait(SECONDS)

    if what == "selection":
        net.selection(dawdle)
    else:
        net.on_change(dawdle)

    with net:
        wait_until(lambda: net.status.state == "blocked")
        assert net.status.blocked is not None
        assert net.status.blocked.transition is None
        assert "dawdle" in net.status.blocked.handler
        gate.set()


def test_without_a_limit_nobody_is_named(gate: threading.Event, caplog: pytest.LogCaptureFixture) -> None:
    net = Net(tiny({"go": "a -> b"}, {"a": 1}), watchdog=None)
    assert net.watchdog is None
    net.handler("go")(lambda firing: print(gate.wait(0.5)))
    with net, caplog.at_level(logging.ERROR, "dineros"):
        net.wait_for(lambda state: state.count("b") == 1, SECONDS)
    assert caplog.text == ""


def test_a_node_ends_while_a_handler_blocks_it_and_its_firing_is_released(gate: threading.Event) -> None:
    net = Net(tiny({"go": "a -> b"}, {"a": 1}))
    recorder = ListRecorder()
    begun, over = threading.Event(), threading.Event()

    @net.handler("go")
    def hang(firing: Firing) -> dict[str, object]:
        begun.set()
        gate.wait(SECONDS)
        over.set()
        return {"count": 7}

    node = Node(net, recorder=recorder)
    node.start()
    assert begun.wait(SECONDS)
    (thread,) = [each for each in threading.enumerate() if each.name == "dineros node"]
    node.stop("told to", patience=0.2)
    (error,) = events(recorder, "error")
    assert (error["transition"], error["handler"], error["policy"]) == ("go", "hang", None)
    assert error["error"] == "did not return within 0.2 s when the node was stopped"
    assert [record["event"] for record in recorder.records][-1] == "stop"
    assert net.status.state == "ended"
    assert net.status.reason == "told to"
    gate.set()  # what it returns now counts no more
    assert over.wait(SECONDS)
    thread.join(SECONDS)
    assert not thread.is_alive()
    assert (net.count("a"), net.count("b"), events(recorder, "fire")) == (1, 0, [])


def test_a_handler_that_returns_in_time_is_waited_for() -> None:
    net = Net(tiny({"go": "a -> b"}, {"a": 1}))
    begun = threading.Event()

    @net.handler("go")
    def slow(firing: Firing) -> None:
        begun.set()
        time.sleep(0.3)

    node = Node(net)
    node.start()
    assert begun.wait(SECONDS)
    node.stop(patience=SECONDS)
    assert net.count("b") == 1


def test_a_watchdog_takes_seconds() -> None:
    with pytest.raises(DinerosError, match="must be above 0 s, not -1"):
        Net(tiny({"go": "a -> b"}), watchdog=-1)
