"""Macros of the folder are read where they are used: ports that they make, and calls that they stand for."""

from __future__ import annotations

import time
from itertools import pairwise
from pathlib import Path

import pytest

from dineros.sources.cpp.macros.directives import without_dead
from dineros.sources.cpp.macros.expanding import Macros
from dineros.sources.facts import HELD, Facts
from dineros.sources.reading import read_source
from tests.support.programs.coded import run

pytest.importorskip("tree_sitter_cpp")

ROBOT = """
#include <rclcpp/rclcpp.hpp>
#include "robot/macros.hpp"
using namespace std::chrono_literals;
using std_msgs::msg::String;
using std_srvs::srv::Trigger;
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    group_ = create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive);
    client_ = create_client<Trigger>("ask", rclcpp::ServicesQoS(), GROUP);
    timer_ = create_wall_timer(1s, [this]() { tick(); });
    MAKES
  }
  void tick() {
    auto request = std::make_shared<Trigger::Request>();
    TICK
  }
  MEMBERS
  rclcpp::CallbackGroup::SharedPtr group_;
  rclcpp::Client<Trigger>::SharedPtr client_;
  rclcpp::TimerBase::SharedPtr timer_;
  rclcpp::Publisher<String>::SharedPtr state_pub_, other_pub_;
  std::mutex mutex_;
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  rclcpp::executors::MultiThreadedExecutor executor;
  executor.add_node(std::make_shared<Robot>());
  executor.spin();
}
"""


def read(folder: Path, macros: str, tick: str = "", makes: str = "", group: str = "nullptr") -> Facts:
    """Read the robot with a header of macros."""
    header = folder / "include" / "robot" / "macros.hpp"
    header.parent.mkdir(parents=True, exist_ok=True)
    header.write_text(f"#pragma once\n{macros}\n")
    text = ROBOT.replace("TICK", tick).replace("MAKES", makes).replace("GROUP", group)
    (folder / "robot.cpp").write_text(text.replace("MEMBERS", ""))
    return read_source(folder)


def expanded(text: str) -> str:
    """Return the last line of a file with its macros expanded."""
    return Macros({"a.cpp": text}).expanded("a.cpp", text).rstrip("\n").rpartition("\n")[2]


def done(facts: Facts) -> list[tuple[str, str]]:
    """Return what the callback of the timer does."""
    (node,) = facts.nodes
    (tick,) = [each for each in node.callbacks if each.kind == "timer"]
    return [(each.do, each.how) for each in tick.effects]


CALL_SYNC = "#define CALL_SYNC(client, request) client->async_send_request(request).get()"


@pytest.mark.parametrize(
    ("macros", "tick"),
    [
        (CALL_SYNC, "CALL_SYNC(client_, request);"),
        (CALL_SYNC, "CALL_SYNC(\n  client_,  // it blocks\n  request);"),
        (f"{CALL_SYNC}\n#define ASK(r) CALL_SYNC(client_, r)", "ASK(request);"),
        (f"#define ASK(r) CALL_SYNC(client_, r)\n{CALL_SYNC}", "ASK(request);"),
        (
            "#define ASK(r) \\\n  do { \\\n    client_->async_send_request(r).get(); \\\n  } while (0)",
            "ASK(request);",
        ),
        ("#define ASK client_->async_send_request(request).get()", "ASK;"),
        ("#define ASK(name, ...) name##_->async_send_request(__VA_ARGS__).get()", "ASK(client, request);"),
        ("#define RUN(...) { __VA_ARGS__; }", "RUN(client_->async_send_request(request).get())"),
        ("#ifndef ASK\n#define ASK(r) client_->async_send_request(r).get()\n#endif", "ASK(request);"),
    ],
)
def test_calls_in_macros_block(tmp_path: Path, macros: str, tick: str) -> None:
    """A deadlock in a macro was "0 found", and its service was "never called"."""
    facts = read(tmp_path, macros, tick)
    assert not facts.unread
    assert done(facts) == [("call", "blocks, without time-out")]
    line = (tmp_path / "robot.cpp").read_text().splitlines().index("    " + tick.partition("\n")[0]) + 1
    (effect,) = [each for one in facts.nodes[0].callbacks for each in one.effects if each.do == "call"]
    assert (effect.at.file, effect.at.line) == ("robot.cpp", line)


