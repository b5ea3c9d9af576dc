"""Loops of callbacks whose attributes have one value in the program, and loops that ask for variables."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.observation.findings.code import code_findings
from dineros.sources.reading import read_source
from tests.support.programs.coded import files, read, run

ROBOT = """
import threading
moved = False
class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.ready = self.debug = False
        self.x, self.items = 0.0, []
        INIT
        self.create_subscription(String, "in", self.heard, 10)
        self.create_service(Trigger, "go", self.go, callback_group=GROUP)
    def heard(self, message):
        HEARD
    def is_ready(self):
        return self.ready
    def go(self, request, response):
        BODY
        return response
def main():
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=2)
    executor.add_node(Robot())
    executor.spin()
if __name__ == "__main__":
    main()
"""
SLEEPS = "time.sleep(0.1)"


def found(folder: Path, body: str, heard: str = "pass", group: str = "None", init: str = "pass") -> list[str]:
    """Return what is found in the service of a robot, and what its model assumes."""
    text = ROBOT.replace("BODY", body).replace("HEARD", heard).replace("GROUP", group).replace("INIT", init)
    source = files(folder, robot=text)
    findings = [f"{each.severity} {each.rule}" for each in code_findings([("src", read_source(source))])]
    return findings + ["assumed" for each in read(source).taken if "continues at once" in each]


@pytest.mark.parametrize(
    "body",
    [
        f"while not self.ready: {SLEEPS}",
        f"while rclpy.ok() and not self.ready: {SLEEPS}",
        f"while not self.is_ready(): {SLEEPS}",
        f"self.ready = False\n        while not self.ready: {SLEEPS}",
        f"while True:\n            if self.ready: break\n            {SLEEPS}",
        "while True:\n            if not self.ready:\n                time.sleep(0.1)\n"
        "                continue\n            break",
        f"while not self.ready:\n            self.get_logger().info('waits')\n            {SLEEPS}",
        f"while self.x < 3: {SLEEPS}",
    ],
)
def test_an_attribute_with_one_value_ends_no_loop(tmp_path: Path, body: str) -> None:
    """The service never ends: nothing was found before, and all was proved."""
    assert found(tmp_path, body) == ["error code-never-ends"]


@pytest.mark.parametrize(
    ("body", "heard", "init"),
    [
        ("if self.debug: self.get_logger().info('go')", "pass", "pass"),
        (f"while self.debug: {SLEEPS}", "pass", "pass"),
        ("while self.x < 3: self.x += 1", "pass", "pass"),
        (
            "count = 0\n        while not self.ready and count < 9:\n            count += 1; time.sleep(0.1)",
            "pass",
            "pass",
        ),
    ],
)
def test_switches_and_loops_that_end_are_left_alone(tmp_path: Path, body: str, heard: str, init: str) -> None:
    assert found(tmp_path, body, heard, init=init) == []


@pytest.mark.parametrize(
    ("body", "init"),
    [
        (f"while not self.ready: {SLEEPS}", "Library(self)"),
        (f"while not self.ready: {SLEEPS}", "self.ready = self.declare_parameter('ready', False).value"),
        (f"while not self.ready: {SLEEPS}", "setattr(self, name(), 1)"),
        (f"while not self.ready:\n            self.arm.step()\n            {SLEEPS}", "self.arm = Arm()"),
        (f"while len(self.items) < 3: {SLEEPS}", "arm.connect(self.items)"),
    ],
)
def test_what_unknown_code_may_end_is_an_assumption(tmp_path: Path, body: str, init: str) -> None:
    """Nothing was said before, although nothing in the program ends the loop."""
    assert found(tmp_path, body, init=init) == ["assumed"]


@pytest.mark.parametrize(
    ("body", "heard", "init"),
    [
        (f"goal = self.x + 1\n        while self.x < goal: {SLEEPS}", "self.x = message.x", "pass"),
        (
            f"start = self.x\n        while abs(self.x - start) < request.far: {SLEEPS}",
            "self.x = message.x",
            "pass",
        ),
        (
            "last = self.x\n        while True:\n            time.sleep(0.1)\n"
            "            if self.x == last: continue\n            break",
            "self.x = message.x",
            "pass",
        ),
        (f"while not moved: {SLEEPS}", "global moved; moved = True", "pass"),
        (
            f"while not self.items: {SLEEPS}",
            "pass",
            "self.create_subscription(String, 'other', self.items.append, 10)",
        ),
        ("self.event.wait()", "self.event.set()", "self.event = threading.Event()"),
    ],
)
@pytest.mark.parametrize("is_own", [False, True])
def test_loops_compare_with_local_and_global_variables(
    tmp_path: Path, body: str, heard: str, init: str, is_own: bool
) -> None:
    """What ends the loop needs the group of the service, unless that has its own."""
    group = "MutuallyExclusiveCallbackGroup()" if is_own else "None"
    assert found(tmp_path, body, heard, group, init) == [
        *(["error code-waits-for-itself"] * (not is_own)),
        "assumed",
    ]


ASKS = """
class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.ask = self.create_client(Trigger, "ask"GROUP)
        self.create_service(Trigger, "go", self.go)
    def go(self, request, response):
        START
        def told(future):
            END
        self.ask.call_async(Trigger.Request()).add_done_callback(told)
        WAIT
        return response
