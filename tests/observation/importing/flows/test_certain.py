"""Attributes decide in a model only if the reader knows every assignment."""

from __future__ import annotations

from pathlib import Path
from textwrap import dedent, indent

import pytest

from dineros.metamodel import sym
from dineros.metamodel.callbacks.under_way import goal_counts
from dineros.metamodel.elements import places, transitions
from dineros.observation.importing.building import to_model
from dineros.observation.importing.coded import Coded, coded
from dineros.observation.importing.correcting import merged
from dineros.observation.importing.given import Given, GivenCallback, GivenNode
from dineros.sources.reading import read_source

HEAD = """
import threading
import rclpy
from rclpy.action import ActionClient
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from example_interfaces.action import Fibonacci
from std_msgs.msg import String
from std_srvs.srv import Trigger
"""
ROBOT = """
class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.busy = False
        self.pub = self.create_publisher(String, "out", 10)
        self.create_subscription(String, "go", self.on_go, 10)
        self.create_timer(1.0, self.tick)
{more}
    def on_go(self, message):
        self.busy = True
    def tick(self):
        if self.busy:
            self.busy = False
            self.pub.publish(String())
{methods}
def main():
    rclpy.init()
    node = Robot()
{main}
    rclpy.spin(node)
if __name__ == "__main__":
    main()
"""
MISSION = """
class Mission(Node):
    def __init__(self):
        super().__init__("mission")
        self.nav = ActionClient(self, Fibonacci, "navigate")
        self.busy = False
        self.create_timer(0.5, self.tick{group})
    def tick(self):
        if not self.busy and self.nav.server_is_ready():
            self.busy = True
            self.nav.send_goal_async(Fibonacci.Goal()).add_done_callback(self.accepted)
    def accepted(self, future):
        if future.result().accepted:
            future.result().get_result_async().add_done_callback(self.result)
        else:
            self.busy = False
    def result(self, future):
        self.busy = False
def main():
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=4)
    executor.add_node(Mission())
    executor.spin()
if __name__ == "__main__":
    main()
"""


def read(folder: Path, text: str) -> Coded:
    (folder / "robot.py").write_text(HEAD + text)
    return coded([("", read_source(folder))], "src")


def robot(more: str = "", methods: str = "", main: str = "") -> str:
    return ROBOT.format(
        more=indent(dedent(more), " " * 8),
        methods=indent(dedent(methods), " " * 4),
        main=indent(dedent(main), " " * 4),
    )


def variables(folder: Path, text: str) -> list[str]:
    return sorted(read(folder, text).given.nodes["/robot"].variables)


def test_a_flag_that_callbacks_set_and_test_decides(tmp_path: Path) -> None:
    found = read(tmp_path, robot())
    (flag,) = found.given.nodes["/robot"].variables.values()
    assert flag.values == ("False", "True") and flag.first == "False" and flag.at.startswith("robot.py:")
    model = to_model(found.system, found.given).model
    tokens = {str(place.id): place.tokens for place in places(model)}
    assert tokens["robot.busy_False"] == 1 and tokens["robot.busy_True"] == 0
    sets = [each for each in transitions(model) if "sets_busy" in str(each.id)]
    assert {str(each.sourceLine) for each in sets} == {"robot.py:21", "robot.py:24"}


