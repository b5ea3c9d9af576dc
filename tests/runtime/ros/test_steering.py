"""A managed node on real ROS 2 is steered by its supervisor, and proceeds only while it is active."""

from __future__ import annotations

import sys

import pytest

from dineros.runtime.application.remote import RemoteNode
from dineros.runtime.application.supervisor import ProcessPlan, Supervisor
from dineros.runtime.nodes.core import NOT_ACTIVE
from dineros.runtime.nodes.steering import Outlook, SteeringError
from dineros.runtime.ros.control import INACTIVE
from tests.runtime.ros.conftest import Ros

CHANGE = """
import rclpy
from lifecycle_msgs.srv import ChangeState
from lifecycle_msgs.msg import Transition
rclpy.init()
node = rclpy.create_node("manager")
client = node.create_client(ChangeState, "/office/change_state")
assert client.wait_for_service(60)
future = client.call_async(ChangeState.Request(transition=Transition(id={id})))
rclpy.spin_until_future_complete(node, future, timeout_sec=60)
assert future.result().success
rclpy.shutdown()
"""
CONFIGURE, ACTIVATE, DEACTIVATE = 1, 3, 4


@pytest.mark.long
def test_a_managed_node_proceeds_only_while_it_is_active(ros: Ros) -> None:
    """Also where it was paused before it was deactivated; activating it lets it continue."""
    command = [sys.executable, "-P", "-m", "dineros.runtime.ros.node_main", "office.rtm.xmi", "--lifecycle"]
    parameters = ["--ros-args", "-p", "expected_subscribers.Letters:=1"]
    remote = RemoteNode("office")
    plan = ProcessPlan(
        "office",
        [*command, *parameters],
        ros.environment,
        ros.folder / "log",
        folder=ros.folder,
        connect=remote.connect,
    )
    shut = {"Open": False, "too-late": False}

    def refuses() -> None:
        with pytest.raises(SteeringError, match=f"{NOT_ACTIVE} .activate it"):
            remote.proceed()

    with Supervisor([plan], on_event=remote.tell):
        ros.wait(lambda: remote.look() == Outlook("halted", NOT_ACTIVE), "starting")
        refuses()
        ros.script(CHANGE.format(id=CONFIGURE))
        ros.wait(lambda: remote.look() == Outlook("halted", INACTIVE, shut, []), "configuring")
        refuses()
        ros.script(CHANGE.format(id=ACTIVATE))
        ros.wait(lambda: remote.look() == Outlook("running", None, shut, []), "activating")
        remote.pause("for a test")
        remote.set_signals({"Open": True}, "test")
        paused = Outlook("halted", "for a test", {"Open": True, "too-late": False}, ["TSend"])
        ros.wait(lambda: remote.look() == paused, "pausing")
        ros.script(CHANGE.format(id=DEACTIVATE))
        refuses()
        assert remote.look().state == "halted"
        ros.script(CHANGE.format(id=ACTIVATE))
        ros.wait(lambda: remote.look().state == "running", "activating it again")
    assert remote.look().state == "ended"
