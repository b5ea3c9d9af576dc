"""Nodes go by the time of a simulation where they are told to; what was lost on the way does not."""

from __future__ import annotations

import pytest

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from dineros.metamodel.files import save
from dineros.transformations.flattening.split import split
from tests.runtime.ros.conftest import Ros

SIMULATION = """
import time
import rclpy
from rosgraph_msgs.msg import Clock
rclpy.init()
node = rclpy.create_node("simulation")
publisher = node.create_publisher(Clock, "/clock", 10)
while not publisher.get_subscription_count():
    time.sleep(0.01)
message = Clock()
for seconds in (*range(1000, 4001, 100), *range(0, 2001, 100)):
    message.clock.sec = seconds
    publisher.publish(message)
    time.sleep(0.05)
node.destroy_node()
rclpy.shutdown()
"""


def heart(period: float = 300.0) -> sym.SystemModel:
    """Return a node that beats in the callback of a timer, and rests for as long after each beat."""
    beat, beats, rest = sym.Transition(id="Beat"), sym.Place(id="Beats"), sym.Transition(id="Rest")
    page = sym.CallbackPage(id="OnTimer", kind="timer", timer=period, objects=[beat, beats])
    rested = sym.Place(id="Rested")
    page.objects.extend([rest, rested])
    flow(beat, beats, rest, rested)
    rest.interval = pn.TimeInterval(earliest=period)
    return sym.SystemModel(id="heart", pages=[sym.NodeNet(id="heart", objects=[page])])


def put_heart(ros: Ros, period: float = 300.0) -> None:
    (part,) = split(heart(period))
    save(part, ros.folder / "heart.rtm.xmi")


@pytest.mark.long
def test_timers_and_intervals_go_by_the_clock_of_a_simulation(ros: Ros) -> None:
    """Also when the simulation begins again."""
    put_heart(ros)
    node = ros.node("heart", {"use_sim_time": True})
    ros.script(SIMULATION)  # 3000 s in a second or two, and 2000 s of the simulation that begins again
    ros.wait(lambda: len(ros.fired("heart", "Beat")) >= 13, "beating")
    ros.wait(lambda: len(ros.fired("heart", "Rest")) >= 12, "resting")
    assert node.interrupt() == 0
    # 1000 s pass at once, before the first message: one tick, as missed ones are gone.
    assert len(ros.fired("heart", "Beat")) <= 18


@pytest.mark.long
def test_while_time_stands_still_no_timer_ticks_and_requests_time_out(ros: Ros) -> None:
    """Nobody publishes `/clock`; that nobody answers is a matter of the machine's time."""
    put_heart(ros, 0.01)
    node = ros.node("heart", {"use_sim_time": True})
    desk = ros.node("desk", {"use_sim_time": True, "request_timeout": 0.1})
    ros.wait(lambda: any(each["attempt"] == 4 for each in ros.records("desk", "timeout")), "asking again")
    ros.wait(lambda: ros.records("heart", "start"), "the heart")
    assert desk.interrupt() == 0
    assert node.interrupt() == 0
    assert not ros.records("heart", "fire")


def test_the_clock_is_chosen_at_the_start(ros: Ros) -> None:
    put_heart(ros)
    said = ros.script(
        "from rclpy.parameter import Parameter\n"
        "from dineros.runtime import Net\n"
        "from dineros.runtime.ros.running import RosNode\n"
        "with RosNode(Net.load('heart.rtm.xmi')) as heart:\n"
        "    for value in (False, True):\n"
        "        (result,) = heart.session.node.set_parameters([Parameter('use_sim_time', value=value)])\n"
        "        print(result.successful, result.reason)\n"
        "    print(heart.session.node.get_clock().ros_time_is_active)\n"
    )
    assert said == "True \nFalse use_sim_time can be set at the start only\nFalse\n"
