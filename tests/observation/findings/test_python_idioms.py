"""Idioms of Python in rclpy programs: each fault next to a healthy program."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from dineros.observation.findings.code import code_findings
from dineros.sources.reading import read_source
from tests.support.programs.coded import files, read, run, steps

PROGRAM = """
import asyncio, concurrent.futures, contextlib, functools, queue, threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from rclpy.action import CancelResponse, GoalResponse
from rclpy.duration import Duration
from rclpy.wait_for_message import wait_for_message

class Guard:
    def __init__(self, lock):
        self.lock = lock
    def __enter__(self):
        self.lock.acquire()
    def __exit__(self, *error):
        self.lock.release()

@dataclass
class Part:
    node: Node
    lock: threading.Lock = field(default_factory=threading.Lock)
    def __post_init__(self):
        self.client = self.node.create_client(Trigger, "ask"GROUP)
        self.node.create_timer(1.0, self.tick)
    def tick(self):
        with self.lock:
            self.client.call(Trigger.Request())

class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.lock, self.again = threading.Lock(), threading.RLock()
        self.pool = ThreadPoolExecutor()
        self.rate = self.create_rate(10)
        self.first, self.any = queue.Queue(maxsize=1), queue.Queue()
        self.loop = asyncio.new_event_loop()
        self.cli = self.create_client(Trigger, "ask"GROUP)
        self.create_service(Trigger, "ask", self.on_ask, callback_group=MutuallyExclusiveCallbackGroup())
        group = MutuallyExclusiveCallbackGroup()
        self.create_subscription(String, "in", self.heard, 10, callback_group=group)
        INIT
    @contextlib.contextmanager
    def locked(self):
        self.lock.acquire()
        try:
            yield
        finally:
            self.lock.release()
    @property
    def pose(self):
        with self.lock:
            return self._pose
    @pose.setter
    def pose(self, value):
        with self.lock:
            self._pose = value
    def on_ask(self, request, response):
        with self.locked():
            response.success = True
        return response
    def heard(self, message):
        HEARD
    def work(self, *more):
        self.cli.call(Trigger.Request())
    async def ask(self):
        await self.cli.call_async(Trigger.Request())
    def tick(self):
        TICK

def main():
    rclpy.init()
    executor = MultiThreadedExecutor(THREADS)
    executor.add_node(Robot())
    executor.spin()

if __name__ == "__main__":
    main()
