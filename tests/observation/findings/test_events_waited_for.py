"""Callbacks that wait for what another callback sets or gives: events, queues, semaphores."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.observation.findings.code import code_findings
from dineros.sources.reading import read_source
from tests.support.programs.coded import files, run

PROGRAM = """
import threading

class Robot(Node):
    def __init__(self):
        super().__init__('robot')
        self.done = threading.Event()
        self.other = self.create_client(Trigger, 'other'GROUP)
        self.create_timer(1.0, self.tick)

    def tick(self):
        self.other.call_async(Trigger.Request()).add_done_callback(self.finish)
        self.done.wait()
        self.done.clear()

    def finish(self, future):
        self.done.set()

def main():
    rclpy.init()
    executor = MultiThreadedExecutor(4)
    executor.add_node(Robot())
    executor.spin()
"""


@pytest.mark.parametrize(
    ("group", "hangs"), [("", True), (", callback_group=MutuallyExclusiveCallbackGroup()", False)]
)
def test_a_done_callback_starts_in_the_group_of_its_client(tmp_path: Path, group: str, hangs: bool) -> None:
    """The client takes no response while a callback of its group waits."""
    _, text = run("check", "-q", "--source", files(tmp_path, robot=PROGRAM.replace("GROUP", group)))
    assert ("[code-waits-for-itself]" in text) == hangs, text


HANDED_OVER = """
import queue
import threading

class Robot(Node):
    def __init__(self):
        super().__init__('robot')
        self.held = MADE
        self.create_subscription(String, 'in', self.heard, 10)
        self.create_timer(1.0, self.tick)

    def heard(self, message):
        GIVES

    def tick(self):
        TAKES

def main():
    rclpy.init()
    rclpy.spin(Robot())
"""


@pytest.mark.parametrize(
    ("made", "gives", "takes", "hangs"),
    [
        ("queue.Queue()", "self.held.put(message)", "self.held.get()", True),
        ("queue.SimpleQueue()", "self.held.put_nowait(message)", "self.held.get(block=True)", True),
        ("queue.Queue()", "self.held.put(message)", "self.held.get_nowait()", False),
        ("queue.Queue()", "self.held.put(message)", "self.held.get(False)", False),
        ("queue.Queue()", "self.held.put(message)", "self.held.get(timeout=0.1)", False),
        ("queue.Queue()", "self.held.put(message)", "return self.held.empty() or self.held.get()", False),
        ("threading.Semaphore(0)", "self.held.release()", "self.held.acquire()", True),
        ("threading.Semaphore(0)", "self.held.release()", "self.held.acquire(False)", False),
        ("threading.Semaphore()", "self.held.release()", "self.held.acquire()", False),
    ],
)
def test_queues_and_semaphores_are_waited_for(
    tmp_path: Path, made: str, gives: str, takes: str, hangs: bool
) -> None:
    """One thread: nothing can give while the timer's callback waits. The proofs were "8 proved"."""
    text = HANDED_OVER.replace("MADE", made).replace("GIVES", gives).replace("TAKES", takes)
    _, shown = run("check", "-q", "--source", files(tmp_path, robot=text))
    assert ("[code-waits-for-itself]" in shown) == hangs, shown


IN_CPP = """
#include <rclcpp/rclcpp.hpp>
#include <std_msgs/msg/string.hpp>
using Text = std_msgs::msg::String;
class Robot : public rclcpp::Node {
 public:
  Robot() : rclcpp::Node("robot") {
    sub_ = create_subscription<Text>("in", 10, [this](Text::SharedPtr text) { heard(text); });
    timer_ = create_wall_timer(std::chrono::seconds(1), [this]() { tick(); });
    MORE
  }
  void heard(Text::SharedPtr text) { last_ = text; GIVES }
  void tick() { TAKES }
  void look() { ready_ = hardware_ready(); }
  std::atomic<bool> ready_{false};
  std::queue<Text::SharedPtr> queue_;
  Text::SharedPtr last_;
  std::thread thread_;
  rclcpp::Subscription<Text>::SharedPtr sub_;
  rclcpp::TimerBase::SharedPtr timer_;
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  auto robot = std::make_shared<Robot>();
  MAIN
  rclcpp::spin(robot);
}
"""
SLEEP = "std::this_thread::sleep_for(std::chrono::milliseconds(10));"