@pytest.mark.long
@pytest.mark.parametrize(("group", "hangs"), [("nullptr", True), ("group_", False)])
def test_deadlocks_in_macros(tmp_path: Path, group: str, hangs: bool) -> None:
    read(tmp_path, CALL_SYNC, "CALL_SYNC(client_, request);", group=group)
    _, shown = run("check", "-q", "--source", tmp_path)
    assert ("[callback-deadlock]" in shown) == hangs, shown


@pytest.mark.parametrize(
    ("tick", "is_held"),
    [
        ("LOCKED(LOCKED(state_pub_->publish(String())));", True),
        ("LOCKED(ALSO_LOCKED(state_pub_->publish(String())));", True),
        ("LOCKED(state_pub_->publish(String())); LOCKED(state_pub_->publish(String()));", False),
    ],
)
def test_locks_in_macros(tmp_path: Path, tick: str, is_held: bool) -> None:
    macros = """#define LOCKED(x) do { std::lock_guard<std::mutex> lock(mutex_); x; } while (0)
#define ALSO_LOCKED(x) do { std::lock_guard<std::mutex> lock(mutex_); x; } while (false)"""
    facts = read(tmp_path, macros, tick)
    assert (("lock", HELD) in done(facts)) == is_held, done(facts)


def test_macros_make_ports_and_publish(tmp_path: Path) -> None:
    macros = """#define DECLARE_PUB(name, type) name##_pub_ = create_publisher<type>("~/" #name, 10)
#define ALL(X) X(state, String); X(other, String);
#define SEND(name) name##_pub_->publish(String())"""
    facts = read(tmp_path, macros, "SEND(state); if (client_) SEND(other);", "ALL(DECLARE_PUB)")
    (node,) = facts.nodes
    assert [each.name for each in node.entities if each.kind == "publishers"] == ["~/state", "~/other"]
    assert not facts.unread
    assert [each for each, _ in done(facts)] == ["publish", "publish"]


@pytest.mark.parametrize(
    ("text", "result"),
    [
        ('#define A(x, y) x##y #x\nA(a b, "c")', 'a b"c" "a b"'),
        ('#define A(x) #x\nA("s\\n")', r'"\"s\\n\""'),
        ("#define A(f, ...) f(1, ##__VA_ARGS__)\nA(g) A(g, 2)", "g(1) g(1,2)"),
        ("#define A(f, ...) f(1 __VA_OPT__(,) __VA_ARGS__)\nA(g) A(g, 2)", "g(1  ) g(1 , 2)"),
        ("#define A(x) B(x) \n#define B(x) A(x)\nA(1)", "A(1)"),
        ("#define f(x) f(x, 1)\nf(2)", "f(2, 1)"),
        ("#define A(x) x\n#undef A\nA(1)", "A(1)"),
        ("#define A(x) x\nint A; // A(1)", "int A; // A(1)"),
        ('#define A(x) x\nf("A(1)", R"(A(2))", \'A\', A(3))', 'f("A(1)", R"(A(2))", \'A\', 3)'),
        ("#define A B\n#define B(x) x + 1\nA(2)", "2 + 1"),
        (
            "#define MAX(a, b) (a > b ? a : b)\nMAX(1, MAX(2, 3))",
            "(1 > (2 > 3 ? 2 : 3) ? 1 : (2 > 3 ? 2 : 3))",
        ),
        ('#define N 10\n#define T "x"\nN T', "N T"),
        ("#ifdef WIN\n#define A(x) win(x)\n#else\n#define A(x) x\n#endif\nA(1)", "1"),
        ("/* #define A(x) no(x) */\nA(1)", "A(1)"),
        ("#define A( x \nA(1)", "A(1)"),
    ],
)
def test_macros_expand_as_the_standard_says(text: str, result: str) -> None:
    assert expanded(text) == result


