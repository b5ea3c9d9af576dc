"""What callbacks do: in order, through helpers, and how they wait."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.sources.support import details, effects, facts_of, node_of, one

MADE = """
def __init__(self):
    super().__init__("robot")
    self.pub = self.create_publisher(String, "out", 1)
    self.cli = self.create_client(Trigger, "ask")
    self.lock, self.fresh = threading.Lock(), threading.Event()
    self.nav = ActionClient(self, Fibonacci, "go")
    self.timer = self.create_timer(1, self.tick)
"""
IMPORTS = """
import threading, time, functools
from rclpy.action import ActionClient
from example_interfaces.action import Fibonacci
"""


def tick_of(folder: Path, body: str, more: str = "") -> dict[str, Any]:
    """Return the node whose timer does something."""
    lines = "\n".join(f"    {line}" for line in body.strip().splitlines())
    return node_of(folder, f"{MADE}\ndef tick(self):\n{lines}\n{more}", before=IMPORTS)


def test_order_and_when(tmp_path: Path) -> None:
    node = tick_of(
        tmp_path,
        "self.pub.publish(String())\nif self.x: self.pub.publish(String(data='x'))\n"
        "for each in self.many:\n    self.pub.publish(each)\ntime.sleep(0.5)",
    )
    assert effects(node, "tick") == [
        ("publish", "self.pub", "always"),
        ("publish", "self.pub", "conditional"),
        ("publish", "self.pub", "in a loop"),
        ("sleep", "0.5", "always"),
    ]


def test_what_stands_behind_a_return_is_conditional(tmp_path: Path) -> None:
    node = tick_of(tmp_path, "if self.x:\n    return\nself.pub.publish(String())")
    assert effects(node, "tick") == [("publish", "self.pub", "conditional")]


def test_helpers_are_followed_and_end_what_they_return_from(tmp_path: Path) -> None:
    node = tick_of(
        tmp_path,
        "self.first()\nself.pub.publish(String())",
        "def first(self):\n    if self.x: return\n    self.second(self.cli)\n"
        "def second(self, client):\n    client.call(Trigger.Request())\n",
    )
    assert effects(node, "tick") == [
        ("call", "self.cli", "conditional"),
        ("publish", "self.pub", "always"),
    ]


def test_recursion_ends(tmp_path: Path) -> None:
    node = tick_of(tmp_path, "self.pub.publish(String())\nself.tick()")
    assert effects(node, "tick")[0] == ("publish", "self.pub", "always")


WAITS = {
    "self.cli.call(Trigger.Request())": ("call", "blocks, without time-out", None),
    "self.cli.call(Trigger.Request(), timeout_sec=2.0)": ("call", "blocks, time-out 2 s", 2.0),
    "self.cli.call_async(Trigger.Request())": ("call", "async and ignored", None),
    "self.kept = self.cli.call_async(Trigger.Request())": ("call", "async", None),
    "f = self.cli.call_async(Trigger.Request()); f.add_done_callback(self.on)": (
        "call",
        "async with on",
        None,
    ),
    "self.cli.call_async(Trigger.Request()).add_done_callback(lambda f: self.on(f))": (
        *("call", "async with lambda -> on"),
        None,
    ),
    "self.cli.wait_for_service()": ("wait_for_service", "without time-out", None),
    "self.cli.wait_for_service(timeout_sec=1.0)": ("wait_for_service", "time-out 1 s", 1.0),
    "self.nav.wait_for_server(3)": ("wait_for_server", "time-out 3 s", 3.0),
    "self.nav.send_goal_async(Fibonacci.Goal())": ("send_goal", "async and ignored", None),
    "time.sleep(5)": ("sleep", "time.sleep", 5.0),
    "self.fresh.wait(1.5)": ("wait", "time-out 1.5 s", 1.5),
    "self.fresh.wait()": ("wait", "without time-out", None),
    "rclpy.spin_once(self, timeout_sec=0.1)": ("spin_once", "rclpy, its own node, time-out 0.1 s", 0.1),
    "rclpy.spin(self)": ("spin", "rclpy, its own node, without time-out", None),
}


@pytest.mark.parametrize(("code", "expected"), WAITS.items())
def test_how_it_waits(tmp_path: Path, code: str, expected: tuple[str, str, float | None]) -> None:
    found = details(tick_of(tmp_path, code, "def on(self, future): pass"), "tick")
    assert (found["do"], found["how"], found.get("timeout")) == expected


def test_asynchronous_calls_that_are_waited_for(tmp_path: Path) -> None:
    node = node_of(
        tmp_path,
        f"{MADE}\nasync def tick(self):\n    await self.cli.call_async(Trigger.Request())\n",
        before=IMPORTS,
    )
    assert details(node, "tick")["how"] == "await"
    assert next(each for each in node["callbacks"] if each["name"] == "tick")["async"] is True
    code = "f = self.cli.call_async(Trigger.Request())\nwhile not f.done():\n    time.sleep(0.01)"
    polled = tick_of(tmp_path, code)
    assert [each["how"] for each in polled["callbacks"][0]["effects"] if each["do"] == "call"] == ["polled"]
    code = "f = self.cli.call_async(Trigger.Request())\nrclpy.spin_until_future_complete(self, f)"
    spun = tick_of(tmp_path, code)
    assert [(each["do"], each["how"]) for each in spun["callbacks"][0]["effects"]] == [
        *(("call", "spin-until"), ("spin_until", "rclpy, its own node, without time-out")),
    ]


def test_goals_are_followed_from_callback_to_callback(tmp_path: Path) -> None:
    node = tick_of(
        tmp_path,
        "future = self.nav.send_goal_async(Fibonacci.Goal(), feedback_callback=self.on_feedback)\n"
        "future.add_done_callback(self.accepted)",
        """
