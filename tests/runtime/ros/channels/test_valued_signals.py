"""A signal with values in ROS: by its topic, by the topic of all signals, and by parameters."""

from __future__ import annotations

import json

from tests.runtime.ros.conftest import Ros

SCRIPT = """
import json, time
import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from dineros.metamodel.errors import DinerosError
from dineros.runtime.nets.ports import SignalPort
from dineros.runtime.ros.channels.signals import RosSignals

class Source:
    refused = []
    def connected(self, is_so): pass
    def accept(self): pass
    def refuse(self, what, error): self.refused.append(f"{what}: {error}")

class Receiver:
    got, expected = [], []
    def source(self, name): return Source()
    def remove_source(self, source): pass
    def signals_changed(self, values, source): self.got.append([values, source])
    def signal_expected(self, signal, expected): self.expected.append([signal, expected.then])

mode = SignalPort("Mode", "Mode", "idle", ("idle", "moving", "broken"))
signals = [mode, SignalPort("Open", "Open", False)]
given = ["signals.Mode:=moving", "stale_after.Mode:=5.0", "when_stale.Mode:=broken"]
rclpy.init(args=["--ros-args", *(word for each in given for word in ("-p", each))])
node, other, receiver = rclpy.create_node("mill"), rclpy.create_node("other"), Receiver()
open_signals = RosSignals(node, signals, receiver)
latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
one, both = (other.create_publisher(String, f"/mill/signals{end}", latched) for end in ("/Mode", ""))
words = [(one, "broken"), (one, "nonsense"), (both, '{"Mode": "idle", "Open": true}')]
seen, end = 1, time.monotonic() + 60
while time.monotonic() < end and (words or len(receiver.got) < 3):
    if words and one.get_subscription_count() and both.get_subscription_count():
        if len(receiver.got) + len(Source.refused) == seen:
            publisher, word = words.pop(0)
            publisher.publish(String(data=word))
            seen += 1
    rclpy.spin_once(node, timeout_sec=0.05)
names = [name for name, _ in node.get_service_names_and_types() if "set_signal" in name]
print(json.dumps([receiver.got, receiver.expected, Source.refused, names]))
open_signals.close()
rclpy.shutdown()
"""


def test_values_by_topics_and_parameters(ros: Ros) -> None:
    got, expected, refused, services = json.loads(ros.script(SCRIPT).splitlines()[-1])
    assert got == [
        [{"Mode": "moving"}, "parameter"],
        [{"Mode": "broken"}, "topic"],
        [{"Mode": "idle", "Open": True}, "topic"],
    ]
    assert expected == [["Mode", "broken"]]
    assert refused == ["~/signals/Mode: 'nonsense' is not one of its values (send idle or moving or broken)"]
    assert services == ["/mill/set_signal/Open"]