HIDDEN = {
    "outside of the class": robot(main="node.busy = True"),
    "an unknown name": robot(methods="def set(self, name):\n    setattr(self, name, True)"),
    "its name": robot(methods="def set(self):\n    setattr(self, 'busy', True)"),
    "code that nothing calls": robot(methods="def reset(self):\n    self.busy = False"),
    "its dictionary": robot(methods="def set(self):\n    self.__dict__['busy'] = True"),
    "a thread": robot("threading.Thread(target=self.work).start()", "def work(self):\n    self.busy = True"),
    "a function that a library gets": robot(
        "import signal\nsignal.signal(2, self.stop)", "def stop(self, *_):\n    self.busy = False"
    ),
    "a method that may be called on something unknown": robot(
        "self.create_timer(2.0, self.other)",
        "def other(self):\n    self.reset()\n    for each in self.get():\n        each.reset()\n"
        "def reset(self):\n    self.busy = True\n",
    ),
    "a callback that the model has not": robot(
        "self.add_on_set_parameters_callback(self.changed)", "def changed(self, _):\n    self.busy = True"
    ),
    "a subscription that may be missing": robot(
        "if threading.active_count() > 3:\n    self.create_subscription(String, 'x', self.on_x, 10)",
        "def on_x(self, _):\n    self.busy = True",
    ),
    "a setter": robot(methods="def __setattr__(self, name, value):\n    super().__setattr__(name, value)"),
    "a deletion": robot(methods="def drop(self):\n    del self.busy"),
    "a generator": robot(
        "self.create_timer(2.0, self.other)", "def other(self):\n    self.busy = True\n    yield"
    ),
    "a decorated function": robot(
        "self.create_timer(2.0, self.other)", "@threading.settrace\ndef other(self):\n    self.busy = True"
    ),
    "a value that is not known first": robot("self.busy = self.get_name() == 'x'"),
    "a task": robot(
        "self.create_timer(2.0, self.other)",
        "def other(self):\n    self.executor.create_task(self.work)\ndef work(self):\n    self.busy = True",
    ),
}


@pytest.mark.parametrize("text", HIDDEN.values(), ids=HIDDEN)
def test_a_flag_that_something_else_may_set_is_open(tmp_path: Path, text: str) -> None:
    assert variables(tmp_path, text) == []


def test_another_class_may_have_an_attribute_of_that_name(tmp_path: Path) -> None:
    other = "class Other:\n    def __init__(self):\n        self.busy = 3\n"
    other += "    def unused(self):\n        self.busy = 4\n"
    assert variables(tmp_path, other + robot()) == ["busy"]


def test_a_base_class_in_the_folder_is_followed_and_one_outside_is_not(tmp_path: Path) -> None:
    base = "class Base(Node):\n    def __init__(self, name):\n        super().__init__(name)\n"
    text = robot().replace("(Node)", "(Base)")
    assert variables(tmp_path, base + text) == ["busy"]
    assert variables(tmp_path, base.replace("(Node)", "(Node, Elsewhere)") + text) == []


def test_a_client_that_waits_by_a_flag_has_one_goal_under_way(tmp_path: Path) -> None:
    found = read(tmp_path, MISSION.format(group=""))
    model = to_model(found.system, found.given).model
    assert set(goal_counts(model).values()) == {1}
    (action,) = [each for each in model.channels if isinstance(each, sym.ActionChannel)]
    (client,) = action.clients
    assert client.accepted is not None and client.rejected is not client.succeeded


def test_ticks_that_overlap_may_both_see_the_flag(tmp_path: Path) -> None:
    found = read(tmp_path, MISSION.format(group=", ReentrantCallbackGroup()"))
    assert set(goal_counts(to_model(found.system, found.given).model).values()) != {1}


def test_an_answer_on_another_thread_that_a_callback_may_not_expect_leaves_the_flag_open(
    tmp_path: Path,
) -> None:
    def flags(text: str) -> list[str]:
        found = read(tmp_path, text)
        return [
            str(each.id)
            for each in places(to_model(found.system, found.given).model)
            if "busy" in str(each.id)
        ]

    mission = MISSION.format(group="")
    assert flags(mission)
    twice = mission.replace("if not self.busy and", "if self.busy or not self.busy and")
    assert not flags(twice)
    assert flags(twice.replace("num_threads=4", "num_threads=1"))
    assert not flags(
        mission.replace(
            "    def result(self, future):", "    def result(self, future):\n        self.busy = True"
        )
    )


def test_what_people_say_of_a_callback_takes_the_place_of_its_branches(tmp_path: Path) -> None:
    found = read(tmp_path, robot())
    said = merged(found.given, Given({"/robot": GivenNode(callbacks={"/go": GivenCallback(())})}))
    assert said.nodes["/robot"].variables == {}
    assert not [each for each in places(to_model(found.system, said).model) if "busy" in str(each.id)]
