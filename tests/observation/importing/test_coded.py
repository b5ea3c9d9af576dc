"""Source code becomes a model: what it does, in which groups and threads, with the lines of the code."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from dineros.cli.main import main
from dineros.metamodel import sym
from dineros.metamodel.elements import elements, node_nets
from dineros.metamodel.files import load
from dineros.observation.findings.mismatches import mismatches
from dineros.observation.importing.building import to_model
from dineros.sources.language.machine import MOST_CALLS
from dineros.sources.reading import Launch, read_source
from tests.support.programs.coded import BATTERY, MONITOR, files, model_of, read, run, steps


@pytest.mark.long
def test_a_call_that_blocks_is_found_at_its_line_and_its_remedy_is_clean(tmp_path: Path) -> None:
    model = tmp_path / "robot.sym.xmi"
    source = files(tmp_path, battery=BATTERY, monitor=MONITOR.replace("GROUP", ""))
    status, _ = run("import", "-q", "--source", source, "-o", model)
    assert status == 0
    line = (
        (source / "monitor.py")
        .read_text()
        .splitlines()
        .index("        self.level.call(Trigger.Request())  # here")
    )
    status, text = run("check", "-q", model)
    assert status == 1
    assert text.splitlines()[0].endswith("[callback-deadlock]")
    assert f"at {source}/monitor.py:{line + 1}, {source}/monitor.py:" in text.splitlines()[1]
    _, text = run("check", "-q", model, "--format", "sarif")
    (result, *_) = json.loads(text)["runs"][0]["results"]
    place = result["locations"][0]["physicalLocation"]
    assert place["region"] == {"startLine": line + 1}
    assert place["artifactLocation"]["uri"].endswith("monitor.py")
    _, text = run("check", "-q", model, "--format", "junit")
    assert f'line="{line + 1}"' in text
    _, text = run("check", "-q", model, "--json")
    assert json.loads(text)["findings"][0]["code"][0] == f"{source}/monitor.py:{line + 1}"
    group = ", callback_group=MutuallyExclusiveCallbackGroup()"
    files(tmp_path, monitor=MONITOR.replace("GROUP", group))
    run("import", "-q", "--source", source, "-o", model)
    status, text = run("check", "-q", model)
    assert status == 0, text


def test_steps_come_in_the_order_of_the_code_with_their_lines(tmp_path: Path) -> None:
    source = files(
        tmp_path,
        robot="""
        class Robot(Node):
            def __init__(self):
                super().__init__("robot", namespace="arm")
                self.out = self.create_publisher(String, "out", 3)
                self.cli = self.create_client(Trigger, "/ask")
                self.nav = ActionClient(self, Fibonacci, "~/go")
                self.create_subscription(String, "in", self.on, qos_profile_sensor_data)
                self.create_timer(0.5, self.tick)
            def say(self): self.out.publish(String())
            def on(self, message):
                self.say()
                if message.data: self.say()
                self.cli.call_async(Trigger.Request()).add_done_callback(self.answered)
            def answered(self, future): self.say()
            def tick(self):
                for _ in self.many: self.say()
                self.nav.send_goal_async(Fibonacci.Goal()).add_done_callback(self.accepted)
            def accepted(self, future):
                if future.result().accepted:
                    future.result().get_result_async().add_done_callback(self.ended)
            def ended(self, future): self.say()
        def main():
            rclpy.init(); rclpy.spin(Robot())
        if __name__ == "__main__": main()
        """,
    )
    found = read(source)
    assert steps(found, "/arm/robot") == {
        "/arm/in": ["publish /arm/out", "publish /arm/out ?", "send /ask"],
        "tick": ["publish /arm/out *", "goal /arm/robot/go"],
        "/ask": ["publish /arm/out"],
        "/arm/robot/go": ["publish /arm/out ?"],
    }
    (node,) = found.system.nodes
    assert node.publishers[0].depth == 3 and node.subscribers[0].quality.reliability == "bestEffort"
    assert found.given.nodes["/arm/robot"].newest == {"/arm/in": True}
    assert node.publishers[0].at == "src/robot.py:15"
    model = model_of(source)
    lines = {each.id: each.sourceLine for each in elements(model)}
    assert lines["arm_robot.on_arm_in.publishes_arm_out"] == "src/robot.py:20"
    assert lines["arm_robot.on_arm_in"] == "src/robot.py:21"


def test_groups_threads_and_waits(tmp_path: Path) -> None:
    source = files(
        tmp_path,
        robot="""
        class Robot(Node):
            def __init__(self):
                super().__init__("robot")
                self.calls = ReentrantCallbackGroup()
                self.cli = self.create_client(Trigger, "a", callback_group=self.calls)
                self.other = self.create_client(Trigger, "b")
                self.create_timer(1, self.blocks, callback_group=MutuallyExclusiveCallbackGroup())
                self.create_timer(1, self.awaits)
                self.create_timer(1, self.spins)
            def blocks(self):
                self.cli.call(Trigger.Request())
            async def awaits(self):
                await self.cli.call_async(Trigger.Request())
            def spins(self):
                rclpy.spin_until_future_complete(self, self.other.call_async(Trigger.Request()))
        def main():
            rclpy.init()
            executor = MultiThreadedExecutor()
            executor.add_node(Robot())
            executor.spin()
        if __name__ == "__main__": main()
        """,
    )
    found = read(source)
    said = found.given.nodes["/robot"]
    (line,) = found.lacks_of_threads(found.given)
    assert said.threads == 4 and "as many threads as processors; 4 are assumed" in line
    assert said.groups == {"calls": "reentrant", "group_18": "exclusive"}
    assert {name: (each.group, each.awaits) for name, each in said.callbacks.items()} == {
        "blocks": ("group_18", False),
        "awaits": (None, True),
        "spins": (None, True),
        "/a": ("calls", False),
        "/b": (None, False),
    }


def test_what_is_open_in_the_code_is_open_in_the_model(tmp_path: Path) -> None:
    source = files(
        tmp_path,
        robot="""
        import sys
        from elsewhere import on_message
        class Robot(Node):
            def __init__(self):
                super().__init__("robot")
                self.out = self.create_publisher(String, "out", 3)
                self.create_publisher(String, sys.argv[1], 3)
                self.create_subscription(String, "in", on_message, 3)
                self.create_timer(self.period, self.tick)
            def tick(self): self.other.publish(String())
        def main():
            rclpy.init(); rclpy.spin(Robot())
        if __name__ == "__main__": main()
        """,
    )
    found = read(source)
    assert steps(found, "/robot") == {"/in": None, "tick": None}
    assert len([line for line in found.taken if "because its name is open" in line]) == 1
    assert len([line for line in found.taken if "the period of a timer" in line]) == 1
    assert len(to_model(found.system, found.given).assumed) == 2


def test_of_alternatives_with_different_types_one_is_taken(tmp_path: Path) -> None:
    source = files(
        tmp_path,
        robot="""
        class Robot(Node):
            def __init__(self):
                super().__init__("robot")
                if unknown():
                    self.out = self.create_publisher(String, "out", 3)
                else:
                    self.out = self.create_publisher(Other, "out", 3)
        def main():
            rclpy.init(); rclpy.spin(Robot())
        if __name__ == "__main__": main()
        """.replace("class Robot", "from std_msgs.msg import Bool as Other\n        class Robot"),
    )
    found = read(source)
    (node,) = found.system.nodes
    assert [each.type for each in node.publishers] == ["std_msgs/msg/String"]
    assert any("omitted in the model: /out of line" in line for line in found.taken)


@pytest.mark.parametrize("heard", ["String", "Bool"])
def test_the_alternative_is_taken_that_others_hear(tmp_path: Path, heard: str) -> None:
    source = files(
        tmp_path,
        ears=f"""
        from std_msgs.msg import Bool
        rclpy.init()
        ears = Node("ears")
        ears.create_subscription({heard}, "out", print, 3)
        rclpy.spin(ears)
        """,
        robot="""
        from std_msgs.msg import Bool
        class Robot(Node):
            def __init__(self):
                super().__init__("robot")
                if unknown():
                    self.out = self.create_publisher(String, "out", 3)
                else:
                    self.out = self.create_publisher(Bool, "out", 3)
        rclpy.init(); rclpy.spin(Robot())
        """,
    )
    found = read(source)
    assert [each.type for node in found.system.nodes for each in node.publishers] == [f"std_msgs/msg/{heard}"]
    assert [each.rule for each in mismatches(found.system) if each.severity == "error"] == []
    assert ["omitted in the model: /out of line" in each for each in found.taken] == [True]


def test_a_launch_file_says_which_nodes_there_are(tmp_path: Path) -> None:
    source = files(tmp_path, battery=BATTERY)
    (tmp_path / "package.xml").write_text("<package><name>cell</name></package>")
    (tmp_path / "robot.launch.xml").write_text(
        '<launch><arg name="side" default="left"/>'
        '<node pkg="cell" exec="battery.py" name="$(var side)_battery" namespace="robot">'
        '<remap from="level" to="/$(var side)/level"/></node>'
        '<node pkg="cell" exec="battery.py" name="other" if="false"/><node pkg="x" exec="y"/></launch>'
    )
    found = read(source, Launch("robot.launch.xml", {"side": "right"}))
    (node,) = found.system.nodes
    assert (node.name, node.servers[0].name) == ("/robot/right_battery", "/right/level")
    status, text = run(
        *("import", "--source", source, "--launch", "robot.launch.xml", "side:=right"),
        *("-o", tmp_path / "m.sym.xmi", "--json"),
    )
    assert status == 0 and [each["name"] for each in json.loads(text)["nodes"]] == ["/robot/right_battery"]


def test_people_correct_what_code_says(tmp_path: Path) -> None:
    source = files(tmp_path, battery=BATTERY, monitor=MONITOR.replace("GROUP", ""))
    model = tmp_path / "robot.sym.xmi"
    (tmp_path / "robot.given.toml").write_text('[node."/monitor"]\nthreads = 7\ncallback.tick.does = []\n')
    calls = '"monitor.on_tick.calls_level"'
    before = tmp_path / "before.sym.xmi"
    run("import", "-q", "--source", source, "-o", before)
    assert calls in before.read_text()
    status, _ = run("import", "-q", "--source", source, "-o", model)
    assert status == 0 and 'threads="7"' in model.read_text() and calls not in model.read_text()


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("--source", "nowhere"), "folder of source code does not exist"),
        (("--source", ".", "--bag", "b"), "--source cannot be combined with --bag"),
        (("--source", ".", "--domain", "7"), "--domain requires --graph"),
        (("--facts", "f.json"), "--facts requires --source"),
        (("--source", ".", "x:=1"), "ARG:=VALUE"),
        (("--source", ".", "--launch", "no.launch.py"), "there is no launch file no.launch.py"),
        (("--source", "."), "the source code contains no node"),
    ],
)
def test_wrong_use_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], expected: str
) -> None:
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(main, ["import", *words, "-o", "m.sym.xmi"])
    assert result.exit_code == 2 and expected in result.stderr


def test_code_of_ros1_is_named(tmp_path: Path) -> None:
    (tmp_path / "teleop.py").write_text("import rospy\n\nrospy.init_node('teleop')\n")
    result = CliRunner().invoke(
        main, ["import", "--source", str(tmp_path), "-o", str(tmp_path / "m.sym.xmi")]
    )
    assert result.exit_code == 2 and f"{tmp_path}/teleop.py is code of ROS 1" in result.stderr


def test_facts_are_written(tmp_path: Path) -> None:
    source = files(tmp_path, battery=BATTERY)
    facts = tmp_path / "facts.json"
    run("import", "-q", "--source", source, "-o", tmp_path / "m.sym.xmi", "--facts", facts)
    found: dict[str, Any] = json.loads(facts.read_text())
    assert found["nodes"][0]["services"][0]["at"] == "battery.py:15"


@pytest.mark.long
def test_a_call_that_gives_up_hangs_nothing(tmp_path: Path) -> None:
    model = tmp_path / "robot.sym.xmi"
    text = MONITOR.replace("GROUP", "").replace("Trigger.Request())", "Trigger.Request(), timeout_sec=2.0)")
    run("import", "-q", "--source", files(tmp_path, battery=BATTERY, monitor=text), "-o", model)
    assert 'timeout="2"' in model.read_text()
    _, found = run("check", "-q", model)
    assert "callback-deadlock" not in found


def test_a_time_out_that_is_not_known_is_one(tmp_path: Path) -> None:
    """Without it, a deadlock would be found that the code cannot have."""
    model = tmp_path / "robot.sym.xmi"
    text = MONITOR.replace("GROUP", "").replace("Trigger.Request())", "Trigger.Request(), timeout_sec=limit)")
    source = files(tmp_path, battery=BATTERY, monitor=text)
    words = ["import", "-v", "--source", str(source), "-o", str(model)]
    result = CliRunner().invoke(main, words)
    assert 'timeout="1"' in model.read_text()
    assert "with an unknown time-out; 1 s is assumed" in result.stderr


def test_what_the_main_function_does_belongs_to_the_node_whose_ports_it_uses(tmp_path: Path) -> None:
    source = files(
        tmp_path,
        both="""
        rclpy.init()
        first, second = Node("first"), Node("second")
        out = second.create_publisher(String, "out", 1)
        first.create_timer(1.0, lambda: out.publish(String()))
        out.publish(String())
        for node in (first, second): SingleThreadedExecutor().add_node(node)
        """,
    )
    found = read(source)
    assert steps(found, "/second") == {"main": ["publish /out ?"]}
    assert steps(found, "/first") == {} and any(
        "no executor spins node /first" in line for line in found.taken
    )


TWO_CLIENTS = """
class Monitor(Node):
    def __init__(self):
        super().__init__("monitor")
        self.own = self.create_client(Trigger, "level", callback_group=MutuallyExclusiveCallbackGroup())
        self.plain = self.create_client(Trigger, "level")
        self.create_timer(0.1, self.tick)
    def tick(self):
        self.CLIENT.call(Trigger.Request())
