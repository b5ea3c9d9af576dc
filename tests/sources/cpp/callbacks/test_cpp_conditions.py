"""Code under conditions of the preprocessor: all branches are read."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.sources.facts import NodeFact
from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

CODE = """
#include <rclcpp/rclcpp.hpp>
MACROS
using namespace std::chrono_literals;
using std_srvs::srv::Trigger;
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
MAKES
    timer_ = create_wall_timer(1s, [this]() { tick(); });
  }
  void tick() {
TICK
  }
  std::mutex mutex_;
  rclcpp::Client<Trigger>::SharedPtr client_;
  rclcpp::Publisher<std_msgs::msg::Empty>::SharedPtr out_;
  rclcpp::TimerBase::SharedPtr timer_;
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  rclcpp::spin(std::make_shared<Robot>());
}
"""
CLIENT = 'client_ = create_client<Trigger>("ask");'
ASKS = "client_->async_send_request(std::make_shared<Trigger::Request>());"
WAITS = "client_->async_send_request(std::make_shared<Trigger::Request>()).get();"
OUT = "out_ = create_publisher<std_msgs::msg::Empty>(NAME, 1);"


def read(folder: Path, makes: str = CLIENT, tick: str = "", macros: str = "") -> tuple[NodeFact, list[str]]:
    """Return the node, and what was not read."""
    text = CODE.replace("MACROS", macros).replace("MAKES", makes).replace("TICK", tick)
    (folder / "robot.cpp").write_text(text)
    facts = read_source(folder)
    (node,) = facts.nodes
    return node, list(facts.unread)


def waits(node: NodeFact) -> bool:
    """Return whether the timer's callback waits for a response."""
    (tick,) = [each for each in node.callbacks if each.kind == "timer"]
    return any(each.how.startswith("blocks") for each in tick.effects if each.do == "call")


@pytest.mark.parametrize(
    "tick",
    [
        f"#ifdef A\n{ASKS}\n#else\n{WAITS}\n#endif",
        f"#ifdef A\n{WAITS}\n#else\n{ASKS}\n#endif",
        f"#ifndef A\n{ASKS}\n#else\n{WAITS}\n{ASKS}\n#endif",
        f"#if A > 1\n{ASKS}\n#elif A\n{WAITS}\n#else\n{ASKS}\n#endif",
        f"#if A > 1\n{ASKS}\n#elif A\n{ASKS}\n#else\n{WAITS}\n#endif",
        f"#ifdef A\n#ifdef B\n{ASKS}\n#else\n{WAITS}\n#endif\n#endif",
        f"#if 1\n{WAITS}\n#endif",
        f"#if 0\n{ASKS}\n#else\n{WAITS}\n#endif",
    ],
)
def test_the_first_statement_of_each_branch_is_read(tmp_path: Path, tick: str) -> None:
    """The first statement after ``#else`` was skipped: a deadlock in it was "0 found, 8 proved"."""
    assert waits(read(tmp_path, tick=tick)[0])


@pytest.mark.parametrize(
    "tick",
    [
        f"#if 0\n{WAITS}\n#endif",
        f"#if 1\n{ASKS}\n#else\n{WAITS}\n#endif",
        f"#if 0 // old\n#ifdef A\n{WAITS}\n#endif\n#else\n{ASKS}\n#endif",
    ],
)
def test_text_that_is_never_compiled_is_not_read(tmp_path: Path, tick: str) -> None:
    """Code that ``#if 0`` excludes does nothing."""
    node, unread = read(tmp_path, tick=tick)
    assert not waits(node)
    assert not unread


def test_equal_ports_of_two_branches_are_not_assumed(tmp_path: Path) -> None:
    """Calls of several versions of rclcpp make the same client."""
    other = CLIENT.replace('ask"', 'ask", 10')
    makes = f"#if RCLCPP_VERSION_MAJOR > 20\n{CLIENT}\n#else\n{other}\n#endif"
    node, unread = read(tmp_path, makes, ASKS)
    assert not unread
    assert {each.name for each in node.of("clients")} == {"ask"}


def test_a_branch_may_hold_a_lock_until_its_function_ends(tmp_path: Path) -> None:
    """A directive opens no scope, and only one of its branches is compiled."""
    locks = (
        "#ifdef A\nstd::lock_guard<std::mutex> lock(mutex_);\n#else\nstd::scoped_lock lock(mutex_);\n#endif\n"
    )
    node, _ = read(tmp_path, tick=locks + WAITS)
    (tick,) = [each for each in node.callbacks if each.kind == "timer"]
    (call,) = [each for each in tick.effects if each.do == "call"]
    assert [each.rpartition("::")[2] for each in call.holding] == ["mutex_"]


BOTH = '#ifdef A\n#define NAME "left"\n#else\n#define NAME "right"\n#endif'


def test_names_of_two_branches_are_alternatives(tmp_path: Path) -> None:
    """One of them was assumed, and with it all proofs."""
    node, unread = read(tmp_path, OUT, "", BOTH)
    assert not unread
    assert sorted(each.name for each in node.of("publishers")) == ["left", "right"]


@pytest.mark.parametrize("name", ['"/robot/" NAME', 'NAME "/out"'])
def test_names_next_to_texts_are_assumed(tmp_path: Path, name: str) -> None:
    """A choice cannot stand next to a text."""
    node, unread = read(tmp_path, OUT.replace("NAME", name), "", BOTH)
    assert len(unread) == 1
    assert len(node.of("publishers")) == 1
