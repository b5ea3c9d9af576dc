"""Quality of service in Python that a program changes after it is made."""

from __future__ import annotations

from pathlib import Path
from textwrap import indent

import pytest

from dineros.sources.reading import read_source
from tests.sources.support import facts_of, node_of

PROGRAM = """
import copy
import rclpy
from rclpy.node import Node
from rclpy.qos import QoSPresetProfiles, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from std_msgs.msg import String

def weaken(qos):
    qos.reliability = ReliabilityPolicy.BEST_EFFORT

class Robot(Node):
    def __init__(self):
        super().__init__("robot")
BODY
        self.out = self.create_publisher(String, "out", qos)
    def weaken(self): pass
    def is_lossy(self): return self.get_parameter("lossy").value

rclpy.init()
rclpy.spin(Robot())
"""
LOSSY = "open: reliable or best_effort"
MADE = "qos = QoSProfile(depth=4)\n"
BEST = "qos.reliability = ReliabilityPolicy.BEST_EFFORT"
COPY = "other = copy.deepcopy(qos_profile_sensor_data)\nother.depth = 3\n"


@pytest.mark.parametrize(
    ("body", "found"),
    [
        (f"{MADE}weaken(qos)", (4, "best_effort")),
        (f"{MADE}if self.is_lossy(): weaken(qos)", (4, LOSSY)),
        (f"{MADE}if self.is_lossy(): {BEST}", (4, LOSSY)),
        (f"{MADE}if False: weaken(qos)", (4, "reliable")),
        (f"{MADE}for each in self.is_lossy(): weaken(qos)", (4, LOSSY)),
        (f"{MADE}if self.is_lossy(): weaken(qos)\nweaken(qos)", (4, "best_effort")),
        (f"{MADE}if self.is_lossy(): qos.depth = 4", (4, "reliable")),
        ("qos = QoSPresetProfiles.SENSOR_DATA.value\nqos.depth = 3", (3, "best_effort")),
        ("qos = copy.deepcopy(qos_profile_sensor_data)\nqos.depth = 3", (3, "best_effort")),
        (f"{COPY}qos = qos_profile_sensor_data", (5, "best_effort")),
    ],
)
def test_a_quality_is_that_of_the_last_change(tmp_path: Path, body: str, found: tuple[int, str]) -> None:
    """The method `weaken` of the class is not what the name `weaken` means in its methods."""
    (tmp_path / "robot.py").write_text(PROGRAM.replace("BODY", indent(body, " " * 8)))
    (node,) = read_source(tmp_path).nodes
    (entity,) = node.of("publishers")
    assert (entity.details["depth"], entity.details["reliability"]) == found


def test_what_a_branch_makes_is_certain_in_it(tmp_path: Path) -> None:
    made = "    qos = QoSProfile(depth=2)\n    weaken(qos)\n    self.create_publisher(String, 'a', qos)"
    body = f"if self.is_lossy():\n{made}\nqos = 5"
    (tmp_path / "robot.py").write_text(PROGRAM.replace("BODY", indent(body, " " * 8)))
    (node,) = read_source(tmp_path).nodes
    assert [(each.name, each.details["reliability"]) for each in node.of("publishers")] == [
        ("a", "best_effort"),
        ("out", "reliable"),
    ]


def test_methods_do_not_see_the_names_of_their_class(tmp_path: Path) -> None:
    """A function of the module has the name of a method, and a constant that of an attribute."""
    (tmp_path / "robot.py").write_text(
        """
import rclpy
from rclpy.node import Node
from std_msgs.msg import String
TOPIC = "outer"
def name(): return "function"
class Robot(Node):
    TOPIC = "inner"
    def __init__(self):
        super().__init__("robot")
        self.a = self.create_publisher(String, TOPIC, 1)
        self.b = self.create_publisher(String, name(), 1)
        self.c = self.create_publisher(String, self.TOPIC, 1)
        self.d = self.create_publisher(String, self.name(), 1)
        self.e = [self.create_publisher(String, each + TOPIC, 1) for each in ("my_",)]
    def name(self): return "method"
rclpy.init()
rclpy.spin(Robot())
"""
    )
    (node,) = read_source(tmp_path).nodes
    assert [each.name for each in node.of("publishers")] == [
        "outer",
        "function",
        "inner",
        "method",
        "my_outer",
    ]