def main():
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=2)
    executor.add_node(Monitor())
    executor.spin()
if __name__ == "__main__":
    main()
"""


@pytest.mark.parametrize("client", ["own", "plain"])
def test_several_clients_of_one_service_have_their_groups(tmp_path: Path, client: str) -> None:
    source = files(tmp_path, battery=BATTERY, monitor=TWO_CLIENTS.replace("CLIENT", client))
    (channel,) = [each for each in model_of(source).channels if isinstance(each, sym.ServiceChannel)]
    (port,) = channel.clients
    assert (port.group is not None) == (client == "own")
    status, text = run("check", "-q", "--source", source)
    assert ("[callback-deadlock]" in text) == (client == "plain") and status == int(client == "plain")


def test_sleeps_and_what_people_say_are_durations(tmp_path: Path) -> None:
    text = MONITOR.replace("GROUP", "").replace(
        "        self.ask()\n", "        time.sleep(0.2)\n        self.ask()\n"
    )
    source = files(tmp_path, battery=BATTERY, monitor=text)
    model = tmp_path / "robot.sym.xmi"
    given = tmp_path / "robot.given.toml"
    given.write_text(
        '[node."/battery"]\ncallback."/level".takes = [0.01, 0.5]\ncallback."/level".does = []\n'
    )
    assert run("import", "-q", "--source", source, "-o", model)[0] == 0
    pages = {page.id: page.duration for page in elements(load(model)) if isinstance(page, sym.CallbackPage)}
    (tick,) = [each for id, each in pages.items() if id.endswith("on_tick")]
    (level,) = [each for id, each in pages.items() if id.endswith("serves_level")]
    assert tick is not None and (tick.earliest, tick.latest) == (0.2, None)
    assert level is not None and (level.earliest, level.latest) == (0.01, 0.5)
    given.write_text('[node."/battery"]\ncallback."/level".takes = [2, 1]\n')
    assert run("import", "-q", "--source", source, "-o", model)[0] == 2


def test_people_say_in_which_order_an_executor_takes_callbacks(tmp_path: Path) -> None:
    source = files(tmp_path, battery=BATTERY, monitor=MONITOR.replace("GROUP", ""))
    model, given = tmp_path / "robot.sym.xmi", tmp_path / "robot.given.toml"
    given.write_text('[node."/battery"]\norder = "any"\n')
    assert run("import", "-q", "--source", source, "-o", model)[0] == 0
    orders = {net.name or net.id: str(net.order) for net in node_nets(load(model))}
    assert orders == {"battery": "any", "monitor": "any"}
    given.write_text('[node."/battery"]\norder = "fifo"\n')
    assert run("import", "-q", "--source", source, "-o", model)[0] == 2


def test_a_sleep_that_may_be_left_out_is_no_duration(tmp_path: Path) -> None:
    text = MONITOR.replace("GROUP", "").replace(
        "self.ask()\n    def", "time.sleep(0.2) if self.x else 0\n    def"
    )
    model = model_of(files(tmp_path, battery=BATTERY, monitor=text))
    assert not [each for each in elements(model) if isinstance(each, sym.CallbackPage) and each.duration]


@pytest.mark.parametrize(
    ("durability", "is_proved"), [("VOLATILE", True), ("LATCHED", False), ("OPEN", False)]
)
def test_an_open_quality_of_service_makes_every_proof_one_under_an_assumption(
    tmp_path: Path, durability: str, is_proved: bool
) -> None:
    """The ports may not match then: the reader's callback is dead with one of the values."""
    text = """
    import sys
    from rclpy.qos import DurabilityPolicy, QoSProfile
    VOLATILE, LATCHED = DurabilityPolicy.VOLATILE, DurabilityPolicy.TRANSIENT_LOCAL
    OPEN = LATCHED if len(sys.argv) > 1 else VOLATILE
    class Talk(Node):
        def __init__(self):
            super().__init__("talk")
            self.news = self.create_publisher(String, "news", QoSProfile(depth=1, durability=VOLATILE))
            self.create_timer(1.0, lambda: self.news.publish(String()))
    class Hear(Node):
        def __init__(self):
            super().__init__("hear")
            self.create_subscription(String, "news", self.on_news, QoSProfile(depth=1, durability=READER))
        def on_news(self, message): pass
    def main():
        rclpy.init()
        executor = MultiThreadedExecutor(num_threads=2)
        for node in (Talk(), Hear()): executor.add_node(node)
        executor.spin()
    if __name__ == "__main__": main()
    """
    source = files(tmp_path, both=text.replace("READER", durability))
    told = json.loads(run("check", "--source", source, "--json", "--timeout", 60)[1])
    can_fire = "every transition can fire, every channel is used"
    assert (can_fire in told["proved"]) is is_proved
    assert (can_fire in told.get("assumed", [])) is (durability == "OPEN")