@pytest.mark.parametrize("seen", ['#include "a.hpp"\n', ""])
def test_macros_of_headers_that_are_not_included(seen: str) -> None:
    """Names in small letters may be functions elsewhere; those in capitals are macros."""
    texts = {
        "a.hpp": "#define send(x) x->publish()\n#define SEND(x) send(x)\n",
        "b.cpp": f"{seen}send(p); SEND(p);",
    }
    shown = Macros(texts).expanded("b.cpp", texts["b.cpp"]).splitlines()[-1]
    assert shown == ("p->publish(); p->publish();" if seen else "send(p); send(p);")


def test_hostile_macros_are_named(tmp_path: Path) -> None:
    """Each macro uses the next one twice: 2 ** 39 calls."""
    names = [f"M{number}" for number in range(40)]
    rows = [f"#define {one}(c) {other}(c); {other}(c)" for one, other in pairwise(names)]
    start = time.process_time()
    facts = read(
        tmp_path, "\n".join([*rows, "#define M39(c) c->async_send_request(request).get()"]), "M0(client_);"
    )
    assert time.process_time() - start < 5
    assert [each for each in facts.unread if "M0 is not expanded" in each and "robot.cpp:17: " in each]
    _, shown = run("check", "-q", "--source", tmp_path)
    assert "M0 is not expanded" in shown


EITHER = f"#ifdef FAST\n#define CALL_SYNC(c, r) c->async_send_request(r)\n#else\n{CALL_SYNC}\n#endif"


@pytest.mark.parametrize(
    ("macros", "tick", "why"),
    [
        (CALL_SYNC, "CALL_SYNC(client_);", "the number of arguments"),
        (CALL_SYNC, "CALL_SYNC(client_,\n#ifdef FAST\n request\n#else\n request\n#endif\n);", "directives"),
        (EITHER, "CALL_SYNC(client_, request);", "several meanings"),
    ],
)
def test_what_is_not_expanded_is_named(tmp_path: Path, macros: str, tick: str, why: str) -> None:
    facts = read(tmp_path, macros, tick)
    assert len([each for each in facts.unread if why in each]) == 1, facts.unread


def test_names_under_conditions_are_alternatives(tmp_path: Path) -> None:
    """As m-explore does for two distributions of ROS: the name was open, then one of them was assumed."""
    macros = '#ifdef OLD\n#define NAME "Ask"\n#else\n#define NAME "ask"\n#endif'
    facts = read(tmp_path, macros, makes="server_ = create_service<Trigger>(NAME, [](auto, auto) {});")
    names = [each.name for each in facts.nodes[0].entities if each.kind == "services"]
    assert {"ask", "Ask"} <= set(names)
    assert not facts.unread


def test_macros_that_only_compute_are_quiet(tmp_path: Path) -> None:
    macros = """#ifdef DEBUG
#define LOG(x) std::cout << x
#else
#define LOG(x)
#endif"""
    assert not read(tmp_path, macros, 'LOG("tick");').unread


