"""A run is steered from its live page: signals are set, nodes paused; what strangers say changes nothing."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from websockets.sync.client import connect
from websockets.typing import Origin

from dineros.metamodel import sym
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.elements import find
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.firing.handlers import Firing
from dineros.runtime.journal.recorder import JournalRecorder
from dineros.runtime.nodes.steering import Outlook, SteeredNet
from dineros.transformations.flattening.split import split
from dineros.views.live.steering import Steering
from dineros.views.serving.handle import PageHandle
from tests.support.systems.talker import talker
from tests.views.browser import Visit, wait_until

NewVisit = Callable[..., Visit]
Serve = Callable[..., PageHandle]


@pytest.fixture
def application(tmp_path: Path) -> Iterator[LocalApplication]:
    """Return the talker's nodes, running on threads, recorded below `tmp_path`."""
    made = LocalApplication(
        split(talker()),
        seed=1,
        recorder=lambda node: JournalRecorder(tmp_path / "run", node),
        simulated_time=False,
    )
    with made:
        yield made


def until(condition: Callable[[], bool]) -> None:
    for _ in range(400):
        if condition():
            return
        time.sleep(0.025)
    raise AssertionError("it did not happen")


def test_signals_pausing_and_refusals(application: LocalApplication) -> None:
    steering = Steering()
    steering.take({node: SteeredNet(net) for node, net in application.nets.items()})
    talks = application.nets["talker"]
    assert steering.hear('{"ask":"pause","node":"talker"}') is None
    until(lambda: talks.status.state == "halted")
    assert steering.hear('{"ask":"signal","node":"talker","signal":"Button","value":true}') is None
    until(lambda: talks.inspect().signals["Button"])
    assert application.count("talker", "Words") == 3  # it is paused
    paused = {
        "node": "talker",
        "state": "halted",
        "reason": "paused on the live page",
        "signals": {"Button": True},
        "enabled": ["Say"],
    }
    until(lambda: paused in steering.nodes())
    assert steering.hear('{"ask":"proceed","node":"talker"}') is None
    until(lambda: application.count("listener", "Noted") == 3)
    for wrong in (
        "",
        "[]",
        '{"ask":"pause"}',
        '{"ask":"pause","node":"nobody"}',
        '{"ask":"pause","node":"talker","x":1}',
        '{"ask":"signal","node":"talker","signal":"Butto","value":true}',
        '{"ask":"signal","node":"talker","signal":"Button","value":"yes"}',
        '{"ask":"signal","node":"talker","signal":1,"value":true}',
    ):
        answer = steering.hear(wrong)
        assert answer is not None and json.loads(answer)["type"] == "refused", wrong
        assert "unexpected" not in answer, answer


@given(st.recursive(st.none() | st.booleans() | st.integers() | st.text(max_size=9), st.lists, max_leaves=4))
@settings(max_examples=50)
def test_nothing_that_is_said_raises_anything(said: Any) -> None:
    answer = Steering().hear(json.dumps({"ask": said, "node": said}))
    assert answer is not None and "unexpected" not in answer


def test_a_blocked_node_keeps_nobody_waiting(
    application: LocalApplication, tmp_path: Path, serve: Serve
) -> None:
    release, begun = threading.Event(), threading.Event()

    @application.nets["listener"].handler("Listen")
    def listen(firing: Firing) -> None:
        begun.set()
        release.wait(20)

    steering = Steering()
    steering.take({node: SteeredNet(net) for node, net in application.nets.items()})
    handle = serve(tmp_path / "run", talker(), steering=steering)
    origin = handle.url.split("/?")[0]
    address = handle.url.replace("http", "ws", 1).replace("/?", "/changes?")
    try:
        with connect(address, origin=Origin(origin), max_size=1 << 24) as socket:
            socket.send('{"ask":"signal","node":"talker","signal":"Button","value":true}')
            assert begun.wait(10)
            socket.send('{"ask":"pause","node":"listener"}')
            socket.send("nonsense")
            while json.loads(socket.recv(timeout=20))["type"] != "refused":
                pass
        handle.stop()
    finally:
        release.set()


class Slow:
    """A node that takes its time to pause, and counts who looks at it."""

    def __init__(self) -> None:
        self.looks = 0
        self.begun, self.release = threading.Event(), threading.Event()

    def look(self) -> Outlook:
        self.looks += 1
        return Outlook("running", None, {}, [])

    def set_signals(self, values: Mapping[str, bool | str], source: str) -> None:
        raise AssertionError("nobody asks for that")

    def pause(self, reason: str) -> None:
        self.begun.set()
        self.release.wait(20)

    def proceed(self) -> None:
        raise AssertionError("nobody asks for that")


