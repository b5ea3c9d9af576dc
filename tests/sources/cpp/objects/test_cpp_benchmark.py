"""A program in the form of the timing benchmark of ROS 2's real-time working group: 24 nodes of a car.

Templates choose the kinds of nodes and their times, a function returns all nodes in a list, and settings name
their topics.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from dineros.cli.main import main
from dineros.sources.facts import NodeFact
from dineros.sources.reading import read_source

SOURCES = {
    "front_lidar": 0.1,
    "rear_lidar": 0.1,
    "map": 0.12,
    "screen": 0.06,
    "lanes": 0.1,
    "settings": 0.025,
}
STAGES = {
    "front_points": "front_lidar",
    "rear_points": "rear_lidar",
    "grid": "cloud",
    "map_loader": "map",
    "ground": "cloud",
    "collisions": "clusters",
    "steering": "behaviour",
    "parking": "lane_loader",
    "lane_plan": "lane_loader",
}
JOINS = {
    "cloud": ("front_points", "rear_points"),
    "localizer": ("grid", "map_loader"),
    "vehicle": ("steering", "behaviour"),
    "route": ("screen", "localizer"),
    "lane_loader": ("lanes", "route"),
}
PLANNED = ("collisions", "localizer", "route", "lane_loader", "parking", "lane_plan")
SPLITS = {"ground": "clusters", "settings": "remainder"}
SINKS = {"drive": "vehicle", "rest": "remainder"}

KINDS = """
#pragma once
#include <chrono>
#include <memory>
#include <string>
#include <vector>
#include "rclcpp/rclcpp.hpp"
#include "car/msg/sample.hpp"
using Sample = car::msg::Sample;
namespace car::settings {
struct Source { std::string name; std::chrono::nanoseconds period; };
struct Stage { std::string name; std::string from; int work; };
struct Join { std::string name; std::string left; std::string right; int work; };
struct Planner { std::string name; std::vector<std::string> from; std::chrono::nanoseconds period; };
struct Split {
  struct Part { std::string from; std::string to; }; std::string name; std::vector<Part> parts; };
struct Sink { std::string name; std::string from; };
}
namespace car::parts {
class Source : public rclcpp::Node {
public:
  explicit Source(const settings::Source & given) : Node(given.name) {
    out_ = create_publisher<Sample>(given.name, 1);
    timer_ = create_wall_timer(given.period, [this] { tick(); });
  }
private:
  void tick() { auto sample = out_->borrow_loaned_message(); out_->publish(std::move(sample)); }
  rclcpp::Publisher<Sample>::SharedPtr out_;
  rclcpp::TimerBase::SharedPtr timer_;
};
class Stage : public rclcpp::Node {
public:
  explicit Stage(const settings::Stage & given) : Node(given.name), work_(given.work) {
    in_ = create_subscription<Sample>(given.from, 1, [this](const Sample::SharedPtr sample) { on(sample); });
    out_ = create_publisher<Sample>(given.name, 1);
  }
private:
  void on(const Sample::SharedPtr & sample) {
    auto made = out_->borrow_loaned_message();
    made.get().count = sample->count + work_;
    out_->publish(std::move(made));
  }
  rclcpp::Subscription<Sample>::SharedPtr in_;
  rclcpp::Publisher<Sample>::SharedPtr out_;
  int work_;
};
class Join : public rclcpp::Node {
public:
  explicit Join(const settings::Join & given) : Node(given.name) {
    sides_[0].in = create_subscription<Sample>(
      given.left, 1, [this](const Sample::SharedPtr sample) { on(0U, sample); });
    sides_[1].in = create_subscription<Sample>(
      given.right, 1, [this](const Sample::SharedPtr sample) { on(1U, sample); });
    out_ = create_publisher<Sample>(given.name, 1);
  }
private:
  void on(uint64_t side, const Sample::SharedPtr sample) {
    sides_[side].last = sample;
    if (!sides_[0].last || !sides_[1].last) { return; }
    out_->publish(std::move(out_->borrow_loaned_message()));
    sides_[0].last.reset();
    sides_[1].last.reset();
  }
  struct Side { rclcpp::Subscription<Sample>::SharedPtr in; Sample::SharedPtr last; };
  Side sides_[2];
  rclcpp::Publisher<Sample>::SharedPtr out_;
};
class Planner : public rclcpp::Node {
public:
  explicit Planner(const settings::Planner & given) : Node(given.name) {
    uint64_t number = 0U;
    for (const auto & topic : given.from) {
      inputs_.emplace_back(Input{
        create_subscription<Sample>(
          topic, 1, [this, number](const Sample::SharedPtr sample) { inputs_[number].last = sample; }),
        Sample::SharedPtr()});
      ++number;
    }
    out_ = create_publisher<Sample>(given.name, 1);
    timer_ = create_wall_timer(given.period, [this] { plan(); });
  }
private:
  struct Input { rclcpp::Subscription<Sample>::SharedPtr in; Sample::SharedPtr last; };
  void plan() {
    auto made = out_->borrow_loaned_message();
    for (auto & each : inputs_) { if (!each.last) { continue; } each.last.reset(); }
    out_->publish(std::move(made));
  }
  std::vector<Input> inputs_;
  rclcpp::Publisher<Sample>::SharedPtr out_;
  rclcpp::TimerBase::SharedPtr timer_;
};
class Split : public rclcpp::Node {
public:
  explicit Split(const settings::Split & given) : Node(given.name) {
    for (auto & part : given.parts) {
      ways_.emplace_back(Way{
        create_publisher<Sample>(part.to, 1),
        create_subscription<Sample>(
          part.from, 1, [this, id = ways_.size()](const Sample::SharedPtr sample) { on(sample, id); })});
    }
  }
private:
  struct Way { rclcpp::Publisher<Sample>::SharedPtr out; rclcpp::Subscription<Sample>::SharedPtr in; };
  void on(const Sample::SharedPtr, uint64_t id) {
    auto made = ways_[id].out->borrow_loaned_message();
    ways_[id].out->publish(std::move(made));
  }
  std::vector<Way> ways_;
};
class Sink : public rclcpp::Node {
public:
  explicit Sink(const settings::Sink & given) : Node(given.name) {
    in_ = create_subscription<Sample>(given.from, 10, [this](const Sample::SharedPtr sample) { on(sample); });
  }
private:
  void on(const Sample::SharedPtr) {}
  rclcpp::Subscription<Sample>::SharedPtr in_;
};
}
struct Parts {
  using Base = rclcpp::Node;
  using Source = car::parts::Source;
  using Stage = car::parts::Stage;
  using Join = car::parts::Join;
  using Planner = car::parts::Planner;
  using Split = car::parts::Split;
  using Sink = car::parts::Sink;
};
"""
BUILDER = """
#pragma once
#include "kinds.hpp"
struct Times {
  using time_t = std::chrono::nanoseconds;
  using milliseconds = std::chrono::milliseconds;
  CONSTANTS
  static constexpr int WORK = 4096;
};
template<typename System, typename Times>
auto make_car() -> std::vector<std::shared_ptr<typename System::Base>>
{
  std::vector<std::shared_ptr<typename System::Base>> all;
  MADE
  return all;
}
"""
MAIN = """
#include "builder.hpp"
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  using Chosen = Times;
  auto all = make_car<Parts, Chosen>();
  REST
  rclcpp::shutdown();
}
"""
ALL_IN_ONE = """rclcpp::executors::KIND executor;
  for (auto & each : all) { executor.add_node(each); }
  executor.spin();"""
FRONT = ("front_lidar", "front_points")
TWO = """std::unordered_map<std::string, std::shared_ptr<Parts::Base>> by_name;
  for (const auto & each : all) { by_name.emplace(each->get_name(), each); }
  rclcpp::executors::SingleThreadedExecutor front, others;
  std::set<std::string> in_front = {FRONT};
  std::set<std::string> elsewhere = {OTHERS};
  for (const auto & each : in_front) { front.add_node(by_name.at(each)); }
  for (const auto & each : elsewhere) { others.add_node(by_name.at(each)); }
  std::thread first {[&]() { front.spin(); }};
  std::thread second {[&]() { others.spin(); }};
  first.join();
  second.join();"""


def _node(kind: str, *members: str) -> str:
    return (
        f"all.emplace_back(std::make_shared<typename System::{kind}>("
        f"car::settings::{kind}{{{', '.join(members)}}}));"
    )


def _text(*words: str) -> str:
    return ", ".join(f'"{each}"' for each in words)


def _written(folder: Path, rest: str) -> Path:
    constants = [
        f"static constexpr time_t {name.upper()} = milliseconds({round(period * 1000)});"
        for name, period in {**SOURCES, "behaviour": 0.1}.items()
    ]
    made = [_node("Source", f'.name = "{name}"', f".period = Times::{name.upper()}") for name in SOURCES]
    made += [
        _node("Stage", f'.name = "{name}"', f'.from = "{topic}"', ".work = Times::WORK")
        for name, topic in STAGES.items()
    ]
    made += [
        _node("Join", f'.name = "{name}"', f'.left = "{a}"', f'.right = "{b}"', ".work = Times::WORK")
        for name, (a, b) in JOINS.items()
    ]
    made.append(
        _node(
            "Planner", '.name = "behaviour"', f".from = {{{_text(*PLANNED)}}}", ".period = Times::BEHAVIOUR"
        )
    )
    parts = ", ".join(f'{{.from = "{a}", .to = "{b}"}}' for a, b in SPLITS.items())
    made.append(_node("Split", '.name = "detector"', f".parts = {{{parts}}}"))
    made += [_node("Sink", f'.name = "{name}"', f'.from = "{topic}"') for name, topic in SINKS.items()]
    folder.mkdir()
    (folder / "kinds.hpp").write_text(KINDS)
    text = BUILDER.replace("CONSTANTS", "\n  ".join(constants)).replace("MADE", "\n  ".join(made))
    (folder / "builder.hpp").write_text(text)
    (folder / "car.cpp").write_text(MAIN.replace("REST", rest))
    return folder


def _expected() -> dict[str, tuple[set[str], dict[str, set[str]], list[float]]]:
    """Return, by node: its publications, what each subscription's callback publishes, and its periods."""
    found: dict[str, tuple[set[str], dict[str, set[str]], list[float]]] = {}
    found |= {name: ({name}, {}, [period]) for name, period in SOURCES.items()}
    found |= {name: ({name}, {topic: {name}}, []) for name, topic in STAGES.items()}
    found |= {name: ({name}, {a: {name}, b: {name}}, []) for name, (a, b) in JOINS.items()}
    found["behaviour"] = ({"behaviour"}, {each: set() for each in PLANNED}, [0.1])
    found["detector"] = (set(SPLITS.values()), {a: {b} for a, b in SPLITS.items()}, [])
    return found | {name: (set(), {topic: set()}, []) for name, topic in SINKS.items()}


