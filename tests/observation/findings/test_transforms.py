"""Lookups of transforms that wait in vain are found at their lines; those that can be answered are not."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.observation.findings.code import code_findings
from dineros.observation.importing.coded import coded
from dineros.sources.reading import read_source

PYTHON = """
import time, rclpy
from rclpy.node import Node
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.duration import Duration
from rclpy.executors import MultiThreadedExecutor
from rclpy.time import Time
from tf2_ros import Buffer, TransformListener

class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.buffer = Buffer()
        self.listener = TransformListener(self.buffer, self{listener})
        self.create_timer(1.0, self.tick)
        {start}
    def tick(self):
        {tick}

rclpy.init()
{spin}
"""
CPP = """
#include <rclcpp/rclcpp.hpp>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>
using namespace std::chrono_literals;
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    buffer_ = std::make_unique<tf2_ros::Buffer>(get_clock());
    DEDICATED
    listener_ = std::make_shared<tf2_ros::TransformListener>(*buffer_, this LISTENER);
    timer_ = create_wall_timer(1s, [this]() { TICK });
  }
  std::unique_ptr<tf2_ros::Buffer> buffer_;
  std::shared_ptr<tf2_ros::TransformListener> listener_;
  rclcpp::TimerBase::SharedPtr timer_;
};
int main() { rclcpp::init(0, nullptr); rclcpp::spin(std::make_shared<Robot>()); }
"""
SPIN = "rclpy.spin(Robot())"
THREADS = "executor = MultiThreadedExecutor(4)\nexecutor.add_node(Robot())\nexecutor.spin()"
LOOKUP = "self.buffer.lookup_transform('map', 'base', Time(), timeout=Duration(seconds=1))"
ASK = "self.buffer.can_transform('map', 'base', Time())"
LOOP = f"while not {ASK}: time.sleep(0.1)"


def found(folder: Path, name: str, text: str) -> list[str]:
    (folder / name).write_text(text)
    return [
        f"{each.severity} {each.message}"
        for each in code_findings([(".", read_source(folder))])
        if each.rule == "code-looks-up-in-vain"
    ]


def in_python(
    folder: Path, tick: str, listener: str = "", start: str = "pass", spin: str = SPIN
) -> list[str]:
    text = PYTHON.replace("{tick}", tick).replace("{listener}", listener)
    return found(folder, "robot.py", text.replace("{start}", start).replace("{spin}", spin))


@pytest.mark.parametrize(
    ("tick", "expected"),
    [
        (LOOKUP, "waits 1 s in vain"),
        ("self.buffer.can_transform('a', 'b', Time(), Duration(seconds=2.5))", "waits 2.5 s in vain"),
        ("self.buffer.lookup_transform('a', 'b', Time(), self.limit)", "waits until its time-out in vain"),
        (LOOP, "waits forever"),
        (LOOP.replace("not", "rclpy.ok() and not"), "waits forever"),
    ],
)
def test_the_only_thread_waits(tmp_path: Path, tick: str, expected: str) -> None:
    (one,) = in_python(tmp_path, tick)
    assert expected in one and one.startswith("error" if "forever" in expected else "warning")
    assert in_python(tmp_path, tick, listener=", spin_thread=True") == []
    assert in_python(tmp_path, tick, spin=THREADS) == []


@pytest.mark.parametrize(
    "tick",
    [
        "self.buffer.lookup_transform('map', 'base', Time())",
        ASK,
        f"while not {ASK}: return",
        "self.buffer.lookup_transform('a', 'b', Time(), Duration())",
        "self.buffer.lookup_transform('a', 'b', Time(), Duration(seconds=0))",
    ],
)
def test_lookups_that_do_not_wait(tmp_path: Path, tick: str) -> None:
    assert in_python(tmp_path, tick) == []


def test_a_constructor_waits_before_an_executor_runs(tmp_path: Path) -> None:
    (one,) = in_python(tmp_path, "pass", start=LOOP, spin=THREADS)
    assert "once an executor runs the node: it waits forever" in one
    assert in_python(tmp_path, "pass", start=f"while not {ASK}: rclpy.spin_once(self)") == []


@pytest.mark.parametrize(
    ("tick", "is_lacking"), [(LOOKUP, False), (LOOP, True), ("self.buffer.wait_for_transform_async", False)]
)
def test_the_model_lacks_waits_without_end(tmp_path: Path, tick: str, is_lacking: bool) -> None:
    in_python(tmp_path, tick)
    lacks = coded([(".", read_source(tmp_path))], "test").lacks
    assert any("waits for a transform" in each for each in lacks) is is_lacking


CPP_LOOKUP = 'buffer_->lookupTransform("map", "base", tf2::TimePointZero, {});'
DEDICATED = "buffer_->setUsingDedicatedThread(true);"
CPP_LOOP = (
    'while (rclcpp::ok() && !buffer_->canTransform("a", "b", tf2::TimePointZero)) { rclcpp::sleep_for(1s); }'
)


@pytest.mark.parametrize(
    ("listener", "dedicated", "tick", "expected"),
    [
        (", false", DEDICATED, CPP_LOOKUP.format("2s"), ["waits 2 s in vain"]),
        (", false", DEDICATED, CPP_LOOKUP.format("tf2::durationFromSec(0.5)"), ["waits 0.5 s in vain"]),
        (", false", "", CPP_LOOKUP.format("2s"), []),  # without a thread, it fails at once
        ("", "", CPP_LOOKUP.format("2s"), []),
        (", true", DEDICATED, CPP_LOOKUP.format("2s"), []),
        (", false", "", CPP_LOOP, ["waits forever"]),
        (", false", "", CPP_LOOP.replace("rclcpp::ok() && ", ""), ["waits forever"]),
        ("", "", CPP_LOOP, []),
    ],
)
def test_lookups_in_cpp(
    tmp_path: Path, listener: str, dedicated: str, tick: str, expected: list[str]
) -> None:
    pytest.importorskip("tree_sitter_cpp")
    text = CPP.replace("LISTENER", listener).replace("DEDICATED", dedicated).replace("TICK", tick)
    messages = found(tmp_path, "robot.cpp", text)
    assert len(messages) == len(expected)
    assert all(words in each for words, each in zip(expected, messages, strict=True))
