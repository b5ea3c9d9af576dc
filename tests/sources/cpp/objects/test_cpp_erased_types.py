"""Objects behind a class that hides their types, made with functions of Boost or of the standard library."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

ERASED = """
#include <rclcpp/rclcpp.hpp>
using Text = std_msgs::msg::String;
class Part {
 public:
  template<typename T> Part(const T & part) : held_(SPACE::make_shared<Model<T> >(part)) {}
  void reset(rclcpp::Node * node) { held_->reset(node); }
 private:
  struct Concept { virtual ~Concept() {} virtual void reset(rclcpp::Node * node) = 0; };
  template<typename T> struct Model : public Concept {
    Model(const T & other) : part_(other) {}
    void reset(rclcpp::Node * node) { part_->reset(node); }
    T part_;
  };
  SPACE::shared_ptr<Concept> held_;
};
template<class T> class Speaker {
 public:
  Speaker(const std::string & topic) : topic_(topic) {}
  void reset(rclcpp::Node * node) { pub_ = node->create_publisher<T>(topic_, 10); }
  std::string topic_;
  typename rclcpp::Publisher<T>::SharedPtr pub_;
};
class Hearer {
 public:
  Hearer(const std::string & topic) : topic_(topic) {}
  void reset(rclcpp::Node * node) {
    SPACE::function<void(Text::SharedPtr)> told =
      SPACE::bind(&Hearer::on_text, this, SPACE::placeholders::_1);
    sub_ = node->create_subscription<Text>(topic_, 10, told);
  }
  void on_text(const Text::SharedPtr) {}
  std::string topic_;
  rclcpp::Subscription<Text>::SharedPtr sub_;
};
class Driver : public rclcpp::Node {
 public:
  Driver() : Node("driver") {}
  void run() {
    add("speaker", SPACE::make_shared<Speaker<Text> >("out"));
    add("hearer", SPACE::make_shared<Hearer>("in"));
    typedef std::map<std::string, Part> Parts;
    for (Parts::value_type & part : parts_) { part.second.reset(this); }
    while (rclcpp::ok()) { rclcpp::spin_some(this->get_node_base_interface()); }
  }
  void add(const std::string & name, Part part) {
    parts_.insert(std::map<std::string, Part>::value_type(name, part));
  }
  std::map<std::string, Part> parts_;
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  auto driver = SPACE::make_shared<Driver>();
  driver->run();
}
"""


@pytest.mark.parametrize("space", ["std", "boost"])
def test_ports_of_objects_whose_type_a_class_hides(tmp_path: Path, space: str) -> None:
    (tmp_path / "driver.cpp").write_text(ERASED.replace("SPACE", space))
    facts = read_source(tmp_path)
    (node,) = facts.nodes
    assert [(each.name, each.type) for each in node.of("publishers")] == [("out", "std_msgs/msg/String")]
    (heard,) = node.of("subscriptions")
    assert (heard.name, heard.callbacks["callback"].name) == ("in", "on_text")
    assert (node.threads, facts.unread) == (1, [])


def test_an_object_of_the_class_itself_is_not_made_again(tmp_path: Path) -> None:
    text = ERASED.replace("SPACE", "std").replace(
        'add("hearer", std::make_shared<Hearer>("in"));',
        'Part part(std::make_shared<Hearer>("in")); add("hearer", part);',
    )
    (tmp_path / "driver.cpp").write_text(text)
    (node,) = read_source(tmp_path).nodes
    assert [each.name for each in node.of("subscriptions")] == ["in"]
