"""Publishers, subscriptions, timers, services, clients and actions: found however the code makes them."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.sources.facts import is_open
from dineros.sources.reading import read_source
from tests.sources.support import facts_of, node_of, one


def test_entities_have_names_types_callbacks_and_places(tmp_path: Path) -> None:
    node = node_of(
        tmp_path,
        """
        def __init__(self):
            super().__init__("robot")
            self.pub = self.create_publisher(String, "out", 7)
            self.create_subscription(String, "in", self.on_in, 3)
            self.timer = self.create_timer(0.5, self.tick)
            self.create_service(Trigger, "ask", self.answer)
            self.cli = self.create_client(Trigger, "other")
        def on_in(self, message): self.pub.publish(message)
        def tick(self): pass
        def answer(self, request, response): return response
        """,
    )
    assert node["name"] == "robot" and node["threads"] == 1 and node["class"] == "Robot"
    (publisher,), (reader,) = node["publishers"], node["subscriptions"]
    assert publisher == {
        **{"port": "self.pub", "at": "program.py:11", "name": "out", "type": "std_msgs/msg/String"},
        **{"depth": 7, "reliability": "reliable", "durability": "volatile"},
    }
    assert (reader["port"], reader["name"], reader["callback"], reader["group"], reader["depth"]) == (
        *("(no variable)", "in", "on_in", "default"),
        3,
    )
    assert node["timers"][0]["period"] == 0.5
    assert node["services"][0]["callback"] == "answer"
    assert node["clients"][0]["name"] == "other"


NAMES = {
    '"scan"': "scan",
    "TOPIC": "/front/scan",
    'PREFIX + "/scan"': "/front/scan",
    'f"{PREFIX}/scan"': "/front/scan",
    '"{}/scan".format(PREFIX)': "/front/scan",
    '"{p}/scan".format(p=PREFIX)': "/front/scan",
    '"%s/scan" % PREFIX': "/front/scan",
    '"/".join(["a", "b"])': "a/b",
    'self.declare_parameter("topic", "given").value': "given",
    'self.get_parameter("earlier").get_parameter_value().string_value': "first",
    'self.get_parameter_or("unknown", "other")': "other",
    "self.NAME": "of_class",
    "Robot.NAME": "of_class",
    "NAMES[1]": "two",
    'TABLE["scan"]': "/table",
    "constants.TOPIC": "from_file",
    "OTHER": "from_file_too",
    "name": "argument",
    '"a" if True else "b"': "a",
    'os.environ.get("NOT_SET", "usual")': "usual",
}
OPEN = {
    "sys.argv[1]": "open: sys.argv[1]",
    'self.declare_parameter("none").value': "open: parameter none",
    'f"{self.get_namespace_of(1)}/scan"': "{self.get_namespace_of(1)}/scan",
    'os.environ["ROS_DISTRO"]': "open: environment ROS_DISTRO",
}


@pytest.mark.parametrize(("code", "expected"), [*NAMES.items(), *OPEN.items()])
def test_names_are_resolved_or_open(tmp_path: Path, code: str, expected: str) -> None:
    node = node_of(
        tmp_path,
        f"""
        NAME = "of_class"
        def __init__(self, name="argument"):
            super().__init__("robot")
            self.declare_parameter("earlier", "first")
            self.create_publisher(String, {code}, 10)
        """,
        before="""
        import os, sys
        import constants
        from constants import SECOND as OTHER
        PREFIX = "/front"
        TOPIC = PREFIX + "/scan"
        NAMES = ["one", "two"]
        TABLE = {"scan": "/table"}
        """,
        constants='TOPIC = "from_file"\nSECOND = "from_file_too"\n',
    )
    assert node["publishers"][0]["name"] == expected


@pytest.mark.parametrize(
    ("code", "names"),
    [
        ('"a" if len(sys.argv) > 1 else "b"', ["a", "b"]),
        ('color + "/a"', ["blue/a", "red/a"]),
        ('f"{color}/a"', ["blue/a", "red/a"]),
        ('"{}/a".format(color)', ["blue/a", "red/a"]),
        ('{"x": "one", "y": "two"}[sys.argv[1]]', ["one", "two"]),
    ],
)
def test_a_port_with_several_names_has_an_alternative_for_each(
    tmp_path: Path, code: str, names: list[str]
) -> None:
    text = f"""
    import sys

    def main():
        rclpy.init()
        node = rclpy.create_node("robot")
        color = "red"
        if len(sys.argv) > 1:
            color = "blue"
        out = node.create_publisher(String, {code}, 10)
        node.create_subscription(String, "in", lambda text: out.publish(text), 10)
        rclpy.spin(node)

    if __name__ == "__main__":
        main()
    """
    node = one(facts_of(tmp_path, text))
    found = node.of("publishers")
    assert sorted(each.name for each in found) == names
    assert {(each.port, each.details["conditional"]) for each in found} == {("out", "one of several names")}
    (callback,) = [each for each in node.callbacks if each.kind == "subscription"]
    assert {(each.entity, each.when) for each in callback.effects} == {
        (port, "conditional") for port in found
    }


ARGUMENTS = """
import argparse

