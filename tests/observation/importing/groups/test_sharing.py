"""Nodes of the code that share an executor become one node net."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import pytest

from dineros.analysis.bounds.answers import Bounds
from dineros.analysis.latencies.answers import end_of
from dineros.analysis.latencies.paths import callback_pages
from dineros.metamodel import sym
from dineros.metamodel.build import seconds
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import channels, node_net_of
from dineros.observation.importing.building import to_model
from tests.support.programs.coded import BATTERY, MONITOR, files, read, run, steps

BOTH = BATTERY.replace(
    "def main():\n    rclpy.init()\n    rclpy.spin(Battery())",
    MONITOR.replace("GROUP", "").partition("def main")[0]
    + "def main():\n    rclpy.init()\n    e = SingleThreadedExecutor()\n"
    "    for n in (Battery(), Monitor()): e.add_node(n)\n    e.spin()",
)


def test_nodes_that_share_an_executor_are_one_node_net(tmp_path: Path) -> None:
    found = read(files(tmp_path, both=BOTH))
    (node,) = found.system.nodes
    assert found.given.nodes[node.name].groups == {"of_battery": "exclusive", "of_monitor": "exclusive"}
    assert {name: each.group for name, each in found.given.nodes[node.name].callbacks.items()} == {
        "/level": "of_battery",
        "/level (client)": "of_monitor",
        "tick": "of_monitor",
    }
    assert any("share an executor" in line for line in found.taken)


def test_nodes_that_share_an_executor_may_read_one_topic(tmp_path: Path) -> None:
    """Each keeps its own callback of the topic, and one thread takes both."""
    source = files(
        tmp_path,
        two="""
        class Camera(Node):
            def __init__(self):
                super().__init__("camera")
                self.out = self.create_publisher(String, "image", 3)
                self.create_timer(0.1, self.tick)
            def tick(self): self.out.publish(String())
        class Reader(Node):
            def __init__(self, name):
                super().__init__(name)
                self.found = self.create_publisher(String, name + "/found", 3)
                self.create_subscription(String, "image", self.look, 3)
            def look(self, message): self.found.publish(message)
        def main():
            rclpy.init()
            e = SingleThreadedExecutor()
            for n in (Camera(), Reader("left"), Reader("right")): e.add_node(n)
            e.spin()
        if __name__ == "__main__": main()
        """,
    )
    found = read(source)
    (node,) = found.system.nodes
    assert steps(found, node.name) == {
        "tick": ["publish /image"],
        "/image": ["publish /left/found"],
        "/image of /right": ["publish /right/found"],
    }
    model = to_model(found.system, found.given).model
    assert [each for each in validate(model) if each.severity == "error"] == []
    (topic,) = [each for each in channels(model, sym.TopicChannel) if each.topic == "/image"]
    assert len(topic.subscribers) == 2
    assert len({node_net_of(each.place) for each in topic.subscribers}) == 1
    for page in callback_pages(model):
        page.duration = seconds(0.01, 0.01)
    for each in channels(model, sym.TopicChannel):
        each.latency = seconds(0, 0)
    bounds = Bounds(model)
    greatest = bounds.between(end_of(model, "/image"), end_of(model, "/right/found")).greatest
    assert greatest is not None and greatest.value >= Fraction(2, 100), "the left one may go first"


def test_nodes_on_one_executor_have_no_order_of_rclpy(tmp_path: Path) -> None:
    """It takes the callbacks node by node, which an order of the joined nodes does not say."""
    source = files(tmp_path, both=BOTH)
    (name,) = [node.name for node in read(source).system.nodes]
    model, given = tmp_path / "robot.sym.xmi", tmp_path / "robot.given.toml"
    given.write_text(f'[node."{name}"]\norder = "rclcpp"\n')
    assert run("import", "-q", "--source", source, "-o", model)[0] == 0
    given.write_text(f'[node."{name}"]\norder = "rclpy"\n')
    assert run("import", "-q", "--source", source, "-o", model)[0] == 2


def test_nodes_that_ask_one_service_stay_apart_which_the_model_then_lacks(tmp_path: Path) -> None:
    """Then they have a thread each, so a proof about the model need not hold for the code."""
    text = MONITOR.replace("GROUP", "").replace('"monitor")', "name)").replace("(self)", "(self, name)", 1)
    text = (
        text.partition("def main")[0]
        + """
def main():
    rclpy.init()
    e = SingleThreadedExecutor()
    for n in (Monitor("a"), Monitor("b")): e.add_node(n)
    e.spin()
if __name__ == "__main__": main()
"""
    )
    found = read(files(tmp_path, battery=BATTERY, monitor=text))
    assert [node.name for node in found.system.nodes] == ["/a", "/b", "/battery"]
    assert len(found.lacks) == 1
    told = json.loads(run("check", "--source", tmp_path, "--json", "--timeout", 20)[1])
    assert told["proved"] == [] and "callback-deadlock" in {each["rule"] for each in told["findings"]}


@pytest.mark.parametrize(("group", "has_deadlock"), [("group", True), ("ReentrantCallbackGroup()", False)])
def test_a_group_of_two_nodes_is_one_group(tmp_path: Path, group: str, has_deadlock: bool) -> None:
    """The caller of one node holds the group that the service of the other needs."""
    source = files(
        tmp_path,
        two=f"""
        class Left(Node):
            def __init__(self, group):
                super().__init__("left")
                own = MutuallyExclusiveCallbackGroup()
                self.right = self.create_client(Trigger, "right", callback_group=own)
                self.create_timer(1.0, self.tick, callback_group=group)
            def tick(self):
                self.right.call(Trigger.Request())
        class Right(Node):
            def __init__(self, group):
                super().__init__("right")
                self.create_service(Trigger, "right", self.answer, callback_group=group)
            def answer(self, request, response):
                return response
        def main():
            rclpy.init()
            group = MutuallyExclusiveCallbackGroup()
            executor = MultiThreadedExecutor(4)
            executor.add_node(Left(group))
            executor.add_node(Right({group}))
            executor.spin()
        if __name__ == "__main__":
            main()
        """,
    )
    assert ("[callback-deadlock]" in run("check", "--source", source)[1]) == has_deadlock
