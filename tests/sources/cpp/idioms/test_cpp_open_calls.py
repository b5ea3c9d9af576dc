"""Calls in C++ that are not followed are named, and waits of the standard library are effects."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.sources.facts import Facts
from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

PROGRAM = """
#include <rclcpp/rclcpp.hpp>
using namespace std::chrono_literals;
using Text = std_msgs::msg::String;
BEFORE
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    out_ = create_publisher<Text>("out", 1);
    in_ = create_subscription<Text>("in", 1, [this](Text::SharedPtr) { HEARD });
    timer_ = create_wall_timer(1s, [this]() { tick(); });
  }
  void say() { out_->publish(Text()); }
  void tick() { TICK }
  MEMBERS
  rclcpp::Publisher<Text>::SharedPtr out_;
  rclcpp::Subscription<Text>::SharedPtr in_;
  rclcpp::TimerBase::SharedPtr timer_;
};
AFTER
int main(int argc, char ** argv) { rclcpp::init(argc, argv); rclcpp::spin(std::make_shared<Robot>()); }
"""


def _facts(folder: Path, **parts: str) -> Facts:
    text = PROGRAM
    for name in ("before", "members", "tick", "heard", "after"):
        text = text.replace(name.upper(), parts.get(name, ""))
    (folder / "robot.cpp").write_text(text, encoding="utf-8")
    return read_source(folder)


def test_a_method_that_is_only_reached_by_a_conversion_is_named(tmp_path: Path) -> None:
    facts = _facts(
        tmp_path,
        before="class Robot; struct Handle { Robot * robot; operator Robot *(); };",
        members="Handle handle_{this};",
        tick="Robot * robot = handle_;",
        after="Handle::operator Robot *() { robot->say(); return robot; }",
    )
    (line,) = facts.unread
    assert "operator Robot is used in a way that is not followed" in line


def test_a_lambda_that_no_known_code_calls_is_named(tmp_path: Path) -> None:
    facts = _facts(tmp_path, tick="std::set_terminate([this]() { say(); });")
    (line,) = facts.unread
    assert "a lambda is used in a way that is not followed" in line


@pytest.mark.parametrize(
    "parts",
    [
        {"members": "void unused() { say(); }"},
        {"members": "void one() { two(); } void two() { one(); say(); }"},  # nothing begins with them
        {"before": "struct Other { void tick() { out->publish(1); } Out * out; };"},
        {"members": "void two(int) { say(); } void two(double) { say(); }", "tick": "two(1);"},
    ],
)
def test_code_that_is_never_named_is_not_missing(tmp_path: Path, parts: dict[str, str]) -> None:
    assert _facts(tmp_path, **parts).unread == []


def test_a_function_that_unknown_code_gets_in_a_callback_may_run_at_once(tmp_path: Path) -> None:
    facts = _facts(tmp_path, tick="vendor::run([this]() { say(); });")
    (line,) = facts.unread
    assert "vendor::run receives a function" in line


def test_a_coroutine_is_not_followed_silently(tmp_path: Path) -> None:
    facts = _facts(tmp_path, members="Task go() { co_await Other{}; say(); }", tick="go();")
    (line,) = facts.unread
    assert "a coroutine" in line


@pytest.mark.parametrize(
    ("members", "wait", "ends"),
    [
        ("std::atomic<bool> done_{false};", "done_.wait(false);", "done_ = true; done_.notify_one();"),
        ("std::atomic<int> done_{0};", "done_.wait(0);", "done_.store(1); done_.notify_all();"),
        ("std::atomic_flag done_;", "done_.wait(false);", "done_.test_and_set(); done_.notify_all();"),
    ],
)
def test_a_wait_for_an_atomic_variable_ends_by_what_changes_it(
    tmp_path: Path, members: str, wait: str, ends: str
) -> None:
    facts = _facts(tmp_path, members=members, tick=wait, heard=ends)
    (node,) = facts.nodes
    effects = {each.kind: [(one.do, one.what) for one in each.effects] for each in node.callbacks}
    assert effects["timer"] == [("wait", "done_")]
    assert ("notify", "done_") in effects["subscription"]


@pytest.mark.parametrize(
    ("wait", "how", "timeout"),
    [
        ("set.wait();", "without time-out", None),
        ("set.wait(2s);", "time-out 2.0 s", 2.0),
        ("set.wait(-1s);", "without time-out", None),
    ],
)
def test_a_callback_waits_for_a_wait_set(tmp_path: Path, wait: str, how: str, timeout: float | None) -> None:
    facts = _facts(tmp_path, tick=f"rclcpp::WaitSet set; set.add_subscription(in_); {wait}")
    (node,) = facts.nodes
    (timer,) = node.of("timers")
    (effect,) = timer.callbacks["callback"].effects
    assert (effect.do, effect.how, effect.timeout) == ("wait", how, timeout)


def test_a_generic_client_is_one(tmp_path: Path) -> None:
    facts = _facts(
        tmp_path,
        members='rclcpp::GenericClient::SharedPtr client_ = create_generic_client("a", "b/srv/C");',
        tick="client_->async_send_request(nullptr).get();",
    )
    (client,) = facts.nodes[0].of("clients")
    assert (client.name, client.type) == ("a", "b/srv/C")