@pytest.mark.parametrize(
    ("gives", "takes", "more", "hangs"),
    [
        ("ready_ = true;", f"while (!ready_) {{ {SLEEP} }}", "", True),
        ("ready_.store(true);", f"while (rclcpp::ok() && !ready_.load()) {{ {SLEEP} }}", "", True),
        ("queue_.push(text);", f"while (queue_.empty()) {{ {SLEEP} }} queue_.pop();", "", True),
        ("", "while (last_ == nullptr) {}", "", True),
        ("ready_ = true;", "if (!ready_) { return; }", "", False),
        ("ready_ = true;", f"while (!ready_) {{ {SLEEP} look(); }}", "", False),
        ("ready_ = true;", f"while (!ready_) {{ if (late()) {{ break; }} {SLEEP} }}", "", False),
        ("ready_ = true;", f"while (!ready_ && now() < end()) {{ {SLEEP} }}", "", False),
        ("ready_ = true;", f"bool ready_ = false; while (!ready_) {{ {SLEEP} }}", "", False),
        (
            "ready_ = true;",
            f"while (!ready_) {{ {SLEEP} }}",
            "thread_ = std::thread([this]() { ready_ = true; });",
            False,
        ),
    ],
)
def test_loops_in_cpp_wait_for_members(
    tmp_path: Path, gives: str, takes: str, more: str, hangs: bool
) -> None:
    """The loop ends only if another callback changes the member, and there is one thread."""
    pytest.importorskip("tree_sitter_cpp")
    text = IN_CPP.replace("GIVES", gives).replace("TAKES", takes).replace("MORE", more).replace("MAIN", "")
    (tmp_path / "robot.cpp").write_text(text)
    _, shown = run("check", "-q", "--source", tmp_path)
    assert ("[code-waits-for-itself]" in shown) == hangs, shown


@pytest.mark.parametrize(("in_main", "hangs"), [("", True), ("robot->ready_ = true;", False)])
def test_the_main_function_may_change_what_a_loop_waits_for(
    tmp_path: Path, in_main: str, hangs: bool
) -> None:
    pytest.importorskip("tree_sitter_cpp")
    text = IN_CPP.replace("GIVES", "ready_ = true;").replace("TAKES", f"while (!ready_) {{ {SLEEP} }}")
    (tmp_path / "robot.cpp").write_text(text.replace("MORE", "ready_ = false;").replace("MAIN", in_main))
    _, shown = run("check", "-q", "--source", tmp_path)
    assert ("[code-waits-for-itself]" in shown) == hangs, shown


WORKS = """
import threading
from concurrent.futures import ThreadPoolExecutor

class Worker(threading.Thread):
    def __init__(self, robot):
        super().__init__()
        self.robot = robot

    def run(self):
        self.robot.work()

class Robot(Node):
    def __init__(self):
        super().__init__('robot')
        self.pool = ThreadPoolExecutor(1)
        self.other = self.create_client(Trigger, 'other')
        self.create_service(Trigger, 'other', self.answer)
        self.create_timer(1.0, self.tick)

    def answer(self, request, response):
        return response

    def work(self):
        self.other.call(Trigger.Request())

    def tick(self):
        STARTS

def main():
    rclpy.init()
    rclpy.spin(Robot())
"""


@pytest.mark.parametrize(
    ("starts", "hangs"),
    [
        ("thread = threading.Thread(target=self.work); thread.start(); thread.join()", True),
        ("thread = Worker(self); thread.start(); thread.join()", True),
        ("self.pool.submit(self.work).result()", True),
        ("threading.Thread(target=self.work).start()", False),
        ("thread = threading.Thread(target=self.work); thread.start(); thread.join(timeout=0.5)", False),
        ("self.pool.submit(self.work)", False),
    ],
)
def test_a_callback_that_waits_for_its_thread_does_what_that_does(
    tmp_path: Path, starts: str, hangs: bool
) -> None:
    """The thread waits for a response that the only thread of the executor would take: "8 proved" before."""
    _, text = run("check", "-q", "--source", files(tmp_path, robot=WORKS.replace("STARTS", starts)))
    assert ("[callback-deadlock]" in text) == hangs, text


POLLS = """
import time

class Robot(Node):
    def __init__(self):
        super().__init__('robot')
        self.other = self.create_client(Trigger, 'other')
        self.create_service(Trigger, 'other', self.answer)
        self.create_timer(1.0, self.tick)

    def answer(self, request, response):
        return response

    def tick(self):
        future = self.other.call_async(Trigger.Request())
        end = time.time() + 2.0
        while TEST:
            time.sleep(0.01)
            MORE

def main():
    rclpy.init()
    rclpy.spin(Robot())
"""


@pytest.mark.parametrize(
    ("test", "more", "hangs"),
    [
        ("not future.done()", "pass", True),
        ("rclpy.ok() and not future.done()", "pass", True),
        ("not future.done() and time.time() < end", "pass", False),
        ("not future.done()", "if time.time() > end: break", False),
    ],
)
def test_a_loop_with_a_time_limit_gives_up(tmp_path: Path, test: str, more: str, hangs: bool) -> None:
    """A callback that gives up is not deadlocked; its response never arrives in time."""
    source = files(tmp_path, robot=POLLS.replace("TEST", test).replace("MORE", more))
    _, text = run("check", "-q", "--source", source)
    assert ("[callback-deadlock]" in text) == hangs, text
    gives_up = "no response of service /other comes in time: client robot.on_tick always gives up after 1 s"
    assert (gives_up in text) != hangs, text


