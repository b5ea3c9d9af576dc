"""Operators and destructors in C++ have their effects, and objects with ``operator()`` are callbacks."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.sources.facts import NodeFact
from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

ROBOT = """
#include <rclcpp/rclcpp.hpp>
using std_msgs::msg::String;
using std_srvs::srv::Trigger;
using Client = rclcpp::Client<Trigger>::SharedPtr;
class Remote {
 public:
  explicit Remote(Client client) : client_(client) {}
  bool ask() { return client_->async_send_request(std::make_shared<Trigger::Request>()).get()->success; }
  bool operator[](int) { return ask(); }
  bool operator==(int) { return ask(); }
  Remote & operator<<(int) { ask(); return *this; }
  bool operator()(int) { return ask(); }
  Client client_;
};
class Session {
 public:
  Session(rclcpp::Publisher<String>::SharedPtr out, bool is_loud = false) : out_(out) {}
  ~Session() { out_->publish(String()); }
  rclcpp::Publisher<String>::SharedPtr out_;
};
struct Relay {
  rclcpp::Publisher<String>::SharedPtr out;
  void operator()(String::ConstSharedPtr message) const { out->publish(*message); }
};
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    out_ = create_publisher<String>("out", 1);
    client_ = create_client<Trigger>("ask");
    remote_ = std::make_unique<Remote>(client_);
    timer_ = create_wall_timer(std::chrono::seconds(1), std::bind(&Robot::tick, this));
    jobs_.push([this]() { remote_->ask(); });
    sub_ = create_subscription<String>("in", 1, Relay{out_});
  }
  void tick() { TICK }
  Remote * next() { return remote_.get(); }
  rclcpp::Publisher<String>::SharedPtr out_;
  Client client_;
  std::unique_ptr<Remote> remote_;
  std::queue<std::function<void()>> jobs_;
  rclcpp::TimerBase::SharedPtr timer_;
  rclcpp::Subscription<String>::SharedPtr sub_;
};
int main() { rclcpp::spin(std::make_shared<Robot>()); }
"""


def _read(folder: Path, tick: str = "") -> NodeFact:
    (folder / "robot.cpp").write_text(ROBOT.replace("TICK", tick))
    (node,) = read_source(folder).nodes
    return node


def _effects(node: NodeFact, name: str) -> list[tuple[str, str]]:
    (fact,) = [each for each in node.callbacks if each.name == name]
    return [(each.do, each.when) for each in fact.effects]


@pytest.mark.parametrize(
    ("tick", "does"),
    [
        ("auto it = (*remote_)[1];", [("call", "always")]),
        ("if (*remote_ == 1) { return; }", [("call", "always")]),
        ("*remote_ << 1;", [("call", "always")]),
        ("(*remote_)(1);", [("call", "always")]),
        ("Session session(out_); (*remote_)[1];", [("call", "always"), ("publish", "always")]),
        ("Session session{out_, true}; if (x_) { return; } remote_->ask();", None),
        ("if (x_) { Session session(out_); }", [("publish", "conditional")]),
        ("if (auto remote = remote_.get()) { remote->ask(); }", [("call", "conditional")]),
        ("if (Remote * remote = remote_.get()) { remote->ask(); }", [("call", "conditional")]),
        ("while (auto remote = next()) { remote->ask(); }", [("call", "in a loop")]),
        ("auto pair = std::make_tuple(client_, 1); Remote(std::get<0>(pair)).ask();", [("call", "always")]),
        (
            "auto pair = std::make_tuple(client_, 1); auto & [client, number] = pair; Remote(client).ask();",
            [("call", "always")],
        ),
        ("while (!jobs_.empty()) { jobs_.front()(); jobs_.pop(); }", [("call", "in a loop")]),
        ("Session & session = *sessions_; auto other = vendor::make();", []),
    ],
)
def test_operators_and_destructors_are_called(
    tmp_path: Path, tick: str, does: list[tuple[str, str]] | None
) -> None:
    """What they do was missing, and the callback was proved to end."""
    found = _effects(_read(tmp_path, tick), "tick")
    if does is None:
        assert [each for each, _ in found] == ["call", "publish"]
    else:
        assert found == does


def test_an_object_is_a_callback(tmp_path: Path) -> None:
    """Its callback was open."""
    assert _effects(_read(tmp_path), "operator()") == [("publish", "always")]


def test_constants_in_braces(tmp_path: Path) -> None:
    text = """
#include <rclcpp/rclcpp.hpp>
namespace names { const std::string kOut{"names/out"}; const int kDepth(7);
const std::string kAll[] = {"a"}; }
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") { out_ = create_publisher<std_msgs::msg::String>(names::kOut, names::kDepth); }
  rclcpp::PublisherBase::SharedPtr out_;
};
int main() { rclcpp::spin(std::make_shared<Robot>()); }
"""
    (tmp_path / "robot.cpp").write_text(text)
    (node,) = read_source(tmp_path).nodes
    assert [(each.name, each.details["depth"]) for each in node.of("publishers")] == [("names/out", 7)]