def test_each_function_that_unknown_code_calls_is_a_callback_of_its_own(tmp_path: Path) -> None:
    """Nothing says which thread runs it: it has a group of its own, its own line, and no period."""
    source = files(
        tmp_path,
        robot="""
        import vendor
        class Robot(Node):
            def __init__(self):
                super().__init__("robot")
                self.out = self.create_publisher(String, "out", 1)
                self.log = self.create_publisher(String, "log", 1)
                self.out.publish(String())
                vendor.Device(on_data=self.heard, on_error=lambda text: self.failed(text), on_end=self.ended)
            def heard(self, data): self.out.publish(String())
            def failed(self, text): self.log.publish(String())
            def ended(self): pass
        rclpy.init()
        rclpy.spin(Robot())
        """,
    )
    found = read(source)
    assert steps(found, "/robot") == {
        "main": ["publish /out ?"],
        "heard": ["publish /out ?"],
        "lambda_failed": ["publish /log ?"],
    }
    node = found.given.nodes["/robot"]
    assert node.open_timers == set(node.callbacks)
    assert len({each.group for each in node.callbacks.values()}) == 3 == len(node.groups)
    lines = [each.at.rpartition(":")[2] for each in node.callbacks.values()]
    assert len(set(lines)) == 3


def test_a_thread_that_is_too_deep_to_be_read_is_named(tmp_path: Path) -> None:
    steps = "".join(
        f"            def step{number}(self):\n                self.step{number + 1}()\n"
        for number in range(MOST_CALLS + 1)
    )
    source = files(
        tmp_path,
        robot="""
        import threading
        class Robot(Node):
            def __init__(self):
                super().__init__("robot")
                self.pub = self.create_publisher(String, "out", 10)
                threading.Thread(target=self.step0).start()
"""
        + steps
        + f"            def step{MOST_CALLS + 1}(self):\n                self.pub.publish(String())\n",
    )
    (line,) = read(source).lacks
    assert line.endswith("not all that the thread step0 does could be read; omitted in the model")