def _found(node: NodeFact) -> tuple[set[str], dict[str, set[str]], list[float]]:
    does = {
        each.name: {
            effect.entity.name
            for effect in each.callbacks["callback"].effects
            if effect.do == "publish" and effect.entity is not None
        }
        for each in node.of("subscriptions")
    }
    periods = [each.details["period"] for each in node.of("timers")]
    return {each.name for each in node.of("publishers")}, does, periods


@pytest.mark.parametrize(
    ("kind", "threads"), [("SingleThreadedExecutor", 1), ("MultiThreadedExecutor", "processors")]
)
def test_all_nodes_come_out_right(tmp_path: Path, kind: str, threads: int | str) -> None:
    facts = read_source(_written(tmp_path / "car", ALL_IN_ONE.replace("KIND", kind)))
    assert {node.name: _found(node) for node in facts.nodes} == _expected()
    assert len(facts.nodes) == 24
    assert {(node.executor, node.threads) for node in facts.nodes} == {(kind, threads)}
    assert facts.unread == []


def test_two_executors_have_their_nodes(tmp_path: Path) -> None:
    others = [name for name in _expected() if name not in FRONT]
    rest = TWO.replace("FRONT", _text(*FRONT)).replace("OTHERS", _text(*others))
    facts = read_source(_written(tmp_path / "car", rest))
    assert {node.name: _found(node) for node in facts.nodes} == _expected()
    pools = {node.name: node.pool for node in facts.nodes}
    assert 0 not in pools.values()
    assert {name for name, pool in pools.items() if pool == pools["front_lidar"]} == set(FRONT)
    assert len({pool for name, pool in pools.items() if name not in FRONT}) == 1


@pytest.mark.long
def test_the_worst_latency_has_a_bound(tmp_path: Path) -> None:
    """It is that of the benchmark itself, whose nodes have these topics and periods."""
    folder = _written(tmp_path / "car", ALL_IN_ONE.replace("KIND", "SingleThreadedExecutor"))
    model = tmp_path / "car.sym.xmi"
    (tmp_path / "car.given.toml").write_text("[times]\ntakes = [0.01, 0.01]\nlatency = [0, 0.001]\n")
    run = CliRunner().invoke
    assert run(main, ["import", "--no-cache", "-q", "--source", str(folder), "-o", str(model)]).exit_code == 0
    chain = ["--from", "/front_lidar", "--to", "/collisions"]
    answer = run(main, ["latency", "-q", "--bounds", str(model), *chain]).output
    assert "/front_lidar to /collisions: at least 0 s, at most 3.605 s" in answer