"""
OWN_GROUP = ", callback_group=MutuallyExclusiveCallbackGroup()"
TIMER = "self.create_timer(1.0, self.tick)"


def program(
    folder: Path, tick: str, heard: str = "pass", init: str = TIMER, threads: int = 1, group: str = OWN_GROUP
) -> Path:
    """Write a program; return its folder."""
    text = PROGRAM.replace("TICK", tick).replace("HEARD", heard).replace("INIT", init)
    return files(folder, robot=text.replace("THREADS", str(threads)).replace("GROUP", group))


def checked(folder: Path, tick: str, **words: Any) -> str:
    """Return what `check` prints for a program."""
    return run("check", "--source", program(folder, tick, **words))[1]


def shown(folder: Path, tick: str, **words: Any) -> list[str]:
    """Return the rules of code that `import` reports."""
    return rules(program(folder, tick, **words))


def calls(source: Path) -> list[str]:
    """Return the calls of all callbacks, as the model has them."""
    every = steps(read(source), "/robot").values()
    return [step for done in every for step in done or () if step.startswith("call")]


def rules(source: Path) -> list[str]:
    """Return the findings of code in a folder: severity and rule."""
    found = code_findings([("src", read_source(source))])
    return sorted({f"{each.severity} {each.rule}" for each in found})


@pytest.mark.parametrize(
    "tick",
    [
        "with ThreadPoolExecutor() as pool: pool.submit(self.work)",
        "list(self.pool.map(self.work, [1]))",
        "self.pool.submit(self.work); self.pool.shutdown()",
        "concurrent.futures.wait([self.pool.submit(self.work)])",
        "for each in concurrent.futures.as_completed([self.pool.submit(self.work)]): each.result()",
        "thread = threading.Thread(target=self.work); thread.start(); thread.join()",
        "asyncio.run(self.ask())",
        "self.loop.run_until_complete(self.ask())",
        "asyncio.run_coroutine_threadsafe(self.ask(), self.loop).result()",
    ],
)
def test_work_that_a_callback_waits_for(tmp_path: Path, tick: str) -> None:
    """On several threads, the response comes; a thread that is waited for runs once."""
    assert calls(program(tmp_path, tick)) == calls(program(tmp_path, tick, threads=3)) == ["call /ask"]


@pytest.mark.long
def test_a_thread_that_is_waited_for_runs_once(tmp_path: Path) -> None:
    tick = "thread = threading.Thread(target=self.work); thread.start(); thread.join()"
    assert "[callback-deadlock]" in checked(tmp_path, tick)
    assert "0 found" in checked(tmp_path, tick, threads=3)


@pytest.mark.parametrize("lock", ["self.locked()", "Guard(self.lock)", "self.lock"])
def test_locks_of_context_managers(tmp_path: Path, lock: str) -> None:
    """The service wants the lock that the caller holds."""
    assert shown(tmp_path, f"with {lock}: self.work()", threads=4) == ["warning code-holds-lock"]
    assert shown(tmp_path, f"with {lock}: self.last = 1", threads=4) == []


def test_locks_of_exit_stacks(tmp_path: Path) -> None:
    body = "with contextlib.ExitStack() as stack:\n            stack.enter_context(self.lock)\n            "
    assert shown(tmp_path, f"{body}self.work()", threads=4) == ["warning code-holds-lock"]


@pytest.mark.parametrize("use", ["print(self.pose)", "self.pose = 1"])
def test_properties_take_locks(tmp_path: Path, use: str) -> None:
    assert shown(tmp_path, f"with self.lock: {use}") == ["error code-waits-for-itself"]
    assert shown(tmp_path, f"with self.again: {use}") == []


@pytest.mark.parametrize(
    ("heard", "tick", "hangs"),
    [
        ("self.first.put(message)", "self.first.get_nowait()", True),
        ("self.first.put(message, True)", "self.first.get(False)", True),
        ("self.first.put(message, timeout=0.1)", "self.first.get_nowait()", False),
        ("self.first.put_nowait(message)", "self.first.get_nowait()", False),
        ("self.any.put(message)", "self.any.get_nowait()", False),
        ("self.any.join()", "self.any.task_done()", True),
    ],
)
def test_queues_with_little_room(tmp_path: Path, heard: str, tick: str, hangs: bool) -> None:
    assert shown(tmp_path, tick, heard=heard) == ["error code-waits-for-itself"] * hangs


@pytest.mark.parametrize(("threads", "hangs"), [(1, True), (2, True), (3, False)])
def test_rates_need_a_thread(tmp_path: Path, threads: int, hangs: bool) -> None:
    found = shown(tmp_path, "self.rate.sleep()", heard="self.rate.sleep()", threads=threads)
    assert found == ["error code-waits-for-itself"] * hangs


def test_tasks_of_executors(tmp_path: Path) -> None:
    assert shown(tmp_path, "self.executor.create_task(self.work)") == ["error code-waits-for-itself"]
    assert shown(tmp_path, "self.executor.create_task(self.ask)") == []


@pytest.mark.parametrize(
    ("tick", "init", "forgets"),
    [
        ("self.ask()", TIMER, True),
        ("pass", "self.create_timer(1.0, lambda: self.ask())", True),
        ("pass", "self.create_timer(1.0, self.ask)", False),
        ("pass", "self.create_timer(1.0, functools.partial(self.ask))", False),
    ],
)
def test_coroutines_that_nothing_awaits(tmp_path: Path, tick: str, init: str, forgets: bool) -> None:
    source = program(tmp_path, tick, init=init)
    assert rules(source) == ["warning code-never-awaits"] * forgets
    assert calls(source) == ["call /ask"] * (not forgets)


@pytest.mark.parametrize(
    ("tick", "rule"),
    [
        ("while not self.cli.wait_for_service(1.0): print('waiting')", "code-waits"),
        ("wait_for_message(String, self, 'in')", "code-waits"),
        ("wait_for_message(String, self, 'in', time_to_wait=-1)", "code-waits"),
        ("self.get_clock().sleep_for(Duration(seconds=5))", "code-sleeps"),
        ("while rclpy.ok(): self.last = 1", "code-never-ends"),
        ("while self.device.look_ok(): self.last = 1", None),
        ("wait_for_message(String, self, 'in', time_to_wait=0.1)", None),
        ("self.get_clock().sleep_for(Duration(nanoseconds=5))", None),
    ],
)
def test_waits(tmp_path: Path, tick: str, rule: str | None) -> None:
    assert [each for each in shown(tmp_path, tick) if "overruns" not in each] == [
        f"warning {each}" for each in [rule] if each
    ]


@pytest.mark.parametrize(
    ("tick", "seconds"),
    [
        ("for each in range(5): time.sleep(0.3)", "1.5"),
        ("for each in (1, 2): self.nap()", "1.2"),
        ("if self.late: return\n        self.nap(); self.nap()", "1.2"),
        ("if self.late: self.nap()\n        self.nap()", None),
        ("for each in range(3): time.sleep(0.3)", None),
        ("while self.late: time.sleep(0.3)", None),
    ],
)
def test_short_sleeps_add_up(tmp_path: Path, tick: str, seconds: str | None) -> None:
    """Ten sleeps of 0.2 s delay other callbacks as one of 2 s does; nothing was reported."""
    body = f"{tick}\n    def nap(self):\n        time.sleep(0.6)"
    found = code_findings([("src", read_source(program(tmp_path, body)))])
    words = [each.message for each in found if each.rule == "code-sleeps"]
    assert [f"sleeps {seconds} s in all" in each for each in words] == [True] * (seconds is not None)


OWN_EXECUTOR = (
    "SingleThreadedExecutor(); ex.add_node(NODE); ex.spin_until_future_complete(future, timeout_sec=T)"
)


@pytest.mark.parametrize(
    ("node", "timeout", "found"),
    [
        ("self.helper", "1.0", []),
        ("self.helper", "None", ["warning code-waits"]),
        ("self", "1.0", ["error code-spins"]),
    ],
)
def test_a_callback_spins_another_node(tmp_path: Path, node: str, timeout: str, found: list[str]) -> None:
    """An executor of its own that runs a helper node does not disturb the executor of the callback."""
    spin = OWN_EXECUTOR.replace("NODE", node).replace("=T", f"={timeout}")
    tick = f"future = self.asks.call_async(Trigger.Request()); ex = {spin}"
    init = "self.helper = rclpy.create_node('helper')\n        "
    init += f"self.asks = self.helper.create_client(Trigger, 'ask')\n        {TIMER}"
    assert shown(tmp_path, tick, init=init) == found


@pytest.mark.parametrize(("threads", "parties", "hangs"), [(1, 2, True), (3, 2, False), (1, 1, False)])
def test_barriers(tmp_path: Path, threads: int, parties: int, hangs: bool) -> None:
    init = f"self.both = threading.Barrier({parties})\n        {TIMER}"
    wait = "self.both.wait()"
    found = shown(tmp_path, wait, heard=wait, init=init, threads=threads)
    assert found == ["error code-waits-for-itself"] * hangs


@pytest.mark.parametrize(
    ("way_out", "how"),
    [
        ("if future.done(): break", "polled"),
        ("if future.done(): return future.result()", "polled"),
        ("if future.done(): break\n            if time.time() > end: break", "polled, time-out open"),
        ("if future.done() or self.late: break", "polled, time-out open"),
        ("rclpy.spin_once(self)\n            if future.done(): break", "async"),
    ],
)
@pytest.mark.parametrize("test", ["rclpy.ok()", "True"])
def test_a_loop_that_a_future_ends(tmp_path: Path, test: str, way_out: str, how: str) -> None:
    """The test of the future is a way out in the body; such callbacks were proved to end."""
    tick = f"""future = self.cli.call_async(Trigger.Request())
        end = time.time() + 1
        while {test}:
            {way_out}
            time.sleep(0.1)"""
    (node,) = read_source(program(tmp_path, tick)).nodes
    (effect,) = [each for one in node.callbacks for each in one.effects if each.do == "call"]
    assert effect.how == how


HELPER = """
    def wait(self, future, timeout=None):
        start = time.time()
        while not TEST:
            if timeout is not None and time.time() - start > timeout:
                return False
            time.sleep(0.01)
        return True"""


@pytest.mark.parametrize(
    ("test", "heard", "hangs"),
    [
        ("future.done()", "pass", "[callback-deadlock]"),
        ("self.any_done", "self.any_done = True", "[code-waits-for-itself]"),
        ("self.cli.wait_for_service(1.0)", "pass", "[code-waits]"),
    ],
)
@pytest.mark.parametrize("timeout", ["", ", 0.5"])
def test_a_helper_with_a_time_out_that_is_left_out(
    tmp_path: Path, test: str, heard: str, hangs: str, timeout: str
) -> None:
    """The way out of the loop is never taken; it counted as one, so the wait was said to end."""
    tick = f"self.wait(self.cli.call_async(Trigger.Request()){timeout})"
    text = checked(tmp_path, tick + HELPER.replace("TEST", test), heard=heard, threads=1, group="")
    waits = "[callback-deadlock]" in text or hangs in text
    assert waits == (timeout == "")


def test_dataclasses_create_ports(tmp_path: Path) -> None:
    """Each has its own lock."""
    source = program(tmp_path, "pass", init="self.parts = [Part(self), Part(self)]", threads=4)
    assert calls(source) == ["call /ask"] * 2
    assert rules(source) == []


@pytest.mark.parametrize(
    ("body", "severity"),
    [
        ("response.success = True", "error"),
        ("return True", "error"),
        ("if request: return response", "warning"),
        ("return response", None),
        ("return Trigger.Response()", None),
        ("if request: return response\n        raise RuntimeError", None),
        ("return self.answered(response)", None),
    ],
)
def test_services_return_responses(tmp_path: Path, body: str, severity: str | None) -> None:
    """`rclpy` ends the program with TypeError otherwise."""
    init = "self.create_service(Trigger, 'other', self.answer)\n"
    init += f"    def answer(self, request, response):\n        {body}"
    assert shown(tmp_path, "pass", init=init) == [f"{each} code-gives-none" for each in [severity] if each]


ACTION = """
from rclpy.action import CancelResponse

