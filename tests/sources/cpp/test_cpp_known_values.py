"""Values that the code says: parameter libraries, formats, aliases of namespaces, adapted types, pointers."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.sources.facts import Entity, Facts
from dineros.sources.reading import Launch, read_source

NODE = """
#include <rclcpp/rclcpp.hpp>
%s
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    %s
  }
  %s
};
int main() { rclcpp::spin(std::make_shared<Robot>()); }
"""


def read(folder: Path, code: str, before: str = "", members: str = "") -> Facts:
    """Return the facts of a node whose constructor has this code."""
    (folder / "robot.cpp").write_text(NODE % (before, code, members))
    return read_source(folder)


def entities(facts: Facts, kind: str = "publishers") -> list[Entity]:
    """Return the entities of a kind."""
    return [each for node in facts.nodes for each in node.entities if each.kind == kind]


PARAMETERS = """
robot_parameters:
  rate: {type: double, default_value: 4, description: "Hz"}
  topic: {type: string, default_value: "wheels", description: "name"}
  needed: {type: string, description: "no default"}
  arm:
    joint: {type: string, default_value: "elbow", description: "name"}
"""
LISTENS = """
    listener_ = std::make_shared<robot_parameters::ParamListener>(get_node_parameters_interface());
    params_ = listener_->get_params();
    a_ = create_publisher<std_msgs::msg::Bool>(params_.topic, 1);
    b_ = create_publisher<std_msgs::msg::Bool>(params_.arm.joint + "/angle", 1);
    c_ = create_publisher<std_msgs::msg::Bool>(params_.needed, 1);
    timer_ = create_wall_timer(std::chrono::duration<double>(1.0 / params_.rate), [this]() { tick(); });
"""
TICKS = """
  void tick() {
    params_ = listener_->get_params();
    d_ = create_publisher<std_msgs::msg::Bool>(params_.topic + "/late", 1);
  }
  std::shared_ptr<robot_parameters::ParamListener> listener_;
  robot_parameters::Params params_;
"""


def test_a_parameter_library_gives_defaults_and_a_launch_file_other_values(tmp_path: Path) -> None:
    """Parameters in groups, without a default, and read again in a callback."""
    (tmp_path / "parameters.yaml").write_text(PARAMETERS)
    (tmp_path / "package.xml").write_text("<package><name>robots</name></package>")
    (tmp_path / "CMakeLists.txt").write_text(
        "project(robots)\\nadd_executable(robot robot.cpp)\\n"
        "generate_parameter_library(robot_parameters parameters.yaml)".replace("\\n", "\n")
    )
    facts = read(tmp_path, LISTENS, members=TICKS)
    assert [each.name for each in entities(facts)] == [
        "wheels",
        "elbow/angle",
        "open: parameter needed",
        "wheels/late",
    ]
    assert [each.details["period"] for each in entities(facts, "timers")] == [0.25]
    declared = {each.name: each.details.get("default") for each in entities(facts, "parameters")}
    assert declared == {"rate": 4.0, "topic": "wheels", "needed": None, "arm.joint": "elbow"}
    (tmp_path / "robot.launch.py").write_text("""
from launch import LaunchDescription
from launch_ros.actions import Node
def generate_launch_description():
    return LaunchDescription([Node(package="robots", executable="robot",
        parameters=[{"topic": "tracks", "rate": 2.0, "needed": "eye", "arm.joint": "wrist"}])])
""")
    launched = read_source(tmp_path, launch=Launch("robot.launch.py"))
    assert [each.name for each in entities(launched)] == ["tracks", "wrist/angle", "eye", "tracks/late"]
    assert [each.details["period"] for each in entities(launched, "timers")] == [0.5]


@pytest.mark.parametrize(
    ("call", "name"),
    [
        ('utils::format("%s/odom%d", side.c_str(), 2)', "left/odom2"),
        ('fmt::format("{}/odom", side)', "left/odom"),
        ('uFormat("%s/odom%d", side.c_str(), 2)', "left/odom2"),
        ('utils::format("%s/%s", side.c_str(), unknown)', "left/{unknown}"),
        ('utils::format("odom%02d", 2)', "odom02"),
        ('utils::format("odom%2d", 2)', "odom{%2d}"),
        ('utils::format("%s/%s", side.c_str())', "open"),
        ('std::string("a/") + (side.empty() ? "none" : side)', "a/left"),
    ],
)
def test_texts_of_formats_are_known(tmp_path: Path, call: str, name: str) -> None:
    """A format with a width that needs blanks, or with too few arguments, stays open."""
    code = f'std::string side = "left"; pub_ = create_publisher<std_msgs::msg::Bool>({call}, 1);'
    (found,) = entities(read(tmp_path, code))
    assert found.name.startswith(name)


def test_names_of_namespaces_and_adapted_types_are_followed(tmp_path: Path) -> None:
    """Of classes of the folder and of messages; an adapted type sends the message that it names."""
    before = """