def test_changed_macros_change_the_facts_of_programs(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    cache.mkdir(mode=0o700)
    folder = tmp_path / "code"
    folder.mkdir()
    read(folder, CALL_SYNC, "CALL_SYNC(client_, request);")
    assert done(read_source(folder, cache=cache)) == [("call", "blocks, without time-out")]
    header = folder / "include" / "robot" / "macros.hpp"
    header.write_text(header.read_text().replace(".get()", ""))
    assert done(read_source(folder, cache=cache)) == [("call", "async")]


BOTH = """
#ifdef FIRST
#include <ros/ros.h>
class Robot : public ros::NodeHandle { void work() { advertise<std_msgs::String>("old", 1); } };
#SECOND
#include "rclcpp/rclcpp.hpp"
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") { out_ = create_publisher<std_msgs::msg::String>("out", 1); }
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr out_;
};
#endif
#if defined(BUILDING_ROS2)
int main(int argc, char ** argv) { rclcpp::init(argc, argv); rclcpp::spin(std::make_shared<Robot>()); }
#else
int main(int argc, char ** argv) { ros::init(argc, argv, "robot"); Robot robot; ros::spin(); }
#endif
"""


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("BUILDING_ROS1", "elif defined BUILDING_ROS2"),
        ("ROS1", "else"),
        ("ROS1_FOUND", "elif defined(ROS2_FOUND) // this one"),
        ("USE_ROS1", "elif ROS2"),
        ("ROS_FOUND", "elif ROS2_FOUND"),
        ("ROS_FOUND", "endif\n#ifdef ROS2_FOUND"),
        ("USE_ROS", "else\n#endif\n#if defined(X) && defined(ROS1) || defined(USE_ROS2)"),
    ],
)
def test_code_for_both_versions_of_ros_is_read_for_ros_2(tmp_path: Path, first: str, second: str) -> None:
    (tmp_path / "robot.cpp").write_text(BOTH.replace("FIRST", first).replace("SECOND", second))
    facts = read_source(tmp_path)
    (node,) = facts.nodes
    assert (node.name, node.executor) == ("robot", "SingleThreadedExecutor")
    assert [each.name for each in node.of("publishers")] == ["out"]
    assert facts.unread == []


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("#if 0\na\n#elif X\nb\n#else\nc\n#endif", "#if   X|b|#else|c|#endif"),
        ("#if X\na\n#elif 0\nb\n#else\nc\n#endif", "#if X|a|#else|c|#endif"),
        ("#if X\na\n#elif 1\nb\n#else\nc\n#endif", "#if X|a|#elif 1|b|#else|c|#endif"),
        ("#if 0\n#ifdef Y\na\n#else\nb\n#endif\n#else\nc\n#endif\nd", "c|d"),
        ("#ifndef USE_ROS1\na\n#else\nb\n#endif", "a"),
        ("#if !defined(ROS2)\na\n#elif Y\nb\n#endif", "#if   Y|b|#endif"),
        ("#ifndef ROS2_ROBOT_H\na\n#endif", "#ifndef ROS2_ROBOT_H|a|#endif"),
        ("#endif\n#else\na", "#endif|#else|a"),
        ("#ifdef ROS_FOUND\na\n#endif", "#ifdef ROS_FOUND|a|#endif"),
        ("#ifdef ROS_FOUND\na\n#ifdef ROS2_FOUND\nb\n#endif\n#endif", "#ifdef ROS_FOUND|a|b|#endif"),
        ("#if defined(ROS_FOUND) || defined(ROS2_FOUND)\na\n#endif\n#ifdef ROS_FOUND\nb\n#endif", "a"),
        ("#if !(defined(ROS1) && X)\na\n#endif", "#if !(defined(ROS1) && X)|a|#endif"),
        ("#if defined(ROS1) && X\na\n#endif\n#if 1 && ROS2\nb\n#endif", "b"),
        ("#if __ROS_VERSION == 1\nold\n#elif __ROS_VERSION == 2\nnew\n#else\nnone\n#endif", "new"),
        ("#if defined __ROS_VERSION && __ROS_VERSION > 1\nnew\n#else\nold\n#endif", "new"),
        ("#if !(ROS_VERSION >= 2)\nold\n#else\nnew\n#endif", "new"),
        ("#ifndef ROS_VERSION\nnone\n#else\nnew\n#endif", "new"),
        ("#if __ROS_VERSION > 0\nany\n#endif", "any"),
        ("#if ROS_VERSION_MINOR > 0\nany\n#endif", "#if ROS_VERSION_MINOR > 0|any|#endif"),
    ],
)
def test_branches_that_are_never_compiled_are_blank(text: str, expected: str) -> None:
    found = without_dead(text)
    assert [line.strip() for line in found.split("\n") if line.strip()] == expected.split("|")
    assert [len(line) for line in found.split("\n")] == [len(line) for line in text.split("\n")]