POLLS_ATTRIBUTES = """
import threading, time
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup

class State:
    def __init__(self):
        self.pose = None

class Robot(Node):
    def __init__(self):
        super().__init__('robot')
        self.ready, self.count, self.items, self.data, self.state = False, 0, [], {}, State()
        self.seen = threading.Event()
        self.create_subscription(String, 'in', self.heard, 10GROUP)
        self.create_timer(1.0, self.tick)

    @property
    def has_pose(self):
        return self.state.pose is not None

    def is_ready(self):
        return self.ready

    def heard(self, message):
        self.ready = True
        self.count += 1
        self.items.append(message)
        self.data['pose'] = message
        self.state.pose = message
        self.seen.set()
        self.spinning = True

    def sensor_ok(self):
        return self.ready

    def look(self):
        self.ready = self.count_publishers('in') > 0

    def tick(self):
        LOOP

def main():
    rclpy.init()
    executor = MultiThreadedExecutor(THREADS)
    executor.add_node(Robot())
    executor.spin()
"""
SLEEP_OF_PYTHON = "time.sleep(0.1)"
WAITING_LOOPS = [
    f"while rclpy.ok() and not self.ready: {SLEEP_OF_PYTHON}",
    f"while True:\n            if self.ready: break\n            {SLEEP_OF_PYTHON}",
    f"while not self.is_ready(): {SLEEP_OF_PYTHON}",
    f"while not self.has_pose: {SLEEP_OF_PYTHON}",
    f"while len(self.items) == 0: {SLEEP_OF_PYTHON}",
    f"while self.count < 5: {SLEEP_OF_PYTHON}",
    f"while 'pose' not in self.data: {SLEEP_OF_PYTHON}",
    f"while not self.seen.is_set(): {SLEEP_OF_PYTHON}",
    f"while not self.spinning: {SLEEP_OF_PYTHON}",
    f"while not self.sensor_ok(): {SLEEP_OF_PYTHON}",
]


def _of_code(source: Path) -> list[str]:
    """Return the rules of code that are found in a folder."""
    return [each.rule for each in code_findings([("src", read_source(source))])]


@pytest.mark.parametrize("loop", WAITING_LOOPS)
@pytest.mark.parametrize(
    ("group", "threads", "hangs"),
    [
        ("", "1", True),
        ("", "2", True),
        (", callback_group=MutuallyExclusiveCallbackGroup()", "1", True),
        (", callback_group=MutuallyExclusiveCallbackGroup()", "2", False),
    ],
)
def test_loops_in_python_wait_for_attributes(
    tmp_path: Path, loop: str, group: str, threads: str, hangs: bool
) -> None:
    """The loop ends only if another callback changes the attribute."""
    text = POLLS_ATTRIBUTES.replace("LOOP", loop).replace("GROUP", group).replace("THREADS", threads)
    assert _of_code(files(tmp_path, robot=text)) == ["code-waits-for-itself"] * hangs


@pytest.mark.parametrize(
    "loop",
    [
        "end = time.time() + 1\n        while self.count < 5 and time.time() < end: time.sleep(0.1)",
        "while self.count < 5: self.count += 1",
        "while not self.ready: self.look()",
        "while self.items: self.items.pop()",
        "for _ in range(10):\n            if self.ready: break\n            time.sleep(0.1)",
        "while self.count < 5:\n            if self.hardware.read(): break\n            time.sleep(0.1)",
    ],
)
def test_loops_in_python_that_end_by_themselves(tmp_path: Path, loop: str) -> None:
    text = POLLS_ATTRIBUTES.replace("LOOP", loop).replace("GROUP", "").replace("THREADS", "1")
    assert _of_code(files(tmp_path, robot=text)) == []


FUTURE = """
from rclpy.task import Future
class Robot(Node):
    def __init__(self):
        super().__init__('robot')
        self.pending = Future()
        group = MutuallyExclusiveCallbackGroup()
        self.create_subscription(String, 'in', self.heard, 10GROUP)
        self.create_timer(1.0, self.tick)

    def heard(self, message):
        self.pending.set_result(message)

    async def tick(self):
        WAITS

def main():
    rclpy.init()
    rclpy.spin(Robot())
"""


