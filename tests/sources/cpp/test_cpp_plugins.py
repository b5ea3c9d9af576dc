"""Plugins of ``pluginlib``: loaded by a name that is known or not, exported by macros; controllers."""

from __future__ import annotations

from pathlib import Path

from dineros.sources.facts import Facts
from dineros.sources.reading import read_source

BASE = """
#include <rclcpp/rclcpp.hpp>
#include <pluginlib/class_loader.hpp>
namespace parts {
class Part {
 public:
  virtual ~Part() = default;
  virtual void begin(rclcpp::Node::SharedPtr node) = 0;
};
}
"""
PARTS = """
#include "base.hpp"
#define REGISTER_PART(Class) \\
  PLUGINLIB_EXPORT_CLASS(parts::Class, parts::Part)
namespace parts {
class Lamp : public Part {
 public:
  void begin(rclcpp::Node::SharedPtr node) override {
    pub_ = node->create_publisher<std_msgs::msg::Bool>("lamp", 1);
  }
  rclcpp::Publisher<std_msgs::msg::Bool>::SharedPtr pub_;
};
template <typename T>
class Wheel : public Part {
 public:
  void begin(rclcpp::Node::SharedPtr node) override {
    pub_ = node->create_publisher<T>("wheel", 2);
  }
  typename rclcpp::Publisher<T>::SharedPtr pub_;
};
}
REGISTER_PART(Lamp)
PLUGINLIB_EXPORT_CLASS(parts::Wheel<std_msgs::msg::Float64>, parts::Part)
"""
MAIN = """
#include "base.hpp"
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot"), loader_("parts", "parts::Part") {}
  void start() {
    DECLARE
    part_ = loader_.createSharedInstance(NAME);
    part_->begin(shared_from_this());
  }
  pluginlib::ClassLoader<parts::Part> loader_;
  std::shared_ptr<parts::Part> part_;
};
int main() { auto robot = std::make_shared<Robot>(); robot->start(); rclcpp::spin(robot); }
"""
DESCRIPTION = """
<library path="parts"><class name="bulb" type="parts::Lamp" base_class_type="parts::Part"/></library>
"""


def robot(folder: Path, name: str, declare: str = "") -> Facts:
    """Return the facts of a program that loads a plugin by a name."""
    (folder / "base.hpp").write_text(BASE)
    (folder / "parts.cpp").write_text(PARTS)
    (folder / "plugins.xml").write_text(DESCRIPTION)
    (folder / "main.cpp").write_text(MAIN.replace("NAME", name).replace("DECLARE", declare))
    return read_source(folder)


def ports(facts: Facts) -> list[tuple[str, str, bool]]:
    """Return name and type of publishers, and whether they are certain."""
    found = [each for node in facts.nodes for each in node.entities if each.kind == "publishers"]
    return sorted((each.name, each.type, "conditional" not in each.details) for each in found)


def test_a_plugin_is_loaded_by_its_name_or_its_class(tmp_path: Path) -> None:
    """The plugin description gives the name; without one, the class has slashes."""
    assert ports(robot(tmp_path, '"bulb"')) == [("lamp", "std_msgs/msg/Bool", True)]
    by_class = robot(tmp_path, "kind", 'auto kind = declare_parameter("kind", "parts/Lamp");')
    assert ports(by_class) == [("lamp", "std_msgs/msg/Bool", True)]
    assert not any("plugin is not known" in each for each in by_class.unread)


def test_each_plugin_is_possible_if_the_name_is_not_known(tmp_path: Path) -> None:
    """The ports are conditional, with the arguments of templates; a line says so."""
    facts = robot(tmp_path, "kind", 'auto kind = declare_parameter("kind", rclcpp::PARAMETER_STRING);')
    assert ports(facts) == [("lamp", "std_msgs/msg/Bool", False), ("wheel", "std_msgs/msg/Float64", False)]
    assert facts.unread == [
        "main.cpp:8: the name of the plugin is not known; one of the 2 plugins of the folder with this base "
        "class, or one from elsewhere"
    ]


def test_of_many_plugins_with_an_unknown_name_none_is_taken(tmp_path: Path) -> None:
    """The line says how many there are; a program that loads all declared classes has their ports."""
    more = "".join(
        f"namespace parts {{ class Lamp{n} : public Lamp {{}}; }}\nREGISTER_PART(Lamp{n})\n" for n in range(3)
    )
    declare = 'auto kind = declare_parameter("kind", rclcpp::PARAMETER_STRING);'
    robot(tmp_path, "kind", declare)
    (tmp_path / "parts.cpp").write_text(PARTS + more)
    facts = read_source(tmp_path)
    assert ports(facts) == []
    assert any("one of the 5 plugins of the folder" in each for each in facts.unread)
    main = MAIN.replace("DECLARE", "for (const auto & kind : loader_.getDeclaredClasses()) {")
    main = main.replace("NAME);", "kind);").replace("shared_from_this());", "shared_from_this()); }")
    (tmp_path / "main.cpp").write_text(main)
    assert len(ports(read_source(tmp_path))) > 1


def test_a_plugin_from_elsewhere_is_not_replaced_by_one_of_the_folder(tmp_path: Path) -> None:
    """A known name without a class in the folder gives a line and no ports."""
    facts = robot(tmp_path, '"other/Arm"')
    assert ports(facts) == []
    assert any("begin receives the node, but its code is not in the folder" in each for each in facts.unread)


def test_a_controller_has_a_node_of_its_own(tmp_path: Path) -> None:
    """``get_node`` returns it; names that begin with its name are private; ``update`` runs on a thread."""
    (tmp_path / "controller.cpp").write_text("""
#include <controller_interface/controller_interface.hpp>
namespace wheels {
class Controller : public controller_interface::ControllerInterface {
 public:
  CallbackReturn on_init() override { return CallbackReturn::SUCCESS; }
  CallbackReturn on_configure(const rclcpp_lifecycle::State &) override {
    pub_ = get_node()->create_publisher<std_msgs::msg::Bool>("~/on", rclcpp::SystemDefaultsQoS());
    srv_ = get_node()->create_service<std_srvs::srv::Trigger>(
      std::string(get_node()->get_name()) + "/stop", std::bind(&Controller::stop, this, _1, _2));
    return CallbackReturn::SUCCESS;
  }
  return_type update(const rclcpp::Time &, const rclcpp::Duration &) override {
    pub_->publish(message_);
    return return_type::OK;
  }
  void stop(Request::SharedPtr, Response::SharedPtr) {}
  std_msgs::msg::Bool message_;
  rclcpp::Publisher<std_msgs::msg::Bool>::SharedPtr pub_;
  rclcpp::Service<std_srvs::srv::Trigger>::SharedPtr srv_;
};
}
PLUGINLIB_EXPORT_CLASS(wheels::Controller, controller_interface::ControllerInterface)
""")
    (node,) = read_source(tmp_path).nodes
    assert (node.managed, node.name) == (True, "open: the controller manager gives the name")
    assert [each.name for each in node.entities] == ["~/on", "~/stop"]
    kinds = {each.name: (each.kind, [one.do for one in each.effects]) for each in node.callbacks}
    assert kinds["on_init"][0] == kinds["on_configure"][0] == "transition"
    assert kinds["update"] == ("thread", ["publish"])
