"""Times of imported models: what code and people say of them, and what stays open."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.bounds.answers import Bounds
from dineros.analysis.checks.check import check
from dineros.analysis.timed_checks.timed_check import check_timed
from dineros.metamodel import pn, sym
from dineros.metamodel.build import seconds
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import channels, elements, node_nets
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.times.given import period_of
from dineros.metamodel.times.rates import on_the_way
from dineros.observation.importing.building import Imported, to_model
from dineros.observation.importing.coded import coded
from dineros.observation.importing.given import Given
from dineros.observation.importing.given_reading import read_given
from dineros.observation.importing.timing import order_of
from dineros.observation.systems import ObservedNode, ObservedSystem
from dineros.sources.facts import NodeFact
from dineros.sources.places import Place
from dineros.sources.reading import read_source
from tests.support.systems.foreign import port, trigger

pytestmark = pytest.mark.usefixtures("own_time")

CAMERA = ObservedNode("/camera", publishers=(port("/image", depth=2),))
VIEWER = ObservedNode("/viewer", subscribers=(port("/image", depth=2),), clients=(trigger("/zoom"),))
LENS = ObservedNode("/lens", servers=(trigger("/zoom"),))
TIMES = """
[node."/camera"]
threads = 1
timers.tick = 0.1
callback.tick = {does = ["publish /image"], takes = [0, 0.001], jitter = 0.01, offset = [0, 0]}
[node."/viewer"]
threads = 1
timers = {}
callback."/image" = {does = [], takes = [0.01, 0.05]}
[node."/lens"]
timers = {}
[topic."/image"]
latency = [0.001, 0.002]
[service."/zoom"]
latency = [0, 0.005]
[times]
latency = [0, 0.5]
takes = [0, 0.25]
"""


def imported(folder: Path, text: str, *nodes: ObservedNode) -> Imported:
    path = folder / "robot.given.toml"
    path.write_text(text)
    found = to_model(ObservedSystem("nowhere", nodes), read_given(path))
    assert [each for each in validate(found.model) if each.severity == "error"] == []
    return found


def callback(model: sym.SystemModel, id: str) -> sym.CallbackPage:
    (found,) = (each for each in elements(model) if isinstance(each, sym.CallbackPage) and each.id == id)
    return found


def span(interval: pn.TimeInterval | None) -> tuple[float | None, float | None] | None:
    return None if interval is None else (interval.earliest, interval.latest)


def overflows(model: sym.SystemModel) -> list[str]:
    report = check_timed(model, Budget(seconds=60.0))
    assert not [each for each in report.unknown if "overflow" in str(each)]
    return [each.message for each in report.findings if each.rule == "queue-overflow"]


def test_people_give_all_times(tmp_path: Path) -> None:
    found = imported(tmp_path, TIMES, CAMERA, VIEWER, LENS)
    model = found.model
    assert found.unused == ()
    assert model.times is not None
    assert span(model.times.latency) == (0.0, 0.5)
    assert span(model.times.duration) == (0.0, 0.25)
    assert [span(each.latency) for each in channels(model, sym.TopicChannel)] == [(0.001, 0.002)]
    assert [span(each.latency) for each in channels(model, sym.ServiceChannel)] == [(0.0, 0.005)]
    tick = callback(model, "camera.on_tick")
    assert (span(tick.duration), span(tick.offset), tick.jitter) == ((0.0, 0.001), (0.0, 0.0), 0.01)
    assert period_of(tick) == 0.1


def test_a_latency_of_nothing_is_named(tmp_path: Path) -> None:
    text = '[topic."/imag"]\nlatency = [0, 1]\n[service."/zoom"]\n[action."/go"]\nlatency = [0, 1]\n'
    assert imported(tmp_path, text, CAMERA, VIEWER, LENS).unused == ("/go", "/imag", "/zoom")


@pytest.mark.parametrize(
    "text",
    [
        '[topic."/image"]\nlatency = [2, 1]',
        '[topic."/image"]\nlatency = 1',
        '[topic."/image"]\nlatencies = [1, 2]',
        '[action."/go"]\nservers = ["/x"]',
        "[times]\nperiod = [1, 2]",
        "[times]\ntakes = [0, -1]",
        '[node."/camera"]\ncallback.tick.jitter = -1',
        '[node."/camera"]\ncallback.tick.offset = [1]',
    ],
)
def test_wrong_times_are_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(DinerosError, match=r"robot\.given\.toml"):
        imported(tmp_path, text, CAMERA, VIEWER, LENS)


def test_given_times_prove_that_nothing_overflows(tmp_path: Path) -> None:
    """What a node publishes stands in the node, and not on the page of a callback."""
    model = imported(tmp_path, TIMES, CAMERA, VIEWER, LENS).model
    (topic,) = channels(model, sym.TopicChannel)
    assert on_the_way(topic.publishers[0], topic.subscribers[0]) > 0
    assert overflows(model) == []
    assert Bounds(model).never_overflows(topic.subscribers[0])
    callback(model, "viewer.on_image").duration = seconds(0.2, 0.3)
    assert any("reader history" in each for each in overflows(model))
    # Untimed answers stay: any callback may take any time.
    assert [each for each in check(model).findings if each.rule == "queue-overflow"]


def test_two_callbacks_that_publish_the_same_topic_count_both(tmp_path: Path) -> None:
    """Without the second one, a history of two messages would be deep enough."""
    more = (
        TIMES.replace(
            "timers.tick = 0.1",
            "timers = {tick = 0.1, tock = 0.1}\ncallback.tock = "
            '{does = ["publish /image"], takes = [0, 0.001], offset = [0, 0]}',
        )
        .replace(", jitter = 0.01", "")
        .replace("[0.01, 0.05]", "[0.07, 0.08]")
    )
    assert overflows(imported(tmp_path, more, CAMERA, VIEWER, LENS).model)


def test_an_assumed_period_bounds_nothing(tmp_path: Path) -> None:
    """A timer that stands for whatever a node does of itself may tick at any time."""
    open_timer = TIMES.replace("timers.tick = 0.1\n", "").replace("callback.tick", "callback.timer")
    open_timer = open_timer.replace(", jitter = 0.01, offset = [0, 0]", "")
    model = imported(tmp_path, open_timer, CAMERA, VIEWER, LENS).model
    assert period_of(callback(model, "camera.on_timer")) is None
    (topic,) = channels(model, sym.TopicChannel)
    assert overflows(model)
    assert not Bounds(model).never_overflows(topic.subscribers[0])


CODE = """
import rclpy, time, threading
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String

