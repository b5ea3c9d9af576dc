"""Nodes in other processes are steered by their supervisor, whatever becomes of these processes."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.metamodel.files import save
from dineros.runtime import Net
from dineros.runtime.application.line import Line
from dineros.runtime.application.remote import SILENT, STARTING, RemoteNode
from dineros.runtime.application.steered import steered_over
from dineros.runtime.application.supervisor import (
    ProcessEvent,
    ProcessPlan,
    RestartPolicy,
    Supervisor,
)
from dineros.runtime.nodes.core import NOT_ACTIVE
from dineros.runtime.nodes.steering import Outlook, SteeredNet, SteeringError
from dineros.transformations.flattening.split import split
from tests.support.systems.talker import talker

PAUSED = Outlook("halted", "for a test", {"Button": True}, ["Say"])

NODE = """
import signal, sys, threading
from dineros.runtime import Net
from dineros.runtime.application.line import inherited_line
from dineros.runtime.application.steered import steered_over
from dineros.runtime.nodes.steering import SteeredNet
ending = threading.Event()
signal.signal(signal.SIGINT, lambda *_: ending.set())
net = Net.load("talker.rtm.xmi")
steered = SteeredNet(net)
with net, steered_over(inherited_line(), lambda: steered):
    ending.wait()
assert [each.name for each in threading.enumerate() if each.name == "dineros steering"] == []
"""


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lose patience soon with a process that does not answer."""
    monkeypatch.setattr("dineros.runtime.application.remote.PATIENCE", 1.0)


def until(condition: Callable[[], object], seconds: float = 60) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.02)


@contextlib.contextmanager
def supervised(folder: Path, program: str) -> Iterator[tuple[RemoteNode, Supervisor]]:
    """Run a program as the talker's process, and speak with it."""
    save(next(each for each in split(talker()) if each.node.id == "talker"), folder / "talker.rtm.xmi")
    remote, ended = RemoteNode("talker"), threading.Event()
    command = [sys.executable, "-P", "-c", program]
    plan = ProcessPlan(
        "talker", command, dict(os.environ), folder / "log", folder=folder, connect=remote.connect
    )
    with Supervisor([plan], RestartPolicy(delay=0.01), remote.tell) as supervisor:

        def look_after() -> None:
            while not ended.wait(0.02):
                supervisor.poll()

        thread = threading.Thread(target=look_after)
        thread.start()
        try:
            yield remote, supervisor
        finally:
            ended.set()
            thread.join()
    assert remote.look().state == "ended"


def test_a_process_is_steered_until_it_is_killed_and_its_successor_too(tmp_path: Path) -> None:
    with supervised(tmp_path, NODE) as (remote, supervisor):
        assert remote.look() == STARTING
        with pytest.raises(SteeringError, match="the process of talker is starting"):
            remote.pause("too early")
        until(lambda: remote.look() == Outlook("running", None, {"Button": False}, []))
        remote.pause("for a test")
        remote.set_signals({"Button": True}, "test")
        until(lambda: remote.look() == PAUSED)
        with pytest.raises(SteeringError, match="Butto"):
            remote.set_signals({"Butto": True}, "test")
        with pytest.raises(SteeringError, match="takes True or False"):
            remote.set_signals({"Button": 1}, "test")  # type: ignore[dict-item]
        os.kill(supervisor.processes["talker"], signal.SIGKILL)
        until(lambda: supervisor.restarts == 1)
        # It is another process: neither paused, nor, since it keeps no journal, with a signal that was set.
        until(lambda: remote.look() == Outlook("running", None, {"Button": False}, []))
        remote.pause("for a test")
        remote.set_signals({"Button": True}, "test")
        until(lambda: remote.look() == PAUSED)
        remote.proceed()
        until(lambda: remote.look() == Outlook("running", None, {"Button": True}, []))
    assert "Traceback" not in (tmp_path / "log").read_text()


def test_a_process_that_stands_still_keeps_nobody_waiting(tmp_path: Path) -> None:
    with supervised(tmp_path, NODE) as (remote, supervisor):
        until(lambda: remote.look().state == "running")
        process = supervisor.processes["talker"]
        os.kill(process, signal.SIGSTOP)
        try:
            until(lambda: Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] == "T")
            with pytest.raises(SteeringError, match=r"talker does not answer \(it may still carry it out\)"):
                remote.pause("for a test")
            for _ in range(1000):  # these are not even said: the first one is still to be answered
                with pytest.raises(SteeringError, match="has not answered the previous request"):
                    remote.proceed()
            until(lambda: remote.look() == SILENT)
        finally:
            os.kill(process, signal.SIGCONT)
        until(lambda: remote.look().state == "halted")
        remote.proceed()
        until(lambda: remote.look().state == "running")


