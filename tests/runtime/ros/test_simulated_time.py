"""Nodes go by the time of a simulation where they are told to."""

from __future__ import annotations

from dineros.metamodel import sym
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
for seconds in range(1000, 4001, 100):
    message.clock.sec = seconds
    publisher.publish(message)
    time.sleep(0.05)
node.destroy_node()
rclpy.shutdown()
"""


def test_a_timer_callback_goes_by_the_clock_of_a_simulation(ros: Ros) -> None:
    beats = sym.Place(id="Beats")
    beat = sym.Transition(id="Beat")
    page = sym.CallbackPage(id="OnTimer", kind="timer", timer=300.0, objects=[beat, beats])
    flow(beat, beats)
    (part,) = split(sym.SystemModel(id="heart", pages=[sym.NodeNet(id="heart", objects=[page])]))
    save(part, ros.folder / "heart.rtm.xmi")
    heart = ros.node("heart", {"use_sim_time": True})
    ros.script(SIMULATION)  # 3000 s in a second or two
    ros.wait(lambda: len(ros.fired("heart", "Beat")) >= 8, "beating")
    assert heart.interrupt() == 0
    assert len(ros.fired("heart", "Beat")) <= 11