def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--yellow", action="store_true")
    group = parser.add_argument_group("names")
    group.add_argument("-t", "--the-topic", default="talk")
    parser.add_argument("where")
    parser.add_argument("--needed", required=True)
    args, others = parser.parse_known_args({given})
    rclpy.init()
    node = rclpy.create_node("robot")
    node.create_publisher(String, "yellow" if args.yellow else "blue", 10)
    node.create_publisher(String, args.the_topic, 10)
    node.create_publisher(String, args.where, 10)
    node.create_publisher(String, args.needed, 10)
    rclpy.spin(node)

if __name__ == "__main__":
    main()
"""


def test_options_of_the_command_line_have_their_defaults(tmp_path: Path) -> None:
    found = one(facts_of(tmp_path, ARGUMENTS.format(given=""))).to_json()["publishers"]
    names = [each["name"] for each in found]
    assert "talk" in names and {"yellow", "blue"} >= set(names) - {"talk", *names[-2:]}
    assert names[-2:] == ["open: option where", "open: option needed"]
    (topic,) = [each for each in found if each["name"] == "talk"]
    assert topic["from_"] == "option the_topic"


def test_options_that_the_program_or_a_launch_file_gives(tmp_path: Path) -> None:
    text = ARGUMENTS.format(given="['--the-topic=said', '--needed', 'one', '--yellow']")
    names = [each["name"] for each in one(facts_of(tmp_path, text)).to_json()["publishers"]]
    assert names[-3:] == ["said", "open: option where", "one"]
    text = ARGUMENTS.format(given="['--the-topic', 'said', '--unknown']")
    names = [each["name"] for each in one(facts_of(tmp_path, text)).to_json()["publishers"]]
    assert names[-3] == "open: option the_topic"


def test_a_name_of_one_of_several_modules_has_the_type_that_fits(tmp_path: Path) -> None:
    node = node_of(
        tmp_path,
        """
        def __init__(self):
            super().__init__("robot")
            self.create_client(Move, "move")
            self.create_publisher(Pose, "pose", 1)
        """,
        before="from arm_msgs.msg import *\nfrom arm_msgs.srv import *\nfrom geometry_msgs.srv import *",
    )
    assert node["publishers"][0]["type"] == "arm_msgs/msg/Pose"
    assert node["clients"][0]["type"] == "open: arm_msgs/srv/Move or geometry_msgs/srv/Move"


def test_a_name_that_changes_in_a_loop_is_never_taken_for_its_first_value(tmp_path: Path) -> None:
    node = node_of(
        tmp_path,
        """
        def __init__(self):
            super().__init__("robot")
            name, number = "first", 0
            for each in unknown():
                self.create_publisher(String, name, 10)
                self.create_publisher(String, f"t{number}", 10)
                name, number = "other", number + 1
        """,
    )
    assert all("open" in each["name"] or "{" in each["name"] for each in node["publishers"])
    assert len(node["publishers"]) == 2


def test_loops_over_known_lists_make_one_entity_for_each(tmp_path: Path) -> None:
    node = node_of(
        tmp_path,
        """
        def __init__(self):
            super().__init__("robot")
            self.subs = {}
            for name in ("left", "right"):
                self.subs[name] = self.create_subscription(String, f"{name}/scan", self.on_scan, 10)
            self.pubs = [self.create_publisher(String, f"wheel{i}", 10) for i in range(3)]
            for kind, (topic, depth) in {"a": ("x", 1), "b": ("y", 2)}.items():
                self.create_publisher(String, topic + kind, depth)
        def on_scan(self, message): pass
        """,
    )
    assert [each["name"] for each in node["subscriptions"]] == ["left/scan", "right/scan"]
    assert [(each["name"], each["depth"]) for each in node["publishers"]] == [
        *(("wheel0", 10), ("wheel1", 10), ("wheel2", 10)),
        *(("xa", 1), ("yb", 2)),
    ]


def test_helpers_make_entities_on_the_node_that_they_get(tmp_path: Path) -> None:
    node = node_of(
        tmp_path,
        """
        def __init__(self):
            super().__init__("robot")
            self.arm = Arm(self, "arm")
            connect(self, "speed")
        """,
        before="""
        from rclpy.action import ActionServer
        from example_interfaces.action import Fibonacci
        class Arm:
            def __init__(self, node, name):
                self.node = node
                self.server = ActionServer(self.node, Fibonacci, f"{name}/move", self.move)
            def move(self, goal): goal.succeed(); return Fibonacci.Result()
        def connect(node, topic, depth=4):
            node.speed = node.create_publisher(String, topic, depth)
        """,
    )
    (server,) = node["action_servers"]
    assert (server["name"], server["type"], server["execute"]) == (
        *("arm/move", "example_interfaces/action/Fibonacci"),
        "move",
    )
    assert node["publishers"][0]["port"] == "node.speed" and node["publishers"][0]["depth"] == 4
    assert any(each["name"] == "move" and each["effects"][0]["do"] == "succeed" for each in node["callbacks"])


def test_inheritance_over_files_and_a_base_that_gets_the_names(tmp_path: Path) -> None:
    node = one(
        facts_of(
            tmp_path,
            """
            from base import Base
            class Special(Base):
                TOPIC = "special"
                def __init__(self): super().__init__("special_node", rate=4)
                def work(self): self.out.publish(String())
            def main():
                rclpy.init(); rclpy.spin(Special())
            if __name__ == "__main__": main()
            """,
            base="""
            from rclpy.node import Node
            from std_msgs.msg import String
            class Base(Node):
                TOPIC = "base"
                def __init__(self, name, rate=1):
                    super().__init__(name)
                    self.out = self.create_publisher(String, self.TOPIC, 1)
                    self.create_timer(1.0 / rate, self.work)
                def work(self): raise NotImplementedError
            """,
        )
    ).to_json()
    assert (node["class"], node["name"], node["publishers"][0]["name"]) == (
        "Special",
        "special_node",
        "special",
    )
    assert node["timers"][0]["period"] == 0.25
    (work,) = [each for each in node["callbacks"] if each["name"] == "work"]
    assert work["effects"][0]["do"] == "publish" and work["at"] == "program.py:11"


def test_both_of_an_attribute_that_is_given_twice_and_what_is_bound_to_nothing(tmp_path: Path) -> None:
    node = node_of(
        tmp_path,
        """
        def __init__(self):
            super().__init__("robot")
            self.sub = self.create_subscription(String, "a", self.on, 1)
            self.sub = self.create_subscription(String, "b", self.on, 1)
            self.create_subscription(String, "c", lambda m: self.on(m), 1)
        def on(self, m): pass
        """,
    )
    assert [each["name"] for each in node["subscriptions"]] == ["a", "b", "c"]
    assert node["subscriptions"][2]["callback"] == "lambda -> on"


def test_branches_are_conditional_and_settings_decide_what_is_there_by_default(tmp_path: Path) -> None:
    node = node_of(
        tmp_path,
        """
        def __init__(self):
            super().__init__("robot")
            if self.declare_parameter("simulated", False).value:
                self.create_publisher(String, "simulated", 1)
            else:
                self.create_publisher(String, "real", 1)
            if unknown():
                self.create_publisher(String, "perhaps", 1)
            if False:
                self.create_publisher(String, "never", 1)
        """,
    )
    found = {each["name"]: (each.get("enabled", True), "conditional" in each) for each in node["publishers"]}
    assert found == {"simulated": (False, True), "real": (True, True), "perhaps": (True, True)}


QUALITIES = {
    "5": (5, "reliable", "volatile"),
    "QoSProfile(depth=2)": (2, "reliable", "volatile"),
    "qos_profile_sensor_data": (5, "best_effort", "volatile"),
    "QoSPresetProfiles.SENSOR_DATA.value": (5, "best_effort", "volatile"),
    "QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)": (1, "reliable", "transient_local"),
    "QoSProfile(depth=1, reliability=QoSReliabilityPolicy.RMW_QOS_POLICY_RELIABILITY_BEST_EFFORT)": (
        *(1, "best_effort"),
        "volatile",
    ),
    "changed": (3, "best_effort", "volatile"),
    "by_parameter": (8, "reliable", "volatile"),
    "LATCHED": (1, "reliable", "transient_local"),
    "unknown()": ("open: unknown()", "open: unknown()", "open: unknown()"),
    "10 if unknown() else qos_profile_sensor_data": (
        *("open: 10 or 5", "open: reliable or best_effort"),
        "volatile",
    ),
}


@pytest.mark.parametrize(("code", "expected"), QUALITIES.items())
def test_quality_of_service(tmp_path: Path, code: str, expected: tuple[object, ...]) -> None:
    node = node_of(
        tmp_path,
        f"""
        def __init__(self):
            super().__init__("robot")
            changed = QoSProfile(depth=3)
            changed.reliability = ReliabilityPolicy.BEST_EFFORT
            self.declare_parameter("depth", 8)
            by_parameter = QoSProfile(depth=self.get_parameter("depth").value)
            self.create_publisher(String, "out", {code})
        """,
        before="""
        from rclpy.qos import *
        from rclpy.qos import DurabilityPolicy, QoSPresetProfiles, QoSProfile, QoSReliabilityPolicy
        from rclpy.qos import ReliabilityPolicy, qos_profile_sensor_data
        LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        """,
    )
    (found,) = node["publishers"]
    assert tuple(found[key] for key in ("depth", "reliability", "durability")) == expected


def test_groups_have_names_kinds_and_those_that_use_them(tmp_path: Path) -> None:
    node = node_of(
        tmp_path,
        """
        def __init__(self):
            super().__init__("robot")
            self.calls = MutuallyExclusiveCallbackGroup()
            other = ReentrantCallbackGroup()
            self.create_client(Trigger, "a", callback_group=self.calls)
            self.create_timer(1, self.tick, other)
            self.create_timer(1, self.tick, callback_group=ReentrantCallbackGroup())
            self.create_timer(1, self.tick, callback_group=self.calls if unknown() else None)
            self.create_timer(1, self.tick, callback_group=self.default_callback_group)
        def tick(self): pass
        """,
        before="from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup\n",
    )
    assert [(each["name"], each["kind"]) for each in node["groups"]] == [
        *(("self.calls", "exclusive"), ("other", "reentrant")),
    ]
    assert node["clients"][0]["group"] == "self.calls"
    assert [each["group"] for each in node["timers"]] == [
        *("other", "anonymous reentrant (:16)", "open: self.calls or default", "default"),
    ]


EXECUTORS = "from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor\n"
THREADS = {
    "rclpy.spin(Robot())": 1,
    "e = MultiThreadedExecutor(num_threads=3); e.add_node(Robot()); e.spin()": 3,
    "e = MultiThreadedExecutor(); e.add_node(Robot()); e.spin()": "processors",
    "e = SingleThreadedExecutor(); e.add_node(Robot()); e.spin()": 1,
    "rclpy.spin(Robot(), executor=MultiThreadedExecutor(2))": 2,
    "e = MultiThreadedExecutor(4); e.add_node(Robot()); threading.Thread(target=e.spin).start()": 4,
    "n = Robot(); threading.Thread(target=rclpy.spin, args=(n,)).start()": 1,
    "n = Robot(); threading.Thread(target=lambda: rclpy.spin(n)).start()": 1,
    "n = Robot()": "not spun",
    "n = Robot()\n    while rclpy.ok(): rclpy.spin_once(n, timeout_sec=0.1)": 1,
}


@pytest.mark.parametrize(("code", "expected"), THREADS.items())
def test_executors_and_threads(tmp_path: Path, code: str, expected: object) -> None:
    node = node_of(
        tmp_path,
        'def __init__(self): super().__init__("robot")',
        after=f"def main():\n    rclpy.init()\n    {code}\n",
        before="import threading\n" + EXECUTORS,
    )
    assert node["threads"] == expected


def test_methods_with_names_of_ros_that_are_not_of_ros(tmp_path: Path) -> None:
    node = node_of(
        tmp_path,
        """
        def __init__(self):
            super().__init__("robot")
            self.mqtt = mqtt.Client()
            self.create_subscription(String, "in", self.on, 1)
        def publish(self, text): self.count = 1
        def on(self, m):
            self.mqtt.publish("x", 1)
            self.publish("x")
            Broker().publish(m)
        """,
        before="""
        import paho.mqtt.client as mqtt
        class Broker:
            def publish(self, m): pass
        """,
    )
    (callback,) = [each for each in node["callbacks"] if each["name"] == "on"]
    assert callback["effects"] == []


def test_nodes_of_functions_and_of_objects(tmp_path: Path) -> None:
    facts = facts_of(
        tmp_path,
        """
        class Holder:
            def __init__(self, name):
                self.node = rclpy.create_node(node_name=name, namespace="arm")
                self.node.create_timer(timer_period_sec=0.2, callback=self.tick)
            def tick(self): pass
        def main():
            rclpy.init()
            def on(message): out.publish(message)
            node = rclpy.create_node("plain")
            node.create_subscription(String, "in", on, 1)
            out = node.create_publisher(String, "out", 1)
            holder = Holder("held")
            rclpy.spin(node)
        if __name__ == "__main__": main()
        """,
    )
    held, plain = sorted((each.to_json() for each in facts.nodes), key=lambda each: str(each["name"]))
    assert (held["class"], held["namespace"], held["timers"][0]["callback"]) == ("Holder", "arm", "tick")
    assert (plain["class"], plain["name"]) == ("main", "plain")
    assert plain["callbacks"][0]["effects"][0]["do"] == "publish"


def test_a_class_that_is_extended_under_another_name_is_no_node_of_its_own(tmp_path: Path) -> None:
    base = """
    from rclpy.node import Node
    class Base(Node):
        def __init__(self, name): super().__init__(name)
    """
    text = """
    from base import Base as Common
    class Robot(Common):
        def __init__(self): super().__init__("robot")
    rclpy.init()
    rclpy.spin(Robot())
    """
    assert [node.name for node in facts_of(tmp_path, text, base=base).nodes] == ["robot"]


@pytest.mark.parametrize("name", ["open_gripper", "opened", "gripper/open"])
def test_names_that_begin_with_open_are_known(tmp_path: Path, name: str) -> None:
    node = node_of(
        tmp_path,
        f"""
        def __init__(self):
            super().__init__("open_robot")
            self.create_publisher(String, "{name}", 1)
        """,
    )
    assert (node["name"], node["publishers"][0]["name"]) == ("open_robot", name)
    assert not is_open(node["name"]) and not is_open(name)


def test_options_of_the_command_line_are_absent_by_default(tmp_path: Path) -> None:
    node = node_of(
        tmp_path,
        """
        def __init__(self):
            super().__init__("robot")
            self.create_publisher(String, "fixed" if "--fixed" in sys.argv else "usual", 1)
        """,
        before="import sys",
    )
    assert node["publishers"][0]["name"] == "usual"


def test_all_names_of_a_package_of_interfaces(tmp_path: Path) -> None:
    node = node_of(
        tmp_path,
        """
        def __init__(self):
            super().__init__("robot")
            self.create_publisher(Twist, "cmd_vel", 1)
        """,
        before="from geometry_msgs.msg import *",
    )
    assert node["publishers"][0]["type"] == "geometry_msgs/msg/Twist"


def test_all_names_of_two_packages_are_open(tmp_path: Path) -> None:
    node = node_of(
        tmp_path,
        """
        def __init__(self):
            super().__init__("robot")
            self.create_publisher(Twist, "cmd_vel", 1)
        """,
        before="from geometry_msgs.msg import *\nfrom sensor_msgs.msg import *",
    )
    assert is_open(node["publishers"][0]["type"])


def test_all_names_of_a_module_that_is_not_there_are_said_to_be_missing(tmp_path: Path) -> None:
    facts = facts_of(tmp_path, 'from real import *\nrclpy.init()\nNode("there")\n')
    assert facts.unread == ["program.py:6: takes all names of real, which is not in the folder"]
    assert [node.name for node in facts.nodes] == ["there"]


@pytest.mark.parametrize("has_entry_point", [False, True])
def test_a_main_function_that_the_module_itself_calls_runs_once(
    tmp_path: Path, has_entry_point: bool
) -> None:
    (tmp_path / "robot.py").write_text(
        "import rclpy\nfrom rclpy.node import Node\n"
        "def main():\n    rclpy.init()\n    rclpy.spin(Node('robot'))\nmain()\n"
    )
    if has_entry_point:
        (tmp_path / "package.xml").write_text("<package><name>one</name></package>")
        (tmp_path / "setup.py").write_text(
            "setup(name='one', entry_points={'console_scripts': ['run = robot:main']})"
        )
    facts = read_source(tmp_path)
    assert [(node.name, node.also_in) for node in facts.nodes] == [("robot", [])]


def test_names_of_several_star_imports_are_known(tmp_path: Path) -> None:
    (tmp_path / "robot.py").write_text(
        "import rclpy\nfrom rclpy.node import *\nfrom rclpy.executors import *\n"
        "from rclpy.callback_groups import *\nfrom std_msgs.msg import String\n"
        "class Robot(Node):\n    def __init__(self):\n        super().__init__('robot')\n"
        "        group = ReentrantCallbackGroup()\n"
        "        self.create_subscription(String, 'in', print, 5, callback_group=group)\n"
        "def main():\n    rclpy.init()\n    executor = MultiThreadedExecutor(3)\n"
        "    executor.add_node(Robot())\n    executor.spin()\n"
        "if __name__ == '__main__':\n    main()\n"
    )
    (node,) = read_source(tmp_path).nodes
    assert (node.threads, node.of("subscriptions")[0].details["group"]) == (3, "group")
    assert [group.details["kind"] for group in node.of("groups")] == ["reentrant"]
