"""Fields of messages in C++ that decide about branches, and what publishers put into them."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.observation.importing.coded import coded
from dineros.sources.facts import Facts
from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

MESSAGE = "uint8 IDLE=0\nuint8 BUSY=1\nuint8 state\nbool data\n"
CODE = """
#include <rclcpp/rclcpp.hpp>
using arm_msgs::msg::Mode;
using Text = std_msgs::msg::String;
class Lamp : public rclcpp::Node {
 public:
  Lamp() : Node("lamp") {
    lit_ = create_publisher<Text>("lit", 1);
    alarm_ = create_publisher<Text>("alarm", 1);
    sub_ = create_subscription<Mode>("mode", DEPTH, [this](PARAMETERS) { BODY });
  }
  rclcpp::Publisher<Text>::SharedPtr lit_, alarm_;
  rclcpp::Subscription<Mode>::SharedPtr sub_;
  Mode last_;
};
class Switch : public rclcpp::Node {
 public:
  Switch() : Node("switch") {
    out_ = create_publisher<Mode>("mode", 1);
    timer_ = create_wall_timer(std::chrono::seconds(1), [this]() { tick(); });
  }
  void tick() { SENDS }
  bool on_ = false;
  rclcpp::Publisher<Mode>::SharedPtr out_;
  rclcpp::TimerBase::SharedPtr timer_;
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  rclcpp::executors::SingleThreadedExecutor executor;
  auto lamp = std::make_shared<Lamp>();
  auto sender = std::make_shared<Switch>();
  executor.add_node(lamp);
  executor.add_node(sender);
  executor.spin();
}
"""
LIT, ALARM = "lit_->publish(Text());", "alarm_->publish(Text());"
ASKS = f"if (msg->data) {{ {LIT} }} else {{ {ALARM} }}"
TRUE = "Mode m; m.data = true; out_->publish(m);"
POINTER = "const Mode::SharedPtr msg"


def read(folder: Path, sends: str, body: str, parameters: str = POINTER, depth: str = "1") -> Facts:
    """Return the facts of two nodes."""
    text = CODE
    for word, each in (("SENDS", sends), ("BODY", body), ("PARAMETERS", parameters), ("DEPTH", depth)):
        text = text.replace(word, each)
    (folder / "lamp.cpp").write_text(text)
    package = folder / "arm_msgs" / "msg"
    package.mkdir(parents=True)
    (package / "Mode.msg").write_text(MESSAGE)
    (package.parent / "package.xml").write_text("<package><name>arm_msgs</name></package>")
    return read_source(folder)


def decides(facts: Facts) -> bool:
    """Return whether a field of messages decides in the model."""
    return any(" decides; " in each for each in coded([(".", facts)], "lamp").lacks)


@pytest.mark.parametrize(
    ("sends", "value"),
    [
        (TRUE, True),
        ("arm_msgs::msg::Mode m{}; m.data = false; out_->publish(m);", False),
        ("auto m = Mode(); m.data = true; m.text = name(); out_->publish(m);", True),
        ("auto m = std::make_unique<Mode>(); m->data = true; out_->publish(std::move(m));", True),
        ("auto m = std::make_shared<Mode>(); m->data = true; out_->publish(*m);", True),
        ("if (on_) { Mode m; m.data = true; out_->publish(m); }", True),
    ],
)
def test_fields_that_a_block_assigns_are_sent(tmp_path: Path, sends: str, value: bool) -> None:
    """The message is declared, filled and published in one block."""
    facts = read(tmp_path, sends, ASKS)
    (effect,) = [
        each
        for node in facts.nodes
        for one in node.callbacks
        for each in one.effects
        if each.do == "publish" and each.what == "out_"
    ]
    assert effect.sends == {"data": ("const", "bool", value)}
    assert decides(facts)


@pytest.mark.parametrize(
    "sends",
    [
        "Mode m; m.data = on_; out_->publish(m);",
        "Mode m; m.data = true; change(m); out_->publish(m);",
        "Mode m; m.data = true; if (on_) { m.data = false; } out_->publish(m);",
        "Mode m; if (on_) { m.data = true; } out_->publish(m);",
        "Mode m; m.data = true; m.data = on_; out_->publish(m);",
        "Mode m; m.data = true; auto & other = m; other.data = false; out_->publish(m);",
        "Mode m; m.data = true; auto f = [&m]() { m.data = false; }; f(); out_->publish(m);",
        "static Mode m; for (int i = 0; i < 2; ++i) { out_->publish(m); m.data = true; }",
        "Mode m; m.data = true; m.data |= on_; out_->publish(m);",
        "Mode m; m.data = true; std::swap(m.data, on_); out_->publish(m);",
        "Mode m; out_->publish(m); m.data = true; out_->publish(m);",
        "Mode m; m.data = true; m = Mode(); out_->publish(m);",
        f"{TRUE} Mode other; other.data = false; out_->publish(other);",
    ],
)
def test_other_fields_stay_open(tmp_path: Path, sends: str) -> None:
    """What may have another value in some run decides nothing if the queue is longer than one."""
    assert not decides(read(tmp_path, sends, ASKS, depth="5"))


@pytest.mark.parametrize(
    ("parameters", "body"),
    [
        (POINTER, ASKS),
        ("const Mode & msg", ASKS.replace("->data", ".data")),
        ("Mode::ConstSharedPtr msg", f"if (!msg->data) {{ {ALARM} return; }} {LIT}"),
        ("Mode::UniquePtr msg, const rclcpp::MessageInfo & info", ASKS),
        (POINTER, f"if (msg->data == true && on()) {{ {LIT} }}"),
        (POINTER, f"if (msg->state == Mode::BUSY) {{ {LIT} }} else {{ {ALARM} }}"),
        (POINTER, f"switch (msg->state) {{ case Mode::BUSY: {LIT} break; default: {ALARM} }}"),
    ],
)
def test_tests_of_the_received_message_decide(tmp_path: Path, parameters: str, body: str) -> None:
    """As in Python; constants of the message are known."""
    sends = "Mode m; m.data = true; m.state = Mode::BUSY; out_->publish(m);"
    sends += "Mode other; other.data = false; other.state = Mode::IDLE; out_->publish(other);"
    assert decides(read(tmp_path, sends, body, parameters))


@pytest.mark.parametrize(
    ("parameters", "body"),
    [
        ("Mode::SharedPtr msg", f"msg->data = on(); {ASKS}"),
        ("Mode::SharedPtr msg", f"change(msg); {ASKS}"),
        ("Mode::SharedPtr msg", f"msg = other(); {ASKS}"),
        ("Mode msg", f"msg = last_; {ASKS.replace('->data', '.data')}"),
        (POINTER, f"if (last_.data) {{ {LIT} }} else {{ {ALARM} }}"),
        (POINTER, f"auto f = [msg, this]() {{ {ASKS} }}; f();"),
    ],
)
def test_messages_that_may_change_decide_nothing(tmp_path: Path, parameters: str, body: str) -> None:
    """Also another message, and one that another function receives."""
    assert not decides(read(tmp_path, TRUE, body, parameters))