namespace messages = std_msgs::msg;
namespace far::away {
class Helper {
 public:
  explicit Helper(rclcpp::Node * node) { pub_ = node->create_publisher<messages::Bool>("helper", 1); }
  rclcpp::Publisher<messages::Bool>::SharedPtr pub_;
};
}
namespace near_by = far::away;
using Adapted = rclcpp::TypeAdapter<Picture, sensor_msgs::msg::Image>;
"""
    code = """
    helper_ = std::make_shared<near_by::Helper>(this);
    image_ = create_publisher<Adapted>("image", 1);
    text_ = create_publisher<rclcpp::adapt_type<std::string>::as<std_msgs::msg::String>>("text", 1);
"""
    found = entities(read(tmp_path, code, before))
    assert {each.name: each.type for each in found} == {
        "helper": "std_msgs/msg/Bool",
        "image": "sensor_msgs/msg/Image",
        "text": "std_msgs/msg/String",
    }


def test_a_base_class_that_a_directive_decides_is_the_one_without_the_macro(tmp_path: Path) -> None:
    """A line names what is assumed."""
    (tmp_path / "robot.cpp").write_text("""
#ifdef USE_LIFECYCLE
using Base = rclcpp_lifecycle::LifecycleNode;
#else
using Base = rclcpp::Node;
#endif
class Robot : public Base {
 public:
  Robot() : Base("robot") { pub_ = create_publisher<std_msgs::msg::Bool>("on", 1); }
};
int main() { rclcpp::spin(std::make_shared<Robot>()); }
""")
    facts = read_source(tmp_path)
    assert [(node.name, node.managed, len(node.entities)) for node in facts.nodes] == [("robot", False, 1)]
    assert facts.unread == [
        "robot.cpp:5: Base has several meanings under conditions of the preprocessor; rclcpp::Node is assumed"
    ]


def test_equal_names_of_types_in_one_header_are_not_branches(tmp_path: Path) -> None:
    """A header guard is around both classes; each has its own alias."""
    before = """
#ifndef ROBOT_
#define ROBOT_
struct Left { using Message = std_msgs::msg::Bool; };
struct Right { using Message = std_msgs::msg::String; };
#endif
"""
    code = """
    left_ = create_publisher<Left::Message>("left", 1);
    right_ = create_publisher<Right::Message>("right", 1);
"""
    found = entities(read(tmp_path, code, before))
    assert {each.name: each.type for each in found} == {
        "left": "std_msgs/msg/Bool",
        "right": "std_msgs/msg/String",
    }


def test_a_parameter_without_a_value_gives_the_alternative(tmp_path: Path) -> None:
    """``get_parameter_or`` of a parameter whose type alone is declared."""
    code = """
    declare_parameter("rate", rclcpp::PARAMETER_INTEGER);
    int rate = 4;
    get_parameter_or("rate", rate, rate);
    timer_ = create_wall_timer(std::chrono::milliseconds(1000 / rate), []() {});
"""
    assert [each.details["period"] for each in entities(read(tmp_path, code), "timers")] == [0.25]
    needed = code.replace(
        'declare_parameter("rate", rclcpp::PARAMETER_INTEGER)', 'declare_parameter<int>("rate")'
    )
    (timer,) = entities(read(tmp_path, needed), "timers")  # without a value, the program ends there
    assert timer.details["period"] == "open: 1000 / parameter rate"


MEMBERS = """
  void again() {
    if (timer_) { timer_->cancel(); }
    timer_ = create_wall_timer(std::chrono::seconds(1), [this]() {});
    list_.push_back(create_wall_timer(std::chrono::seconds(2), [this]() {}));
  }
  rclcpp::TimerBase::SharedPtr timer_;
  std::vector<rclcpp::TimerBase::SharedPtr> list_;
"""


def test_a_pointer_that_is_set_again_holds_one_port(tmp_path: Path) -> None:
    """Those in a list stay; objects of one class have one each."""
    code = """
    again();
    again();
    one_ = std::make_shared<Helper>(this);
    two_ = std::make_shared<Helper>(this);
"""
    before = """
class Helper {
 public:
  explicit Helper(rclcpp::Node * node) {
    clock_ = node->create_wall_timer(std::chrono::seconds(3), [this]() {});
  }
  rclcpp::TimerBase::SharedPtr clock_;
};
"""
    found = entities(read(tmp_path, code, before, MEMBERS), "timers")
    assert sorted(each.details["period"] for each in found) == [1.0, 2.0, 2.0, 3.0, 3.0]


def test_a_namespace_that_is_not_known_is_named(tmp_path: Path) -> None:
    """The model assumes none."""
    (tmp_path / "robot.cpp").write_text("""
