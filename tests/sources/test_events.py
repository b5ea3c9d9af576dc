"""Functions that code outside of the folder calls, and callbacks that schedule themselves again."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sources.support import effects, facts_of, indented, node_of, one

_ROBOT = """
def __init__(self):
    super().__init__("robot")
    self.pub = self.create_publisher(String, "out", 1)
    START
def heard(self, data): self.pub.publish(String())
def nothing(self, data): self.last = data
"""


@pytest.mark.parametrize(
    "start",
    [
        "self.listener = keyboard.Listener(on_press=self.heard)",
        "self.listener = keyboard.Listener(on_press=lambda key: self.heard(key))",
        "self.device = vendor.Device(); self.device.port.opened.add_callback(self.heard)",
        "self.device = vendor.Device(); self.device.on_data = self.heard",
        "vendor.listen({'data': [self.heard]})",
        "vendor.listen(functools.partial(self.heard, 1))",
        "list(map(self.heard, [1, 2]))",
        "app = vendor.App()\n    @app.route('/data')\n    def serve(): self.pub.publish(String())",
    ],
)
def test_functions_that_unknown_code_receives_are_read(tmp_path: Path, start: str) -> None:
    """They run as callbacks of events: without them the publisher would look silent."""
    node = node_of(tmp_path, _ROBOT.replace("START", start), before="import vendor, keyboard, functools")
    found = [each for each in node["callbacks"] if each["kind"] == "event"]
    assert [one["do"] for each in found for one in each["effects"]] == ["publish"]


@pytest.mark.parametrize(
    "start",
    [
        "self.listener = keyboard.Listener(on_press=self.nothing)",
        "self.get_logger().info(self.heard)",
        "print(self.heard)",
        "self.thread = threading.Thread(target=self.heard, args=(1,)); self.thread.start()",
        "self.create_subscription(String, 'in', self.heard, 1)",
    ],
)
def test_other_functions_are_no_events(tmp_path: Path, start: str) -> None:
    """They do nothing with ROS, are not called, or have another caller."""
    node = node_of(tmp_path, _ROBOT.replace("START", start), before="import keyboard, threading")
    assert not [each for each in node["callbacks"] if each["kind"] == "event"]


def test_ports_that_an_event_makes_are_read(tmp_path: Path) -> None:
    body = _ROBOT.replace("START", "vendor.connect(self.connected)")
    made = "def connected(self): self.create_service(Trigger, 'reset', self.reset)\n"
    node = node_of(tmp_path, f"{body}{made}def reset(self, a, b): return b", before="import vendor")
    assert [each["name"] for each in node["services"]] == ["reset"]


def test_a_node_that_an_event_spins_is_spun(tmp_path: Path) -> None:
    """As in programs with windows, whose timer spins the node."""
    main = "def main():\n    rclpy.init()\n    node = Robot()\n"
    after = f"{main}    vendor.every(1, lambda: rclpy.spin_once(node))\n"
    node = node_of(tmp_path, _ROBOT.replace("START", "pass"), before="import vendor", after=after)
    assert node["threads"] == 1


_AGAIN = """
class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.cli = self.create_client(Trigger, "ask")
        self.pubs = [self.create_publisher(String, "a", 1), self.create_publisher(String, "b", 1)]
        self.send(START)

    def send(self, at):
        request = Trigger.Request()
        helper = Helper()
        future = self.cli.call_async(request)
        DONE

    def again(self, at, *more):
        self.pubs[at % 2].publish(String())
        self.send(NEXT)

class Helper: pass

def main():
    rclpy.init()
    rclpy.spin(Robot())

if __name__ == "__main__":
    main()
"""


@pytest.mark.parametrize("start, following", [("0", "at"), ("0", "at + 1"), ("self.x", "at + 1")])
@pytest.mark.parametrize(
    "done",
    [
        "future.add_done_callback(lambda future: self.again(at))",
        "future.add_done_callback(lambda future: self.again(at, request, helper))",
        "def done(future): self.again(at, helper)\n        future.add_done_callback(done)",
        "self.timer = self.create_timer(at + 1.0, lambda: self.again(at if self.x else 3))",
    ],
)
def test_callbacks_that_schedule_themselves_again_come_to_an_end(
    tmp_path: Path, start: str, following: str, done: str
) -> None:
    """With other values each time they are read a few times, then with any value."""
    text = _AGAIN.replace("START", start).replace("NEXT", following).replace("DONE", done)
    facts = facts_of(tmp_path, text)
    assert not facts.unread
    node = one(facts)
    found = [each for each in node.callbacks if each.kind in ("done callback", "timer")]
    assert 1 <= len(found) <= 8
    assert all({"publish", "call"} <= {effect.do for effect in each.effects} for each in found)
    assert not any(each.is_open for each in node.callbacks)


def test_too_many_events_do_not_open_the_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What they do is listed as not read; all other callbacks are as certain as before."""
    monkeypatch.setattr("dineros.sources.programs.callbacks.MOST_STEPS_OF_EVENTS", 3)
    start = "vendor.listen(self.heard)\n    self.create_timer(1, self.tick)"
    body = _ROBOT.replace("START", start) + "def tick(self): self.pub.publish(String())\n"
    text = f"import vendor\nclass Robot(Node):\n{indented(body)}\nrclpy.init()\nrclpy.spin(Robot())\n"
    facts = facts_of(tmp_path, text)
    assert [each.partition(": ")[2] for each in facts.unread] == [
        "the functions that libraries receive are too large to be read completely"
    ]
    node = one(facts).to_json()
    assert effects(node, "tick") == [("publish", "self.pub", "always")]
    assert not any(each.get("open") for each in node["callbacks"] if each["name"] == "tick")
