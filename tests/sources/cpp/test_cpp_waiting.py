"""Waits in C++: for locks, condition variables, semaphores, other threads and responses."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.observation.findings.code import code_findings
from dineros.sources.facts import Effect, NodeFact
from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

ROBOT = """
#include <rclcpp/rclcpp.hpp>
using namespace std::chrono_literals;
using std_msgs::msg::String;
using std_srvs::srv::Trigger;
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    pub_ = create_publisher<String>("out", 10);
    sub_ = create_subscription<String>("in", 10, std::bind(&Robot::onIn, this, std::placeholders::_1));
    client_ = create_client<Trigger>("ask");
    timer_ = create_wall_timer(100ms, [this]() { onTimer(); });
  }
  void onIn(const String::SharedPtr msg) {
    IN
  }
  void onTimer() {
    TIMER
  }
  rclcpp::Publisher<String>::SharedPtr pub_;
  rclcpp::Subscription<String>::SharedPtr sub_;
  rclcpp::Client<Trigger>::SharedPtr client_;
  rclcpp::TimerBase::SharedPtr timer_;
  std::mutex m_;
  std::mutex n_;
  std::condition_variable cv_;
  std::counting_semaphore<4> sem_{0};
  std::promise<void> promise_;
  std::shared_future<Trigger::Response::SharedPtr> future_;
  bool ready_ = false;
};
int main() {
  rclcpp::init();
  auto node = std::make_shared<Robot>();
  MAIN
}
"""
ONE = "rclcpp::spin(node);"
FOUR = "rclcpp::executors::MultiThreadedExecutor e(rclcpp::ExecutorOptions(), 4); e.add_node(node); e.spin();"
ASK = "auto f = client_->async_send_request(std::make_shared<Trigger::Request>());\n"


def _read(folder: Path, on_in: str, on_timer: str = "", main: str = ONE) -> NodeFact:
    code = ROBOT.replace("    IN", on_in).replace("    TIMER", on_timer).replace("  MAIN", main)
    (folder / "robot.cpp").write_text(code)
    (node,) = read_source(folder).nodes
    return node


def _of(node: NodeFact, name: str) -> list[Effect]:
    (found,) = [each for each in node.callbacks if each.name == name]
    return found.effects


def _done(folder: Path, on_in: str, on_timer: str = "") -> list[tuple[str, str, str, tuple[str, ...]]]:
    effects = _of(_read(folder, on_in, on_timer), "onIn")
    return [(each.do, each.what, each.how, each.holding) for each in effects]


@pytest.mark.parametrize(
    "code",
    [
        "std::lock_guard<std::mutex> a(m_); std::lock_guard<std::mutex> b(n_); pub_->publish(*msg);",
        "std::unique_lock<std::mutex> a{m_}; auto b = std::unique_lock(this->n_); pub_->publish(*msg);",
        "m_.lock(); n_.lock(); pub_->publish(*msg); n_.unlock(); m_.unlock();",
        "std::unique_lock<std::mutex> a(m_, std::defer_lock); a.lock();\nn_.lock(); pub_->publish(*msg);",
    ],
)
def test_locks_have_names_and_are_held(tmp_path: Path, code: str) -> None:
    assert _done(tmp_path, code) == [
        ("lock", "m_", "", ()),
        ("lock", "n_", "", ("m_",)),
        ("publish", "pub_", "", ("m_", "n_")),
    ]


@pytest.mark.parametrize(
    "code",
    [
        "{ std::lock_guard<std::mutex> a(m_); } pub_->publish(*msg);",
        "std::unique_lock<std::mutex> a(m_); a.unlock(); pub_->publish(*msg);",
        "m_.lock(); m_.unlock(); pub_->publish(*msg);",
    ],
)
def test_locks_are_given_back(tmp_path: Path, code: str) -> None:
    assert _done(tmp_path, code) == [("lock", "m_", "", ()), ("publish", "pub_", "", ())]


def test_a_guard_that_tries_does_not_wait_but_holds(tmp_path: Path) -> None:
    code = "std::unique_lock<std::mutex> a(m_, std::try_to_lock); pub_->publish(*msg);"
    assert _done(tmp_path, code) == [("publish", "pub_", "", ("m_",))]


@pytest.mark.parametrize(
    ("code", "name", "how", "timeout"),
    [
        ("cv_.wait(lock);", "cv_", "condition variable, without time-out, and no code sets it", None),
        ("cv_.wait(lock, [this] { return ready_; });", "cv_", "condition variable, without time-out", None),
        ("cv_.wait_for(lock, 500ms);", "cv_", "condition variable, time-out 0.5 s", 0.5),
        ("cv_.wait_until(lock, later());", "cv_", "condition variable, time-out that is open", None),
        ("sem_.acquire();", "sem_", "counting_semaphore, without time-out", None),
        ("promise_.get_future().wait();", "promise_", "promise, without time-out", None),
        ("std::thread t(work); t.join();", "the thread t", "blocks, without time-out", None),
        ("auto f = std::async(work); f.get();", "the thread f", "blocks, without time-out", None),
    ],
)
def test_waits_for_other_threads_are_named(
    tmp_path: Path, code: str, name: str, how: str, timeout: float | None
) -> None:
    effects = _of(_read(tmp_path, code), "onIn")
    found = [(each.what, each.how, each.timeout) for each in effects if each.do == "wait"]
    assert found == [(name, how, timeout)]


def test_a_condition_variable_gives_its_lock_back_while_it_waits(tmp_path: Path) -> None:
    code = "m_.lock(); std::unique_lock<std::mutex> lock(n_); cv_.wait(lock); pub_->publish(*msg);"
    assert _done(tmp_path, code)[2:] == [
        ("wait", "cv_", "condition variable, without time-out, and no code sets it", ("m_",)),
        ("publish", "pub_", "", ("m_", "n_")),
    ]


@pytest.mark.parametrize(
    ("waits", "sets"),
    [
        (
            "std::unique_lock<std::mutex> lock(m_); cv_.wait(lock, [this] { return ready_; });",
            "cv_.notify_all();",
        ),
        ("sem_.acquire();", "sem_.release();"),
        ("promise_.get_future().get();", "promise_.set_value();"),
    ],
)
@pytest.mark.parametrize("main", [ONE, FOUR])
def test_what_only_a_callback_sets_that_cannot_run_is_found(
    tmp_path: Path, waits: str, sets: str, main: str
) -> None:
    """Also with four threads: both callbacks are in the default group, which is exclusive."""
    _read(tmp_path, waits, sets, main)
    (found,) = code_findings([(str(tmp_path), read_source(tmp_path))])
    assert (found.rule, found.severity) == ("code-waits-for-itself", "error")
    assert "which only onTimer sets" in found.message


def test_what_another_thread_sets_is_no_fault(tmp_path: Path) -> None:
    sets = "std::thread([this]() { std::this_thread::sleep_for(1s); cv_.notify_all(); }).detach();"
    waits = "std::unique_lock<std::mutex> lock(m_); cv_.wait(lock);"
    _read(tmp_path, waits, sets)
    assert code_findings([(str(tmp_path), read_source(tmp_path))]) == []


def test_a_sleep_of_a_clock_is_one(tmp_path: Path) -> None:
    (effect,) = _of(_read(tmp_path, "get_clock()->sleep_for(2s);"), "onIn")
    assert (effect.do, effect.timeout) == ("sleep", 2.0)


@pytest.mark.parametrize(
    ("code", "how"),
    [
        ("while (f.wait_for(100ms) != std::future_status::ready) {}", "blocks, without time-out"),
        (
            "std::future_status s;\ndo { s = f.wait_for(1s); } "
            "while (s != std::future_status::ready && rclcpp::ok());",
            "blocks, without time-out",
        ),
        (
            "while (rclcpp::ok()) { if (f.wait_for(1s) == std::future_status::ready) { break; } }",
            "blocks, without time-out",
        ),
        (
            "int n = 0;\nwhile (f.wait_for(1s) != std::future_status::ready) { if (++n > 5) { return; } }",
            "blocks, time-out that is open",
        ),
        ("for (int i = 0; i < 5; ++i) { f.wait_for(1s); }", "blocks, time-out that is open"),
        ("if (f.wait_for(2s) == std::future_status::ready) {\nf.get(); }", "blocks, time-out 2.0 s"),
        (
            "auto s = f.wait_for(2s);\nif (s != std::future_status::ready) { return; }\nf.get();",
            "blocks, time-out 2.0 s",
        ),
        ("f.wait_for(2s);\nf.get();", "blocks, without time-out"),
        ("f.wait_for(std::chrono::hours::max());", "blocks, without time-out"),
        ("if (f.wait_for(0s) == std::future_status::ready) {\nf.get(); }", "async"),
        (
            "while (rclcpp::ok()) { if (f.wait_for(0s) == std::future_status::ready) { break; } }",
            "blocks, without time-out",
        ),
        (
            "for (int i = 0; i < 5; ++i) { if (f.wait_for(0s) == std::future_status::ready) { return; } }",
            "async",
        ),
    ],
)
def test_how_long_a_response_is_waited_for(tmp_path: Path, code: str, how: str) -> None:
    """A time-out in a loop that goes on until there is a response is none; what is ready needs no wait."""
    assert [(each.do, each.how) for each in _of(_read(tmp_path, ASK + code), "onIn")] == [("call", how)]


def test_a_future_that_is_only_asked_is_not_waited_for(tmp_path: Path) -> None:
    ask = "future_ = client_->async_send_request(std::make_shared<Trigger::Request>()).future.share();"
    polls = (
        "if (future_.wait_for(0s) == std::future_status::ready) { future_.get(); pub_->publish(String()); }"
    )
    node = _read(tmp_path, ask, polls)
    assert [(each.do, each.how) for each in _of(node, "onIn")] == [("call", "async")]
    assert [(each.do, each.when) for each in _of(node, "onTimer")] == [("publish", "conditional")]


def test_names_that_a_file_uses_are_types(tmp_path: Path) -> None:
    node = _read(tmp_path, "")
    assert [each.type for each in node.of("clients")] == ["std_srvs/srv/Trigger"]
    assert [each.type for each in node.of("publishers")] == ["std_msgs/msg/String"]


def test_a_lock_that_is_held_already_is_found(tmp_path: Path) -> None:
    _read(tmp_path, "std::lock_guard<std::mutex> a(m_); onTimer();", "std::lock_guard<std::mutex> b(m_);")
    (found,) = code_findings([(str(tmp_path), read_source(tmp_path))])
    assert (found.rule, found.severity) == ("code-waits-for-itself", "error")
    assert "onIn" in found.message
    assert "locks m_, which it already holds" in found.message


@pytest.mark.parametrize(
    ("main", "wraps", "count"),
    [
        (FOUR, "std::thread([this]() { TIMER }).detach();", 2),
        (ONE, "std::thread([this]() { TIMER }).detach();", 2),
        (FOUR, "TIMER", 0),  # both callbacks are in one exclusive group
        (ONE, "TIMER", 0),
    ],
)
def test_locks_in_opposite_orders(tmp_path: Path, main: str, wraps: str, count: int) -> None:
    code = "std::lock_guard<std::mutex> a({}); std::lock_guard<std::mutex> b({});"
    _read(tmp_path, code.format("m_", "n_"), wraps.replace("TIMER", code.format("n_", "m_")), main)
    found = code_findings([(str(tmp_path), read_source(tmp_path))])
    assert [each.rule for each in found] == ["code-holds-lock"] * count


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("std::scoped_lock l(m_, n_);", "std::scoped_lock l(n_, m_);"),
        (
            "std::lock(m_, n_); std::lock_guard<std::mutex> a(m_, std::adopt_lock);",
            "std::unique_lock<std::mutex> a(n_, std::defer_lock), b(m_, std::defer_lock); std::lock(a, b);",
        ),
    ],
)
def test_locks_that_are_taken_together_have_no_order(tmp_path: Path, one: str, other: str) -> None:
    _read(tmp_path, one, f"std::thread([this]() {{ {other} }}).detach();", FOUR)
    assert code_findings([(str(tmp_path), read_source(tmp_path))]) == []


@pytest.mark.parametrize("both", ["std::scoped_lock l(m_, n_);", "std::lock(m_, n_);"])
def test_locks_that_are_taken_together_are_held(tmp_path: Path, both: str) -> None:
    assert _done(tmp_path, f"{both} pub_->publish(*msg);") == [
        ("lock", "m_", "", ()),
        ("lock", "n_", "", ()),
        ("publish", "pub_", "", ("m_", "n_")),
    ]
    _read(tmp_path, f"{both} std::lock_guard<std::mutex> b(m_);")
    (found,) = code_findings([(str(tmp_path), read_source(tmp_path))])
    assert found.rule == "code-waits-for-itself"


def test_a_rate_of_rclcpp_needs_no_timer(tmp_path: Path) -> None:
    """Unlike one of rclpy, which never wakes on the only thread."""
    _read(tmp_path, "rclcpp::Rate rate(2);\nrate.sleep();")
    assert code_findings([(str(tmp_path), read_source(tmp_path))]) == []
