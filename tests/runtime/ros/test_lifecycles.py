"""Managed nodes on the real middleware: started in order, deactivated by others, killed, and conforming."""

from __future__ import annotations

from functools import partial

import pytest

from dineros.analysis.conformance import conform
from dineros.metamodel import sym
from dineros.metamodel.elements import find
from dineros.metamodel.files import save
from dineros.metamodel.lifecycles.start_order import manager_arguments
from dineros.metamodel.records import read_trace, traces_of_runs
from dineros.transformations.flattening.split import split
from tests.runtime.ros.conftest import Ros
from tests.runtime.ros.post import post

LETTERS = 6
CHANGE = """
import rclpy
from lifecycle_msgs.srv import ChangeState, GetState
from lifecycle_msgs.msg import Transition
rclpy.init()
node = rclpy.create_node("somebody")
def ask(kind, name, request):
    client = node.create_client(kind, name)
    assert client.wait_for_service(30)
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future, timeout_sec=30)
    return future.result()
def change(id):
    return ask(ChangeState, "/office/change_state", ChangeState.Request(transition=Transition(id=id))).success
def state(name):
    return ask(GetState, f"/{name}/get_state", GetState.Request()).current_state.label
"""


def managed(*, pauses: bool = False) -> sym.SystemModel:
    """Return the post office: the house is there before the office sends."""
    model = post(LETTERS)
    model.middleware = "ros2"
    model.channels.remove(model.channels[2])
    find(model, "house", sym.NodeNet).lifecycle = sym.Lifecycle(configureStep=1, activateStep=2)
    find(model, "office", sym.NodeNet).lifecycle = sym.Lifecycle(
        configureStep=3, activateStep=4, deactivates=True, pauses=pauses
    )
    return model


@pytest.mark.long
def test_started_in_order_deactivated_and_killed(ros: Ros) -> None:
    model = managed()
    for part in split(model):
        save(part, ros.folder / f"{part.node.id}.rtm.xmi")
    house = ros.node("house")
    office = ros.node("office")
    steps = manager_arguments(model)
    assert steps == ["configure:/house", "activate:/house", "configure:/office", "activate:/office"]
    said = ros.script(f"import sys\nfrom dineros.runtime.ros.bringup import main\nsys.exit(main({steps!r}))")
    assert said.splitlines() == [
        "/house is inactive",
        "/house is active",
        "/office is inactive",
        "/office is active",
    ]
    changes = [(each["label"], each["state"]) for each in ros.records("office", "lifecycle")]
    assert changes == [("configure", "inactive"), ("activate", "active")]

    # Deactivated by another program, what it publishes is lost: its net continues, its publisher does not.
    assert ros.script(CHANGE + "print(change(4), state('office'))") == "True inactive\n"
    assert ros.script(CHANGE + "print(change(1))") == "False\n"
    office.popen.kill()
    office.popen.wait()
    ros.processes.remove(office)
    office = ros.node("office", {"resume": True, "signals.Open": True})
    ros.wait(lambda: len(ros.records("office", "drop")) == LETTERS, "losing what is published while inactive")
    assert {each["queue"] for each in ros.records("office", "drop")} == {"inactive"}
    assert ros.script(CHANGE + "print(state('office'))") == "inactive\n"  # as it was when it was killed
    assert ros.records("office", "publish") == []
    assert ros.script(CHANGE + "print(change(3), state('office'))") == "True active\n"
    assert [process.interrupt() for process in (office, house)] == [0, 0]
    assert ros.records("house", "take") == []

    traces = {n: partial(read_trace, files) for n, files in traces_of_runs([ros.folder / "journal"]).items()}
    verdict = conform(model, traces)
    assert (verdict.status, verdict.violations, verdict.unknown) == ("conforms", [], [])


@pytest.mark.long
def test_what_is_published_while_active_arrives(ros: Ros) -> None:
    model = managed(pauses=True)
    for part in split(model):
        save(part, ros.folder / f"{part.node.id}.rtm.xmi")
    house = ros.node("house")
    office = ros.node("office", {"signals.Open": True, "expected_subscribers.Letters": 1})
    manager = ros.start("bringup", "-m", "dineros.runtime.ros.bringup", *manager_arguments(model))
    ros.wait(lambda: ros.records("house", "take"), "taking a letter")
    assert manager.popen.wait(30) == 0
    ros.wait(lambda: len(ros.records("office", "fire")) >= LETTERS, "sending")
    assert [process.interrupt() for process in (office, house)] == [0, 0]
    traces = {n: partial(read_trace, files) for n, files in traces_of_runs([ros.folder / "journal"]).items()}
    verdict = conform(model, traces)
    assert (verdict.status, verdict.violations) == ("conforms", [])


@pytest.mark.long
@pytest.mark.parametrize("number", ["SIGINT", "SIGTERM"])
def test_the_manager_is_told_to_end_while_it_waits(ros: Ros, number: str) -> None:
    said = ros.script(f"""
import os, signal, sys
from rclpy.client import Client
from dineros.runtime.ros import bringup

wait = Client.wait_for_service

def told(self, patience):
    os.kill(os.getpid(), signal.{number})
    return wait(self, patience)

Client.wait_for_service = told
print(bringup.main(["configure:/nobody"]))
""")
    assert said == "0\n"