class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.server = ActionServer(self, Fibonacci, "go", self.work, MORE)
    def rejects(self, goal):
        print(goal)
    def accepts(self, goal):
        return CancelResponse.ACCEPT
    def work(self, goal):
        WORK

def main():
    rclpy.init()
    executor = MultiThreadedExecutor(THREADS)
    executor.add_node(Robot())
    executor.spin()

main()
"""
CANCELED = "while not goal.is_cancel_requested: time.sleep(0.1)\n        return Fibonacci.Result()"


@pytest.mark.parametrize(
    ("work", "more", "threads", "rule"),
    [
        ("goal.succeed()", "", 1, "code-gives-none"),
        ("goal.succeed(); return Fibonacci.Result()", "goal_callback=self.rejects", 1, "code-gives-none"),
        (CANCELED, "cancel_callback=self.accepts", 1, "code-waits-for-itself"),
        (CANCELED, "cancel_callback=self.accepts", 2, None),
        ("goal.succeed(); return Fibonacci.Result()", "", 1, None),
    ],
)
def test_action_servers(tmp_path: Path, work: str, more: str, threads: int, rule: str | None) -> None:
    text = ACTION.replace("WORK", work).replace("MORE", more).replace("THREADS", str(threads))
    assert [each.partition(" ")[2] for each in rules(files(tmp_path, robot=text))] == [
        each for each in [rule] if each
    ]


@pytest.mark.parametrize(("cancel", "hangs"), [("cancel_goal()", True), ("cancel_goal_async()", False)])
def test_a_request_to_cancel_that_waits(tmp_path: Path, cancel: str, hangs: bool) -> None:
    init = "self.nav, self.goal = ActionClient(self, Fibonacci, 'go'), None\n        " + TIMER
    tick = f"""if self.goal is None:
            self.nav.send_goal_async(Fibonacci.Goal()).add_done_callback(self.accepted)
        else:
            self.goal.{cancel}
    def accepted(self, future):
        self.goal = future.result()"""
    assert shown(tmp_path, tick, init=init) == ["error code-waits-for-itself"] * hangs


@pytest.mark.parametrize(
    ("main", "hangs"),
    [
        ("node.ask()", True),
        ("node.create_rate(1).sleep()", True),
        ("rate = node.create_rate(1)\nwhile rclpy.ok():\n    node.ask()\n    rate.sleep()", True),
        ("while rclpy.ok(): time.sleep(1)", True),
        ("while rclpy.ok(): rclpy.spin_once(node)", False),
        ("while rclpy.ok(): node.run()", False),
        ("threading.Thread(target=rclpy.spin, args=(node,)).start()\nnode.ask()", False),
    ],
)
def test_programs_that_no_executor_runs(tmp_path: Path, main: str, hangs: bool) -> None:
    text = """
import threading
class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.cli = self.create_client(Trigger, "ask")
        self.create_subscription(String, "in", print, 10)
    def ask(self):
        self.cli.call(Trigger.Request())
    def run(self):
        rclpy.spin_once(self)
rclpy.init()
node = Robot()
node.get_logger().info("runs")
"""
    assert rules(files(tmp_path, robot=text + main)) == ["error code-waits-unspun"] * hangs