def main():
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=2)
    executor.add_node(Robot())
    executor.spin()
if __name__ == "__main__":
    main()
"""


@pytest.mark.parametrize(
    ("start", "end", "wait"),
    [
        ("done = False", "nonlocal done; done = True", f"while not done: {SLEEPS}"),
        (
            "found, event = [], threading.Event()",
            "found.append(future.result()); event.set()",
            "event.wait()",
        ),
    ],
)
@pytest.mark.parametrize("is_own", [False, True])
def test_inner_functions_end_a_wait(tmp_path: Path, start: str, end: str, wait: str, is_own: bool) -> None:
    """A done callback begins when the group of its client is free: "8 proved" before."""
    group = ", callback_group=MutuallyExclusiveCallbackGroup()" if is_own else ""
    text = "import threading\n" + ASKS.replace("START", start).replace("END", end).replace("WAIT", wait)
    rules = [
        each.rule
        for each in code_findings([("src", read_source(files(tmp_path, robot=text.replace("GROUP", group))))])
    ]
    assert rules == ["code-waits-for-itself"] * (not is_own)


GUARD = """
class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.ask = self.create_client(Trigger, "ask"GROUP)
        self.create_service(Trigger, "ask", self.answer, callback_group=MutuallyExclusiveCallbackGroup())
        self.guard = self.create_guard_condition(self.fired)
        self.create_subscription(String, "in", lambda message: self.guard.trigger(), 10)
    def answer(self, request, response):
        return response
    def fired(self):
        self.ask.call(Trigger.Request())
def main():
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=4)
    executor.add_node(Robot())
    executor.spin()
if __name__ == "__main__":
    main()
"""


@pytest.mark.parametrize("is_own", [False, True])
def test_callbacks_of_guard_conditions_wait_in_their_group(tmp_path: Path, is_own: bool) -> None:
    """The model had nothing of such callbacks: "8 proved" before."""
    group = ", callback_group=MutuallyExclusiveCallbackGroup()" if is_own else ""
    _, text = run("check", "-q", "--source", files(tmp_path, robot=GUARD.replace("GROUP", group)))
    assert ("[callback-deadlock]" in text) == (not is_own), text


LOCKED = """
import queue, threading
class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.lock, self.event, self.items = threading.Lock(), threading.Event(), queue.Queue(maxsize=1)
        self.changed = threading.Condition(self.lock)
        self.create_subscription(String, "in", self.heard, 10)
        self.create_service(Trigger, "go", self.go, callback_group=MutuallyExclusiveCallbackGroup())
    def heard(self, message):
        HEARD
    def go(self, request, response):
        GO
        return response