HEALTHY = {
    "robot": """
    from diagnostic_updater import Updater

    class Robot(Node):
        def __init__(self):
            super().__init__('robot')
            self.updater = Updater(self, 0.5)

    class Watch(Node):
        def __init__(self):
            super().__init__('watch')
            self.create_subscription(DiagnosticArray, '/diagnostics', self.heard, 10)

        def heard(self, message):
            pass

    def main():
        rclpy.init()
        executor = SingleThreadedExecutor()
        robot, watch = Robot(), Watch()
        executor.add_node(robot)
        executor.add_node(watch)
        executor.spin()
    """,
}
IN_CPP = """
#include <rclcpp/rclcpp.hpp>
#include <diagnostic_updater/diagnostic_updater.hpp>
class Robot : public rclcpp::Node {
 public:
  Robot() : rclcpp::Node("robot"), updater_(this, 0.5) {
    sub_ = create_subscription<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics", 10,
      [this](diagnostic_msgs::msg::DiagnosticArray::SharedPtr) {});
  }
  diagnostic_updater::Updater updater_;
  rclcpp::Subscription<diagnostic_msgs::msg::DiagnosticArray>::SharedPtr sub_;
};
int main() { rclcpp::init(0, nullptr); rclcpp::spin(std::make_shared<Robot>()); }
"""


@pytest.mark.parametrize("language", ["python", "cpp"])
def test_timers_of_libraries_publish(tmp_path: Path, language: str) -> None:
    if language == "cpp":
        source = tmp_path / "code"
        source.mkdir()
        (source / "robot.cpp").write_text(IN_CPP)
    else:
        source = files(tmp_path, **HEALTHY)
    _, text = run("check", "-q", "-v", "--source", source)
    assert "unused-topic" not in text and "not-live" not in text, text
    (robot,) = [node for node in read_source(source).nodes if node.name == "robot"]
    (timer,) = robot.of("timers")
    (effect,) = timer.callbacks["callback"].effects
    assert timer.details["period"] == 0.5
    assert (effect.do, effect.when) == ("publish", "always")
    assert effect.entity is not None and effect.entity.name == "/diagnostics"
