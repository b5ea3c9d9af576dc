"""Barriers of C++: callbacks that meet at them, and the function that the last one runs."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.observation.findings.code import code_findings
from dineros.sources.facts import Effect
from dineros.sources.reading import read_source
from tests.support.programs.asking_programs import asked_by_timer

pytest.importorskip("tree_sitter_cpp")

RUNS: dict[str, dict[str, str]] = {
    "object": {
        "before": "class Robot; struct Done { Robot * robot; void operator()() noexcept; };",
        "members": "std::barrier<Done> barrier_{1, Done{this}};",
        "tick": "barrier_.arrive_and_wait();",
        "after": "inline void Done::operator()() noexcept { robot->ask(); }",
    },
    "function": {
        "members": "std::barrier<std::function<void()>> barrier_{1, [this]() { ask(); }};",
        "tick": "barrier_.arrive_and_wait();",
    },
    "pointer": {
        "members": "std::unique_ptr<std::barrier<std::function<void()>>> barrier_;",
        "init": ("barrier_ = std::make_unique<std::barrier<std::function<void()>>>(1, [this]() { ask(); });"),
        "tick": "barrier_->arrive_and_wait();",
    },
    "token": {
        "tick": (
            "std::barrier barrier(1, [this]() noexcept { ask(); }); "
            "auto token = barrier.arrive(); barrier.wait(std::move(token));"
        ),
    },
    "drop": {
        "tick": "std::barrier barrier(1, [this]() noexcept { ask(); }); barrier.arrive_and_drop();",
    },
}
"""Parts of programs, by how the function of a barrier is given."""

ROBOT = """
#include <rclcpp/rclcpp.hpp>
using namespace std::chrono_literals;
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    group_ = create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive);
    one_ = create_wall_timer(1s, [this]() { ONE });
    two_ = create_wall_timer(1s, [this]() { TWO }, GROUP);
  }
  std::KIND meeting_{COUNT};
  rclcpp::CallbackGroup::SharedPtr group_;
  rclcpp::TimerBase::SharedPtr one_, two_;
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  rclcpp::executors::MultiThreadedExecutor executor(rclcpp::ExecutorOptions(), 4);
  executor.add_node(std::make_shared<Robot>());
  executor.spin();
}
"""
MEETS = "meeting_.arrive_and_wait();"
ARRIVES = "(void)meeting_.arrive();"


def _read(folder: Path, kind: str, one: str, two: str, group: str, count: int = 2) -> list[Effect]:
    text = ROBOT.replace("KIND", kind).replace("COUNT", str(count)).replace("GROUP", group)
    (folder / "robot.cpp").write_text(text.replace("ONE", one).replace("TWO", two))
    (node,) = read_source(folder).nodes
    return node.of("timers")[0].callbacks["callback"].effects


@pytest.mark.parametrize("name", RUNS)
def test_the_last_one_at_a_barrier_runs_its_function(tmp_path: Path, name: str) -> None:
    assert [each.when for each in asked_by_timer(tmp_path, RUNS[name])] == ["always"]


def test_the_function_of_a_barrier_for_several_runs_possibly(tmp_path: Path) -> None:
    parts = {
        "members": "std::barrier<std::function<void()>> barrier_{2, [this]() { ask(); }};",
        "tick": "(void)barrier_.arrive();",
    }
    assert [each.when for each in asked_by_timer(tmp_path, parts)] == ["conditional"]


@pytest.mark.parametrize(
    ("kind", "two"), [("barrier<>", MEETS), ("barrier<>", ARRIVES), ("latch", "meeting_.count_down();")]
)
def test_callbacks_of_one_group_cannot_meet(tmp_path: Path, kind: str, two: str) -> None:
    _read(tmp_path, kind, MEETS, two, "nullptr")
    found = code_findings([(str(tmp_path), read_source(tmp_path))])
    assert {each.rule for each in found} == {"code-waits-for-itself"}


@pytest.mark.parametrize("kind", ["barrier<>", "latch"])
def test_callbacks_of_two_groups_meet(tmp_path: Path, kind: str) -> None:
    effects = _read(tmp_path, kind, MEETS, MEETS, "group_")
    assert [(each.do, each.how) for each in effects] == [
        ("notify", "barrier"),
        ("wait", f"{kind.removesuffix('<>')}, without time-out"),
    ]
    assert code_findings([(str(tmp_path), read_source(tmp_path))]) == []


@pytest.mark.parametrize("kind", ["barrier<>", "latch"])
def test_one_callback_does_not_wait_for_itself(tmp_path: Path, kind: str) -> None:
    assert _read(tmp_path, kind, MEETS, "", "nullptr", count=1) == []