BRANCHES = """
import rclpy
from rclpy.node import Node
from std_msgs.msg import String

class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.topic = "start"
BODY
        self.make("last_" + self.topic)
    def make(self, name): self.out = self.create_publisher(String, name, 1)
    def is_lossy(self): return self.get_parameter("lossy").value
    def change(self):
        self.topic = "b"

rclpy.init()
rclpy.spin(Robot())
"""


@pytest.mark.parametrize(
    ("body", "found"),
    [
        (
            "if self.is_lossy():\n    self.topic = 'a'\n    self.make(self.topic)\n"
            "    self.change()\n    self.make(self.topic)",
            ["a", "b", "last_start", "last_b"],
        ),
        (
            "if self.is_lossy():\n    self.topic = 'a'\nelse:\n    self.make(self.topic)",
            ["start", "last_start", "last_a"],
        ),
        (
            "if self.is_lossy():\n    self.topic = 'a'\nelif self.is_lossy():\n    self.change()\nelse:\n"
            "    self.topic = 'c'",
            ["last_a", "last_b", "last_c"],
        ),
        (
            "if self.is_lossy():\n    if self.is_lossy():\n        self.topic = 'a'\n"
            "    self.make(self.topic)",
            ["start", "a", "last_start", "last_a"],
        ),
        (
            "if self.is_lossy():\n    self.other = 'a'\nelse:\n    self.other = 'b'\n"
            "    self.make(self.other)",
            ["b", "last_start"],
        ),
        (
            "match self.is_lossy():\n    case 1:\n        self.topic = 'a'\n        self.make(self.topic)",
            ["a", "last_start", "last_a"],
        ),
        (
            "if self.declare_parameter('more', True).value:\n    self.topic = 'a'\n    self.make(self.topic)",
            ["a", "last_a"],
        ),
    ],
)
def test_what_a_branch_sets_is_known_in_it(tmp_path: Path, body: str, found: list[str]) -> None:
    """Afterwards, the attribute has that value or the one from before."""
    (tmp_path / "robot.py").write_text(BRANCHES.replace("BODY", indent(body, " " * 8)))
    (node,) = read_source(tmp_path).nodes
    assert [each.name for each in node.of("publishers")] == found


def test_what_is_set_after_a_return_in_a_branch_may_not_be_set(tmp_path: Path) -> None:
    """The routine ends before, so both values are possible after it."""
    text = BRANCHES.replace('self.topic = "b"', 'if self.is_lossy(): return\n        self.topic = "b"')
    (tmp_path / "robot.py").write_text(text.replace("BODY", "        self.change()"))
    (node,) = read_source(tmp_path).nodes
    assert [each.name for each in node.of("publishers")] == ["last_start", "last_b"]


@pytest.mark.parametrize(
    ("default", "found"),
    [
        ("QoSReliabilityPolicy.BEST_EFFORT", "best_effort"),
        ("ReliabilityPolicy.RELIABLE.value", "reliable"),
        ("2", "best_effort"),
        ("self.other()", "open"),
    ],
)
def test_a_policy_in_a_parameter(tmp_path: Path, default: str, found: str) -> None:
    """A parameter holds the number of a policy."""
    body = f"""
    def __init__(self):
        super().__init__("robot")
        self.declare_parameter("reliability", {default})
        policy = self.get_parameter("reliability").get_parameter_value().integer_value
        qos = QoSProfile(depth=1, reliability=policy)
        self.create_subscription(String, "in", print, qos)
    """
    before = "from rclpy.qos import QoSProfile, QoSReliabilityPolicy, ReliabilityPolicy"
    node = node_of(tmp_path, body, before=before)
    assert node["subscriptions"][0]["reliability"].partition(":")[0] == found


def test_an_object_with_parameters_is_not_always_a_node(tmp_path: Path) -> None:
    """A class of another package may have parameters of its own, as states of a state machine do."""
    text = """
from machines import State, Part

class Waits(State):
    def __init__(self):
        super().__init__()
        self.declare_parameter("seconds", 1.0)

class Sensor(Part):
    def __init__(self):
        super().__init__()
        self.declare_parameter("topic", "out")
        self.pub = self.create_publisher(String, "out", 10)

def main():
    rclpy.init()
    Waits(), Sensor()

if __name__ == "__main__":
    main()
"""
    assert [each.cls for each in facts_of(tmp_path, text).nodes] == ["Sensor"]