def test_nodes_are_looked_at_only_while_a_page_is_open() -> None:
    node, told = Slow(), threading.Event()
    for is_watched in (False, True):
        steering = Steering()
        steering.take({"slow": node})
        steering.begin(lambda message: told.set())
        if is_watched:
            steering.watched(True)
            assert told.wait(20)
        steering.end()
        assert steering._thread is not None
        steering._thread.join(20)
        assert not steering._thread.is_alive()
        assert (node.looks > 0) == is_watched


def test_a_node_that_takes_its_time_keeps_no_other_page_waiting(tmp_path: Path, serve: Serve) -> None:
    """Nor the server: the thread that tells pages what is new does not wait for the node."""
    node, steering = Slow(), Steering()
    steering.take({"slow": node})
    handle = serve(tmp_path / "run", talker(), steering=steering)
    origin = handle.url.split("/?")[0]
    address = handle.url.replace("http", "ws", 1).replace("/?", "/changes?")
    try:
        with (
            connect(address, origin=Origin(origin), max_size=1 << 24) as one,
            connect(address, origin=Origin(origin), max_size=1 << 24) as other,
        ):
            one.send('{"ask":"pause","node":"slow"}')
            assert node.begun.wait(20)
            other.send('{"ask":"pause","node":"nobody"}')
            while json.loads(other.recv(timeout=20))["type"] != "refused":
                pass
    finally:
        node.release.set()


def test_a_run_is_steered_on_its_page(
    application: LocalApplication, tmp_path: Path, visit: NewVisit, serve: Serve
) -> None:
    steering = Steering()
    steering.take({node: SteeredNet(net) for node, net in application.nets.items()})
    handle = serve(tmp_path / "run", talker(), steering=steering)
    one = visit()
    page = one.page
    page.goto(handle.url)
    wait_until(page, "document.querySelector('#steer [data-node=talker]')")
    page.get_by_role("button", name="Pause listener").click()
    page.get_by_role("button", name="Proceed listener").wait_for()
    page.evaluate("globalThis.pressed = document.querySelector('#steer [data-node=listener] button')")
    page.get_by_role("switch", name="Button: false").focus()
    page.keyboard.press("Enter")
    page.get_by_role("switch", name="Button: true").wait_for()
    assert page.evaluate("document.activeElement.textContent") == "Button: true"
    until(lambda: application.count("listener", "Heard") == 3)
    wait_until(page, "document.querySelector('#steer [data-node=listener]').textContent.includes('Listen')")
    # What is pressed stays the same button while the node changes: otherwise there is no click.
    assert page.evaluate("pressed.isConnected")
    page.get_by_role("button", name="Proceed listener").click()
    until(lambda: application.count("listener", "Noted") == 3)
    assert one.problems == []


def test_the_value_of_a_signal_is_chosen_from_a_list(tmp_path: Path, visit: NewVisit, serve: Serve) -> None:
    model = talker()
    values = [sym.SignalValue(name=each) for each in ("mute", "low", "loud")]
    find(model, "talker", sym.NodeNet).signals.append(sym.InputSignal(id="Mode", values=values))
    set_clause(find(model, "Say", sym.Transition), "!Button & Mode = 'loud'")
    made = LocalApplication(
        split(model),
        seed=1,
        recorder=lambda node: JournalRecorder(tmp_path / "run", node),
        simulated_time=False,
    )
    steering = Steering()
    steering.take({node: SteeredNet(net) for node, net in made.nets.items()})
    with made:
        handle = serve(tmp_path / "run", model, steering=steering)
        one = visit()
        page = one.page
        page.goto(handle.url)
        mode = page.get_by_label("Mode")
        mode.wait_for()
        assert mode.input_value() == "mute"
        assert mode.locator("option").all_inner_texts() == ["mute", "low", "loud"]
        made.nets["talker"].signal("Mode").set("low")
        wait_until(page, "document.querySelector('#steer select').value === 'low'")
        mode.select_option("loud")
        until(lambda: made.count("listener", "Noted") == 3)
        refused = steering.hear('{"ask":"signal","node":"talker","signal":"Mode","value":"shrill"}')
        assert refused is not None and "shrill" in refused
        assert made.nets["talker"].signal("Mode").value == "loud"
    assert one.problems == []