@pytest.mark.parametrize(
    ("waits", "group", "hangs"),
    [
        ("await self.pending", "", True),
        ("self.pending = Future(); await self.pending", "", True),
        ("await self.pending", ", callback_group=group", False),  # an await blocks no thread
        ("while not self.pending.done(): time.sleep(0.1)", "", True),
        ("while not self.pending.done(): time.sleep(0.1)", ", callback_group=group", True),
        ("self.pending.done()", "", False),
    ],
)
def test_a_future_that_the_program_sets(tmp_path: Path, waits: str, group: str, hangs: bool) -> None:
    source = files(tmp_path, robot=FUTURE.replace("GROUP", group).replace("WAITS", waits))
    _, text = run("check", "-q", "--source", source)
    assert ("[code-waits-for-itself]" in text) == hangs, text


@pytest.mark.parametrize(
    ("made", "sets", "waits"),
    [("threading.Event()", "set()", "wait()"), ("queue.Queue()", "put(1)", "get()")],
)
@pytest.mark.parametrize(("group", "hangs"), [("None", True), ("other", False)])
def test_what_a_callback_makes_and_waits_for(
    tmp_path: Path, made: str, sets: str, waits: str, group: str, hangs: bool
) -> None:
    """Each run makes its own; one line makes both groups."""
    text = PROGRAM.replace("GROUP", f", callback_group={group}").replace(
        "import threading", "import queue, threading"
    )
    text = text.replace(
        "        self.done = threading.Event()",
        "        own, other = MutuallyExclusiveCallbackGroup(), MutuallyExclusiveCallbackGroup()",
    ).replace(
        "self.tick)", "self.tick, callback_group=GROUP)".replace("GROUP", "own" if not hangs else "None")
    )
    text = text.replace("self.finish)", f"lambda _: done.{sets})").replace(
        "self.done.wait()", f"done.{waits}"
    )
    text = text.replace(
        "        self.other.call_async", f"        done = {made}\n        self.other.call_async"
    )
    text = text.replace("        self.done.clear()\n", "").replace("self.done.set()", "pass")
    _, shown = run("check", "-q", "--source", files(tmp_path, robot=text))
    assert ("[code-waits-for-itself]" in shown) == hangs, shown


UNSET = """
import threading
from other import use

class Robot(Node):
    def __init__(self):
        super().__init__('robot')
        MADE
        self.create_subscription(String, 'in', self.heard, 10, callback_group=ReentrantCallbackGroup())
        self.create_service(Trigger, 'go', self.go)
        self.work = ActionServer(self, Fibonacci, 'work', self.execute)

    def heard(self, message):
        HEARD

    def go(self, request, response):
        WAITS
        return response

    def execute(self, goal):
        EXECUTES
        return Fibonacci.Result()

def main():
    rclpy.init()
    executor = MultiThreadedExecutor(4)
    executor.add_node(Robot())
    executor.spin()
"""
EVENT = "self.ready = threading.Event()"
WAIT = "self.ready.wait()"


@pytest.mark.parametrize(
    ("made", "heard", "waits", "executes", "hangs"),
    [
        (EVENT, "pass", WAIT, "pass", True),
        (EVENT, "self.ready.clear()", f"if not self.ready.is_set(): {WAIT}", "pass", True),
        (EVENT, "pass", "pass", WAIT, True),
        (EVENT, "pass", "done = threading.Event(); done.wait()", "done.set()", True),
        ("self.turn = threading.Condition()", "pass", "with self.turn: self.turn.wait()", "pass", True),
        ("self.free = threading.Semaphore(0)", "pass", "self.free.acquire()", "pass", True),
        (EVENT, "pass", "self.ready.wait(1.0)", "pass", False),
        (EVENT, "self.ready.set()", WAIT, "pass", False),
        (EVENT, "use(self.ready)", WAIT, "pass", False),
        (EVENT, "self.later = self.ready.set", WAIT, "pass", False),
        (EVENT, "pass", WAIT, "use(self).ready.set()", False),
        (EVENT, "getattr(self, 'ready').set()", WAIT, "pass", False),
        ("self.ready = self.other = threading.Event()", "self.other.set()", WAIT, "pass", False),
        ("self.all = {1: threading.Event()}", "pass", "self.all[1].wait()", "pass", False),
    ],
)
def test_an_event_that_no_code_sets(
    tmp_path: Path, made: str, heard: str, waits: str, executes: str, hangs: bool
) -> None:
    """This was a proof under an assumption."""
    text = UNSET
    for key, value in (("MADE", made), ("HEARD", heard), ("WAITS", waits), ("EXECUTES", executes)):
        text = text.replace(key, value)
    folder = Path(files(tmp_path, robot=text))
    found = [each.message for each in code_findings([("", read_source(folder))])]
    assert any("no code sets" in each for each in found) == hangs, found