def main():
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=4)
    executor.add_node(Robot())
    executor.spin()
if __name__ == "__main__":
    main()
"""


@pytest.mark.parametrize(
    ("go", "heard", "holds"),
    [
        ("with self.lock: self.event.wait()", "with self.lock: self.event.set()", True),
        ("with self.lock: self.items.put(1)", "self.items.get_nowait()\n        with self.lock: pass", True),
        ("self.event.wait()\n        with self.lock: pass", "with self.lock: self.event.set()", False),
        ("with self.lock: self.event.wait()", "self.event.set()", False),
        ("with self.lock: self.changed.wait()", "with self.lock: self.changed.notify()", False),
        ("with self.changed: self.changed.wait()", "with self.changed: self.changed.notify()", False),
    ],
)
def test_a_wait_under_a_lock_that_its_end_needs(tmp_path: Path, go: str, heard: str, holds: bool) -> None:
    text = LOCKED.replace("GO", go).replace("HEARD", heard)
    rules = [each.rule for each in code_findings([("src", read_source(files(tmp_path, robot=text)))])]
    assert rules == ["code-holds-lock"] * holds


LATE = """
class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.value = None
        self.create_service(Trigger, "read", self.read)
    def read(self, request, response):
        self.value = None
        self.create_subscription(String, "in", self.heard, 1)
        while self.value is None: time.sleep(0.1)
        return response
    def heard(self, message):
        self.value = message.data
def main():
    rclpy.init()
    rclpy.spin(Robot())
if __name__ == "__main__":
    main()
"""
CANCELS = """
class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.stopped = False
        ActionServer(self, Fibonacci, "go", self.work, cancel_callback=self.cancel)
    def cancel(self, goal):
        self.stopped = True
        return CancelResponse.ACCEPT
    def work(self, goal):
        while not self.stopped: time.sleep(0.1)
        goal.canceled()
        return Fibonacci.Result()
def main():
    rclpy.init()
    SPIN
if __name__ == "__main__":
    main()
"""
THREADS = "rclpy.spin(Robot(), executor=MultiThreadedExecutor(4))"


@pytest.mark.parametrize(
    ("text", "hangs"),
    [
        (LATE, True),
        (CANCELS.replace("SPIN", "rclpy.spin(Robot())"), True),
        (CANCELS.replace("SPIN", THREADS), False),
    ],
)
def test_variables_that_the_model_does_not_have(tmp_path: Path, text: str, hangs: bool) -> None:
    """A subscription made later and a callback of cancellations are not in the model: "8 proved" before."""
    text = text.replace("CancelResponse", "rclpy.action.CancelResponse")
    rules = [each.rule for each in code_findings([("src", read_source(files(tmp_path, robot=text)))])]
    assert rules == ["code-waits-for-itself"] * hangs


AWAITS = """
class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        group = ReentrantCallbackGroup()
        self.ask = self.create_client(Trigger, "ask", callback_group=group)
        self.create_timer(1.0, self.tick, callback_group=group)
    async def tick(self):
        await self.ask.call_async(Trigger.Request())
class Other(Node):
    def __init__(self):
        super().__init__("other")
        self.create_service(Trigger, "ask", self.answer)
    def answer(self, request, response):
        return response
def main():
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=2)
    executor.add_node(Robot())
    executor.add_node(Other())
    executor.spin()
if __name__ == "__main__":
    main()
"""


def test_runs_that_await_in_a_reentrant_group(tmp_path: Path) -> None:
    """Runs pile up only while responses take longer than the period: that is said, and not an error."""
    _, text = run("check", "-v", "--source", files(tmp_path, robot=AWAITS))
    assert "at most 2 runs" in text and "error" not in text and "[unbounded]" not in text, text