class Node1(Node):
    def __init__(self):
        super().__init__("one")
        self.pub = self.create_publisher(String, "a", 2)
        self.create_timer(self.get_parameter("rate").value, self.tick)
        self.create_subscription(String, "b", self.on_b, 2)
    def tick(self):
        self.pub.publish(String())
    def on_b(self, message):
        time.sleep(0.01)

class Node2(Node):
    def __init__(self):
        super().__init__("two")
        self.pub = self.create_publisher(String, "b", 2)
        threading.Thread(target=self.work).start()
        self.create_subscription(String, "a", self.on_a, 2)
    def work(self):
        while True:
            self.pub.publish(String())
    def on_a(self, message):
        pass

def main():
    rclpy.init()
    SPIN

if __name__ == "__main__":
    main()
"""


def coded_model(folder: Path, spin: str, given: Given | None = None) -> sym.SystemModel:
    (folder / "nodes.py").write_text(CODE.replace("SPIN", spin))
    read = coded([("", read_source(folder))], str(folder))
    return to_model(read.system, read.with_people(given or Given())).model


@pytest.mark.parametrize(
    ("spin", "order"),
    [
        ("rclpy.spin(Node1())", "rclpy"),
        ("e = SingleThreadedExecutor(); e.add_node(Node1()); e.spin()", "rclpy"),
        ("e = MultiThreadedExecutor(2); e.add_node(Node1()); e.spin()", "any"),
        ("n = Node1()\n    while rclpy.ok():\n        rclpy.spin_once(n)", "any"),
        ("rclpy.spin(Node2())", "any"),  # its thread stands in the model as a timer of the executor
    ],
)
def test_code_says_the_order_of_its_executor(tmp_path: Path, spin: str, order: str) -> None:
    nets = [net for net in node_nets(coded_model(tmp_path, spin)) if not net.assumed]
    assert [str(net.order) for net in nets] == [order]


@pytest.mark.parametrize(
    ("executor", "threads", "plugin", "order"),
    [
        ("SingleThreadedExecutor", 1, "", "rclcpp"),
        ("EventsExecutor", 1, "", None),
        ("StaticSingleThreadedExecutor", 1, "", None),
        ("MultiThreadedExecutor", 4, "", None),
        ("SingleThreadedExecutor", 1, "p::Component", None),
    ],
)
def test_executors_of_rclcpp(executor: str, threads: int, plugin: str, order: str | None) -> None:
    fact = NodeFact("Node", Place("a.cpp", 1), executor=executor, threads=threads, plugin=plugin)
    assert order_of(fact) == order


def test_periods_that_code_leaves_open_bound_nothing(tmp_path: Path) -> None:
    model = coded_model(tmp_path, "rclpy.spin(Node1())")
    assert period_of(callback(model, "one.on_tick")) is None
    model = coded_model(tmp_path, "rclpy.spin(Node2())")
    assert period_of(callback(model, "two.on_main")) is None


def test_a_loop_that_publishes_without_end_is_no_growth(tmp_path: Path) -> None:
    """One message after the other is written and arrives, however many are published in no time."""
    model = coded_model(tmp_path, "rclpy.spin(Node2())")
    for page in elements(model):
        if isinstance(page, sym.CallbackPage) and page.id == "two.on_a":
            page.duration = seconds(0.0, 0.01)
    report = check_timed(model, Budget(seconds=10.0))
    assert not [each for each in report.findings if each.rule == "unbounded"]


def test_people_add_a_time_and_keep_what_code_says(tmp_path: Path) -> None:
    given = tmp_path / "robot.given.toml"
    given.write_text('[node."/one"]\ncallback.tick.takes = [0, 0.5]\n')
    model = coded_model(tmp_path, "rclpy.spin(Node1())", read_given(given))
    tick = callback(model, "one.on_tick")
    assert span(tick.duration) == (0.0, 0.5)
    assert any(each.id.startswith("one.on_tick.publishes_a") for each in elements(model))
    assert "behaviour" not in (tick.assumed or "")
    assert span(callback(model, "one.on_b").duration) == (0.01, None)


def test_given_properties_are_stored(tmp_path: Path) -> None:
    bound = "/image to zoomed within 0.2"
    found = imported(tmp_path, f'{TIMES}\n[properties]\nreacts = "{bound}"\n', CAMERA, VIEWER, LENS)
    (stored,) = found.model.properties
    assert (stored.id, stored.text, stored.expected) == ("reacts", bound, True)


@pytest.mark.parametrize("line", ['"a b" = "x"', "reacts = 3", '"" = "x"'])
def test_wrong_properties_are_refused(tmp_path: Path, line: str) -> None:
    path = tmp_path / "robot.given.toml"
    path.write_text(f"[properties]\n{line}\n")
    with pytest.raises(DinerosError, match=r"properties\."):
        read_given(path)