GARBLING = """
import os, socket, time
end = socket.socket(fileno=int(os.environ["DINEROS_LINE"]))
end.recv(1000)
end.sendall(b'{"number": 1, "outlook": {"state": []}}\\n')
time.sleep(3600)
"""


def test_a_process_that_says_nonsense_is_no_longer_heard(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with supervised(tmp_path, GARBLING) as (remote, _):
        remote.look()
        until(lambda: remote.look() == SILENT)
        with pytest.raises(SteeringError, match="no longer answers"):
            remote.proceed()
        until(lambda: "talker can no longer be controlled: its process reports no answer" in caplog.text)


def test_how_a_process_ended_is_told() -> None:
    remote = RemoteNode("talker")
    ours, theirs = socket.socketpair()
    with theirs:
        remote.connect(ours)
        remote.tell(ProcessEvent(0.0, "talker", "started", 7))
        assert remote.look() == STARTING
        remote.tell(ProcessEvent(0.0, "talker", "failed", 7, 3, "no hand"))
        assert remote.look() == Outlook("crashed", "exit status 3: no hand")
        with pytest.raises(SteeringError, match="the process of talker is crashed"):
            remote.pause("for a test")
        assert theirs.recv(100).startswith(b'{"number": 1, "ask": "look"}')
        assert theirs.recv(100) == b""  # also where a child of the process has kept its end
    remote.tell(ProcessEvent(0.0, "talker", "stopped", 7, -2))
    assert remote.look() == Outlook("ended", "signal SIGINT")


def test_a_managed_node_that_is_not_configured_is_not_active() -> None:
    remote = RemoteNode("talker")
    ours, theirs = socket.socketpair()
    remote.connect(ours)
    with steered_over(Line(theirs), lambda: None):
        until(lambda: remote.look() == Outlook("halted", NOT_ACTIVE))
        with pytest.raises(SteeringError, match=f"{NOT_ACTIVE} .activate it"):
            remote.proceed()
    until(lambda: remote.look() == SILENT)
    with steered_over(None, lambda: None):  # started by hand
        pass


def test_a_node_with_very_much_to_tell_says_how_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dineros.runtime.application.line.LONGEST", 150)
    net = Net(next(each for each in split(talker()) if each.node.id == "talker"))
    monkeypatch.setattr("dineros.runtime.nodes.steering.enabled", lambda core: ["Say"] * 100)
    steered, remote = SteeredNet(net), RemoteNode("talker")
    ours, theirs = socket.socketpair()
    remote.connect(ours)
    with steered_over(Line(theirs), lambda: steered):
        until(lambda: remote.look() == Outlook("running"))
    remote.close()


class Echo:
    """The other end of a line, which answers with what a test wants."""

    def __init__(self, answers: list[bytes]) -> None:
        self.ours, self.theirs = socket.socketpair()
        self._answers = answers
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        with self.theirs, contextlib.suppress(OSError):
            for answer in self._answers:
                if not self.theirs.recv(10_000):
                    return
                self.theirs.sendall(answer + b"\n")

    def join(self) -> None:
        self._thread.join(20)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(max_size=9),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=9), inner, max_size=3),
    max_leaves=5,
)
OUTLOOKS = st.fixed_dictionaries(
    {},
    optional={"state": JSON, "reason": JSON, "signals": JSON, "enabled": JSON},
)


@given(OUTLOOKS | JSON, st.integers(1, 2) | JSON)
@settings(max_examples=60, deadline=None)
def test_whatever_a_process_says_is_an_outlook_or_none(outlook: object, number: object) -> None:
    echo = Echo([json.dumps({"number": number, "outlook": outlook}).encode()])
    remote = RemoteNode("talker")
    remote.connect(echo.ours)
    try:
        until(lambda: remote.look() != STARTING or outlook == {"state": "starting"})
        seen = remote.look()
        assert isinstance(seen.state, str)
        assert seen.signals is None or all(isinstance(value, bool) for value in seen.signals.values())
        assert seen.enabled is None or all(isinstance(each, str) for each in seen.enabled)
    finally:
        remote.close()
        echo.join()
