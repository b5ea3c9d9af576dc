"""Types of ports against the interface files of folders."""

from __future__ import annotations

from pathlib import Path

from dineros.observation.findings.interfaces import missing_types, unchecked_types
from dineros.sources.reading import read_source

NODE = """
import rclpy
from rclpy.node import Node
from arm_msgs.msg import Pose, Posture
from far_msgs.msg import Away
from std_msgs.msg import String

rclpy.init()
node = Node("arm")
node.create_publisher(Pose, "pose", 1)
node.create_publisher(Posture, "posture", 1)
node.create_publisher(Away, "away", 1)
node.create_publisher(String, "text", 1)
rclpy.spin(node)
"""
CPP = """
#include <arm_msgs/srv/grip.hpp>
int main() {
  auto node = std::make_shared<rclcpp::Node>("hand");
  auto a = node->create_client<arm_msgs::srv::Grip>("grip");
  auto b = node->create_client<arm_msgs::srv::Grab>("grab");
  rclcpp::spin(node);
}
"""


def test_a_type_that_its_package_does_not_have_is_found(tmp_path: Path) -> None:
    code, msgs = tmp_path / "code", tmp_path / "arm_msgs"
    for folder in (code, msgs / "msg", msgs / "srv"):
        folder.mkdir(parents=True)
    (code / "arm.py").write_text(NODE)
    (code / "hand.cpp").write_text(CPP)
    (msgs / "package.xml").write_text("<package><name>arm_msgs</name></package>")
    (msgs / "msg" / "Pose.msg").write_text("float64 x\n")
    (msgs / "srv" / "Grip.srv").write_text("---\nbool success\n")
    read = [("code", read_source(code)), ("arm_msgs", read_source(msgs))]
    found = missing_types(read)
    assert [(each.severity, each.lines[0], each.elements[1]) for each in found] == [
        ("warning", "code/arm.py:11", "arm_msgs/msg/Posture"),
        ("warning", "code/hand.cpp:6", "arm_msgs/srv/Grab"),
    ]
    assert found[0].message == (
        "posture of arm has the type arm_msgs/msg/Posture: the package arm_msgs has no message Posture "
        "(did you mean 'arm_msgs/msg/Pose'?)"
    )
    assert unchecked_types(read) == [
        "code/arm.py:12: far_msgs/msg/Away is not checked: no file in the folder defines far_msgs/msg/Away, "
        "and the package far_msgs is not installed"
    ]
    alone = [("code", read[0][1])]
    assert missing_types(alone) == []
    assert [line.split(":")[1] for line in unchecked_types(alone)] == ["10", "11", "6", "5", "12"]