int main(int argc, char ** argv) {
  auto node = std::make_shared<rclcpp::Node>("robot", argv[1]);
  auto pub = node->create_publisher<std_msgs::msg::Bool>("on", 1);
  rclcpp::spin(node);
}
""")
    facts = read_source(tmp_path)
    assert [(node.name, node.namespace) for node in facts.nodes] == [("robot", "")]
    assert facts.unread == ["robot.cpp:3: the namespace of this node is not known; none is assumed"]


def test_options_are_not_a_namespace(tmp_path: Path) -> None:
    """Neither changed ones nor those that a function makes."""
    (tmp_path / "robot.cpp").write_text("""
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot", rclcpp::NodeOptions().use_intra_process_comms(true)) {}
};
int main() { rclcpp::spin(std::make_shared<Robot>()); }
""")
    facts = read_source(tmp_path)
    assert ([node.name for node in facts.nodes], facts.unread) == (["robot"], [])


@pytest.mark.parametrize(
    "loop",
    [
        "for (auto & part : parts_) { part.second->start(); }",
        "for (auto & [name, part] : parts_) { part->start(); }",
        'auto found = parts_.find("a"); found->second->start();',
    ],
)
@pytest.mark.parametrize(
    "insert",
    ["parts_.insert({name, part});", "parts_[name] = part;", "parts_.emplace(std::make_pair(name, part));"],
)
def test_values_of_maps_are_followed(tmp_path: Path, loop: str, insert: str) -> None:
    """As pairs, as parts of a structured binding, and through an iterator."""
    before = """
class Part {
 public:
  explicit Part(rclcpp::Node * node) : node_(node) {}
  void start() { pub_ = node_->create_publisher<std_msgs::msg::Bool>("part", 1); }
  rclcpp::Node * node_;
  rclcpp::Publisher<std_msgs::msg::Bool>::SharedPtr pub_;
};
"""
    code = f'std::string name = "a"; auto part = std::make_shared<Part>(this); {insert} {loop}'
    members = "std::map<std::string, std::shared_ptr<Part>> parts_;"
    assert [each.name for each in entities(read(tmp_path, code, before, members))] == ["part"]


HANDED = """
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    pub_ = create_publisher<std_msgs::msg::Bool>("bytes", 1);
    START
  }
  void heard(int size) { if (size > 0) { pub_->publish(std_msgs::msg::Bool()); } }
  void nothing(int size) { size_ = size; }
  rclcpp::Publisher<std_msgs::msg::Bool>::SharedPtr pub_;
  vendor::Socket socket_;
  int size_;
};
int main() { rclcpp::spin(std::make_shared<Robot>()); }
"""


@pytest.mark.parametrize(
    ("start", "effects"),
    [
        ("socket_.receive(std::bind(&Robot::heard, this, std::placeholders::_1));", ["publish"]),
        ("socket_.receive([this](int size) { heard(size); });", ["publish"]),
        ("vendor::listen([this](int) { pub_->publish(std_msgs::msg::Bool()); });", ["publish"]),
        ("socket_.receive(std::bind(&Robot::nothing, this, std::placeholders::_1));", []),
    ],
)
def test_callables_that_unknown_code_receives_are_read(
    tmp_path: Path, start: str, effects: list[str]
) -> None:
    """They run as callbacks of events, without a port; one that does nothing with ROS is left out."""
    (tmp_path / "robot.cpp").write_text(HANDED.replace("START", start))
    (node,) = read_source(tmp_path).nodes
    found = [one.do for each in node.callbacks if each.kind == "event" for one in each.effects]
    assert found == effects


ENUMERATIONS = """
enum Depth { SMALL = 5, LARGE = SMALL, LARGER };
enum class Side : int { LEFT, RIGHT = 0x10, NEXT };
typedef enum { TICK = 50 } Period;
"""
ENUMERATED = """
    a_ = create_publisher<std_msgs::msg::Bool>("a", SMALL);
    b_ = create_publisher<std_msgs::msg::Bool>("b", rclcpp::QoS(Depth::LARGER));
    c_ = create_publisher<std_msgs::msg::Bool>("c" + std::to_string(static_cast<int>(Side::NEXT)), QUEUE);
    timer_ = create_wall_timer(std::chrono::milliseconds(TICK), [this]() {});
"""


def test_enumerators_are_numbers(tmp_path: Path) -> None:
    found = read(tmp_path, ENUMERATED, ENUMERATIONS, "enum { FIRST, QUEUE };")
    published = [(each.name, each.details["depth"]) for each in entities(found)]
    assert published == [("a", 5), ("b", 6), ("c17", 1)]
    assert entities(found, "timers")[0].details["period"] == 0.05


@pytest.mark.parametrize(
    ("before", "members"),
    [
        ("#ifdef WIDE\nenum { DEEP = 3 };\n#else\nenum { DEEP = 4 };\n#endif", ""),
        ("enum { DEEP = WIDTH + 1 };", ""),
        ("enum { DEEP = 3 };", "int DEEP = vendor::depth();"),
    ],
)
def test_enumerators_that_are_not_known(tmp_path: Path, before: str, members: str) -> None:
    found = read(tmp_path, 'a_ = create_publisher<std_msgs::msg::Bool>("a", DEEP);', before, members)
    assert str(entities(found)[0].details["depth"]).startswith("open")