def accepted(self, future):
    self.goal = future.result()
    if not self.goal.accepted:
        return
    self.goal.get_result_async().add_done_callback(self.ended)
def ended(self, future):
    self.pub.publish(String())
def on_feedback(self, message):
    self.goal.cancel_goal_async()
""",
    )
    assert effects(node, "accepted") == [("get_result", "goal", "conditional")]
    assert effects(node, "ended") == [("publish", "self.pub", "always")]
    assert effects(node, "on_feedback") == [("cancel_goal", "goal", "always")]
    kinds = {each["name"]: each["kind"] for each in node["callbacks"]}
    assert kinds["accepted"] == kinds["ended"] == "done callback" and kinds["on_feedback"] == "feedback"


def test_an_action_server_does_what_its_callbacks_say(tmp_path: Path) -> None:
    node = node_of(
        tmp_path,
        """
        def __init__(self):
            super().__init__("robot")
            self.queue = collections.deque()
            ActionServer(self, Fibonacci, "go", self.execute, goal_callback=lambda g: GoalResponse.ACCEPT,
                handle_accepted_callback=self.accepted, cancel_callback=self.cancel)
        def accepted(self, handle):
            self.queue.append(handle)
            self.queue.popleft().execute()
        def cancel(self, handle): return CancelResponse.ACCEPT
        def execute(self, goal):
            while not goal.is_cancel_requested:
                goal.publish_feedback(Fibonacci.Feedback())
                time.sleep(0.1)
            goal.canceled()
            return Fibonacci.Result()
        """,
        before=IMPORTS
        + "import collections\nfrom rclpy.action import ActionServer, CancelResponse, GoalResponse\n",
    )
    assert effects(node, "accepted") == [("execute_goal", "goal", "always")]
    assert [each[0] for each in effects(node, "execute")] == [
        *("loop", "publish_feedback", "sleep", "wait", "canceled")
    ]
    assert {each["kind"] for each in node["callbacks"]} == {"execute", "goal", "cancel", "accepted"}


def test_locks_are_held_until_their_end(tmp_path: Path) -> None:
    node = tick_of(
        tmp_path,
        "with self.lock:\n    self.cli.call(Trigger.Request())\nself.lock.acquire()\ntime.sleep(1)\n"
        "self.lock.release()\nself.pub.publish(String())",
    )
    found = node["callbacks"][0]["effects"]
    held = [(each["do"], each.get("holding", [])) for each in found if each["do"] != "lock"]
    assert held == [("call", ["self.lock"]), ("sleep", ["self.lock"]), ("publish", [])]


def test_threads_partials_and_timers_that_callbacks_make(tmp_path: Path) -> None:
    node = tick_of(
        tmp_path,
        "threading.Thread(target=self.work, args=(3,)).start()\n"
        "self.once = self.create_timer(2.0, functools.partial(self.late, 'x'))\nself.once.cancel()",
        "def work(self, seconds):\n    time.sleep(seconds)\n"
        "def late(self, text):\n    self.pub.publish(String())",
    )
    assert [each[0] for each in effects(node, "tick")] == ["thread", "create_timer", "cancel_timer"]
    assert effects(node, "work") == [("sleep", "3", "always")]
    assert effects(node, "late") == [("publish", "self.pub", "always")]
    assert [each["callback"] for each in node["timers"]] == ["tick", "partial(late)"]


def test_what_main_waits_for_before_it_spins(tmp_path: Path) -> None:
    node = one(
        facts_of(
            tmp_path,
            """
            def main():
                rclpy.init()
                node = rclpy.create_node("asker")
                client = node.create_client(Trigger, "ask")
                while not client.wait_for_service(timeout_sec=1.0):
                    node.get_logger().info("waits")
                future = client.call_async(Trigger.Request())
                rclpy.spin_until_future_complete(node, future)
            if __name__ == "__main__": main()
            """,
        )
    ).to_json()
    assert [each for each in effects(node, "main") if each[0] != "loop"] == [
        ("wait_for_service", "client", "in a loop"),
        ("call", "client", "always"),
        ("spin_until", "future", "always"),
    ]
    assert node["threads"] == 1


def test_idioms_of_libraries(tmp_path: Path) -> None:
    node = node_of(
        tmp_path,
        """
        def __init__(self):
            super().__init__("robot")
            left = message_filters.Subscriber(self, String, "left")
            right = message_filters.Subscriber(self, String, "right", qos_profile=qos_profile_sensor_data)
            self.both = message_filters.ApproximateTimeSynchronizer([left, right], 10, 0.1)
            self.both.registerCallback(self.on_both)
            self.tf = TransformBroadcaster(self)
            self.listener = TransformListener(Buffer(), self)
        def on_both(self, one, other): self.tf.sendTransform(one)
        """,
        before="""
        import message_filters
        from rclpy.qos import qos_profile_sensor_data
        from tf2_ros import Buffer, TransformBroadcaster, TransformListener
        """,
    )
    found = [(each["name"], each["depth"], each.get("callback")) for each in node["subscriptions"]]
    assert found == [
        ("left", 10, "on_both"),
        ("right", 5, "on_both"),
        ("/tf", 100, None),
        ("/tf_static", 100, None),
    ]
    assert [(each["name"], each["type"]) for each in node["publishers"]] == [
        ("/tf", "tf2_msgs/msg/TFMessage")
    ]
    assert effects(node, "on_both") == [("publish", "self.tf", "always")]


def test_an_event_of_the_function_around(tmp_path: Path) -> None:
    """`nonlocal` names the variable of the enclosing function, not one of the module."""
    node = tick_of(
        tmp_path,
        "fresh = threading.Event()\ndef done(future):\n    nonlocal fresh\n    fresh.set()\n"
        "self.cli.call_async(Trigger.Request()).add_done_callback(done)\nfresh.wait()",
    )
    assert effects(node, "done") == [("notify", "fresh", "always")]


def test_a_variable_of_the_module_is_assigned_in_an_inner_function(tmp_path: Path) -> None:
    node = tick_of(
        tmp_path,
        "seconds = 2.0\ndef inner():\n    global seconds\n    seconds = 0.5\ninner()\ntime.sleep(seconds)",
    )
    assert effects(node, "tick") == [("sleep", "2.0", "always")]


@pytest.mark.parametrize("call", ["self.work(2)", "self.work, 2"])
def test_a_coroutine_that_the_executor_runs_is_a_task(tmp_path: Path, call: str) -> None:
    """It holds no group. Before, the callback that makes it seemed to await what it awaits."""
    node = tick_of(
        tmp_path,
        f"self.executor.create_task({call})",
        "async def work(self, count):\n    await self.cli.call_async(Trigger.Request())\n"
        "    self.pub.publish(String())\n",
    )
    assert effects(node, "tick") == []
    assert effects(node, "work") == [("call", "self.cli", "always"), ("publish", "self.pub", "always")]
