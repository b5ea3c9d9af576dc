"""The timers of a node on ROS are those of rclpy, and their periods are parameters."""

from __future__ import annotations

import pytest

from tests.runtime.ros.channels.test_simulated_time import put_heart
from tests.runtime.ros.conftest import PATIENCE, Ros

HEART = """
import time
from rclpy.parameter import Parameter
from dineros.runtime import Net
from dineros.runtime.ros.running import RosNode
arguments = ["--ros-args", "-p", "periods.OnTimer:=2", "-p", "diagnostics_period:=0.0"]
heart = RosNode(Net.load("heart.rtm.xmi"), arguments=arguments)
node = heart.session.node
own = set(node.timers)
"""
"""Under way, its period an integer: nobody writes the point."""


def test_a_timer_of_the_model_is_one_of_rclpy(ros: Ros) -> None:
    """On the clock of the node; what ticks while a handler keeps the node is gone, but for one tick."""
    put_heart(ros, 300.0)
    ros.script(
        HEART + "is_over = False\n"
        "@heart.net.handler('Beat')\n"
        "def keep(firing):\n"
        "    global is_over\n"
        "    end = time.monotonic() + 0.3\n"
        "    while firing.memory.value('beats', 0) == 0 and time.monotonic() < end:\n"
        "        time.sleep(0.01)\n"
        "    firing.memory['beats'] = firing.memory.value('beats', 0) + 1\n"
        "heart.open()\n"
        "(timer,) = [each for each in node.timers if each not in own]\n"
        "assert timer.clock is node.get_clock()\n"
        "assert timer.timer_period_ns == 2 * 10**9\n"
        "assert node.get_parameter('periods.OnTimer').value == 2.0\n"
        "(result,) = node.set_parameters([Parameter('periods.OnTimer', value=9.0)])\n"
        "assert not result.successful and 'read-only' in result.reason, result.reason\n"
        "assert heart.net.next_timer is None\n"
        "timer.timer_period_ns = 20 * 10**6\n"
        "begun = time.monotonic()\n"
        "heart.session.start(heart.work)\n"
        "state = heart.net.wait_for(lambda state: state.firings >= 4, 50)\n"
        "assert state.firings <= 1 + (time.monotonic() - begun - 0.3) / 0.02, state.firings\n"
        "heart.stop()\n"
        "assert timer not in node.timers\n"
    )


def test_a_period_is_a_positive_number(ros: Ros) -> None:
    put_heart(ros)
    said = ros.script(
        "from dineros.runtime import Net\n"
        "from dineros.runtime.ros.process.session import RosError\n"
        "from dineros.runtime.ros.running import RosNode\n"
        "for period in ('0', '-0.5', '.nan', '.inf', '1e-12', 'true', '[1.0]'):\n"
        "    arguments = ['--ros-args', '-p', f'periods.OnTimer:={period}']\n"
        "    try:\n"
        "        RosNode(Net.load('heart.rtm.xmi'), arguments=arguments).start()\n"
        "    except RosError as error:\n"
        "        print(error)\n"
    )
    lines = said.splitlines()
    assert len(lines) == 7
    assert {line.partition(":")[0] for line in lines} == {
        "the parameter periods.OnTimer cannot have the given value"
    }


def test_a_period_that_is_none_ends_the_process(ros: Ros) -> None:
    put_heart(ros)
    node = ros.node("heart", {"periods.OnTimer": "often"})
    assert node.popen.wait(PATIENCE) == 2
    assert len(node.output().splitlines()) == 1
    ros.processes.remove(node)


@pytest.mark.long
def test_the_timers_of_a_managed_node_come_back_with_it(ros: Ros) -> None:
    put_heart(ros, 0.05)
    heart = ros.node("heart", options=["--lifecycle"])
    known: list[object] = []

    def has_beaten() -> bool:
        return len(ros.fired("heart", "Beat")) >= len(known) + 2

    for _ in range(2):
        known[:] = ros.fired("heart", "Beat")
        ros.script(MANAGER.format(changes=(1, 3)))  # configure, activate
        ros.wait(has_beaten, "beating")
        ros.script(MANAGER.format(changes=(4, 2)))  # deactivate, clean up
        assert ros.records("heart")[-1]["event"] == "stop"
    assert heart.interrupt() == 0


MANAGER = """
import rclpy
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
rclpy.init()
node = rclpy.create_node("manager")
client = node.create_client(ChangeState, "/heart/change_state")
assert client.wait_for_service(30)
for number in {changes}:
    future = client.call_async(ChangeState.Request(transition=Transition(id=number)))
    rclpy.spin_until_future_complete(node, future, timeout_sec=30)
    assert future.result().success
rclpy.shutdown()
"""
