"""Loops in C++ that nothing in the code ends: proofs about their callbacks are under an assumption."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.observation.findings.code import code_findings
from dineros.observation.importing.coded import coded
from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

ROBOT = """
#include <rclcpp/rclcpp.hpp>
using namespace std::chrono_literals;
using std_msgs::msg::String;
bool connected();
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    pub_ = create_publisher<String>("out", 10);
    sub_ = create_subscription<String>("in", 10, [this](String::SharedPtr msg) { onIn(msg); });
  }
  void onIn(const String::SharedPtr msg) {
    LOOP
    pub_->publish(*msg);
  }
  bool arrived() { std::ifstream file("/dev/x"); return file.good() && last_ > 0; }
  rclcpp::Publisher<String>::SharedPtr pub_;
  rclcpp::Subscription<String>::SharedPtr sub_;
  std::vector<int> items_;
  std::queue<int> queue_;
  Device device_;
  int last_ = 0;
};
int main() {
  rclcpp::init();
  auto node = std::make_shared<Robot>();
  while (rclcpp::ok()) { rclcpp::spin_some(node); std::this_thread::sleep_for(10ms); }
}
"""
SLEEP = "std::this_thread::sleep_for(10ms);"


def _lines(folder: Path, loop: str) -> list[str]:
    (folder / "robot.cpp").write_text(ROBOT.replace("    LOOP", loop))
    found = coded([(str(folder), read_source(folder))], "robot")
    return [each for each in found.lacks if "robot.cpp:13" in each]


@pytest.mark.parametrize(
    "loop",
    [
        f"while (!arrived()) {{ {SLEEP} }}",
        f"while (rclcpp::ok() && !connected()) {{ {SLEEP} }}",
        f"do {{ {SLEEP} }} while (!device_.ready());",
        f"for (;;) {{ if (connected()) break; {SLEEP} }}",
        f"while (rclcpp::ok()) {{ bool there = connected(); if (there) {{ break; }} {SLEEP} }}",
        f"while (true) {{ try {{ device_.open(); break; }} catch (...) {{ {SLEEP} }} }}",
        "rclcpp::Rate r(10); while (!device_.ready()) { r.sleep(); }",
        'bool far = connected(); while (far) { RCLCPP_INFO(get_logger(), "x"); }',
        "bool far = connected(); while (far);",
        "while (rclcpp::ok()) { if (connected()) { break; } device_.sleep(); }",
    ],
)
def test_a_loop_whose_end_is_not_known_is_an_assumption(tmp_path: Path, loop: str) -> None:
    (line,) = _lines(tmp_path, loop)
    assert "waits for the end of the loop while (" in line
    assert "what ends it is not known" in line
    assert "in the model it continues at once" in line


@pytest.mark.parametrize(
    "loop",
    [
        f"while (true) {{ {SLEEP} }}",
        f"while (rclcpp::ok()) {{ pub_->publish(*msg); {SLEEP} }}",
        f"for (;;) {{ if (!rclcpp::ok()) return; {SLEEP} }}",
    ],
)
def test_a_loop_without_an_exit_is_a_finding_and_an_assumption(tmp_path: Path, loop: str) -> None:
    (line,) = _lines(tmp_path, loop)
    assert "the loop has no exit" in line
    found = code_findings([(str(tmp_path), read_source(tmp_path))])
    assert [each.rule for each in found] == ["code-never-ends"]


@pytest.mark.parametrize(
    "loop",
    [
        "for (auto & each : items_) { use(each); }",
        f"for (int i = 0; i < 10; ++i) {{ {SLEEP} }}",
        f"int i = 0; while (i < 10) {{ {SLEEP} ++i; }}",
        f"int i = 0; while (!connected() && i < 10) {{ {SLEEP} i += 1; }}",
        f"auto end = now() + 1s; while (now() < end) {{ {SLEEP} }}",
        f"auto start = now(); while (true) {{ auto d = now() - start; if (d > 1s) break; {SLEEP} }}",
        f"int n = 0; while (rclcpp::ok()) {{ if (++n > 5) {{ return; }} {SLEEP} }}",
        "while (!queue_.empty()) { queue_.pop(); }",
        "std::string line; while (std::getline(file, line)) { use(line); }",
        "auto it = items_.begin(); while (it != items_.end()) { ++it; }",
        "auto p = head; while (p) { p = p->next; }",
        "int left = 8; while (left > 0) { left = left / 2; }",
        "double error = 1; while (error > 0.1) { error = step(error); }",
        "bool changed = true; while (changed) { changed = relax(items_); }",
        "do { device_.step(); } while (!device_.ready());",
        "for (;;) { auto n = device_.read(); if (n <= 0) break; }",
        f"while (!queue_.empty()) {{ queue_.pop(); for (int i = 0; i < 3; ++i) {{ {SLEEP} }} }}",
    ],
)
def test_healthy_loops_are_quiet(tmp_path: Path, loop: str) -> None:
    assert _lines(tmp_path, loop) == []
    assert code_findings([(str(tmp_path), read_source(tmp_path))]) == []
