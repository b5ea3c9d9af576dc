"""Entities in C++ that are easily missed: in lists, behind aliases, in code that nothing runs."""

from __future__ import annotations

from pathlib import Path
from textwrap import dedent

import pytest

from dineros.sources.facts import Facts
from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

MUX = """
template<typename T>
class Handle_ {
 protected:
  Handle_(std::string topic, Mux * mux) : topic_(topic), mux_(mux) {}
  std::string topic_;
  Mux * mux_;
};
class Handle : public Handle_<std_msgs::msg::Bool> {
  typedef Handle_<std_msgs::msg::Bool> base_type;
 public:
  Handle(std::string topic, Mux * mux) : base_type(topic, mux) {
    sub_ = mux_->create_subscription<std_msgs::msg::Bool>(topic_, 1, [](std_msgs::msg::Bool::SharedPtr) {});
  }
};
class Mux : public rclcpp::Node {
 public:
  using Handles = std::list<Handle>;
  Mux() : Node("mux") {
    handles_ = std::make_shared<Handles>();
    fill(*handles_);
    named_.emplace("third", Handle("c", this));
  }
  template<typename T> void fill(std::list<T> & handles) {
    handles.emplace_back("a", this);
    handles.emplace_front("b", this);
  }
  std::shared_ptr<Handles> handles_;
  std::map<std::string, Handle> named_;
};
int main() { rclcpp::init(); rclcpp::spin(std::make_shared<Mux>()); }
"""


def _read(folder: Path, **files: str) -> Facts:
    for name, text in files.items():
        (folder / f"{name}.cpp").write_text(dedent(text))
    return read_source(folder)


def test_objects_that_a_list_makes_are_followed(tmp_path: Path) -> None:
    """By ``emplace_back`` and the like, also with a base class that an initialiser names by an alias."""
    facts = _read(tmp_path, mux=MUX)
    (node,) = facts.nodes
    assert sorted(each.name for each in node.of("subscriptions")) == ["a", "b", "c"]
    assert facts.unread == []


def test_a_component_may_be_named_by_an_alias(tmp_path: Path) -> None:
    facts = _read(
        tmp_path,
        server="""
        class BaseServer : public rclcpp::Node {
         public:
          explicit BaseServer(const rclcpp::NodeOptions & options) : Node("server", options) {
            pub_ = create_publisher<std_msgs::msg::Bool>("out", 1);
          }
        };
        namespace maps { using Server = ::BaseServer; }
        RCLCPP_COMPONENTS_REGISTER_NODE(maps::Server)
        """,
    )
    assert [each.name for each in facts.nodes] == ["server"]
    assert facts.unread == []


def test_classes_of_one_name_in_two_namespaces_are_two_nodes(tmp_path: Path) -> None:
    talker = """
    namespace {0} {{
    class Talker : public rclcpp::Node {{
     public:
      explicit Talker(const rclcpp::NodeOptions & options) : Node("{0}", options) {{
        pub_ = create_publisher<std_msgs::msg::Bool>("{0}", 1);
      }}
    }};
    }}
    """
    main = "int main() { rclcpp::spin(std::make_shared<one::Talker>(rclcpp::NodeOptions())); }"
    facts = _read(tmp_path, one=talker.format("one") + main, two=talker.format("two"))
    assert sorted(each.name for each in facts.nodes) == ["one", "two"]


def test_calls_in_code_that_nothing_runs_are_named(tmp_path: Path) -> None:
    """Not those in comments, texts and tests, nor functions of such a name."""
    plugin = """
    class Plugin : public webots::Plugin {
      void init(rclcpp::Node * node) {
        pub_ = node->create_publisher<std_msgs::msg::Bool>("out", 1);
        // pub_ = node->create_publisher<std_msgs::msg::Bool>("old", 1);
        log("create_client(this)");
        sub_ =
          node->template create_subscription<std_msgs::msg::Bool>("in", 1, [](auto) {});
        server_ = rclcpp_action::create_server<Fly>(node, "fly");
        http_ = web::create_server(80);
      }
      void create_timer(int) {}
    };
    """
    (tmp_path / "test").mkdir()
    (tmp_path / "test" / "fake.cpp").write_text(dedent(plugin))
    facts = _read(tmp_path, mux=MUX, plugin=plugin)
    assert facts.unread == [
        "plugin.cpp:4: 3 calls of create_publisher, create_subscription, create_server (also lines 8, 9) "
        "in code that no node is known to run; the model lacks them"
    ]


def test_calls_of_libraries_in_code_that_nothing_runs_are_named(tmp_path: Path) -> None:
    plugin = """
    void Plugin::init(rclcpp::Node::SharedPtr node) {
      sub_ = std::make_shared<message_filters::Subscriber<std_msgs::msg::Bool>>(node, "in");
      tf_ = std::make_unique<tf2_ros::TransformListener>(buffer_, node);
      // old_ = std::make_unique<tf2_ros::TransformListener>(buffer_, node);
      cam_ = images_->subscribeCamera("image", 1, on_image);
      list_ = std::make_shared<Listener>();
    }
    """
    facts = _read(tmp_path, mux=MUX, plugin=plugin)
    assert facts.unread == [
        "plugin.cpp:3: 3 calls of Subscriber, TransformListener, subscribeCamera (also lines 4, 6) "
        "in code that no node is known to run; the model lacks them"
    ]


def test_objects_of_libraries_that_a_node_makes_are_not_named(tmp_path: Path) -> None:
    node = """
    class Robot : public rclcpp::Node {
     public:
      Robot() : Node("robot") {
        buffer_ = std::make_unique<tf2_ros::Buffer>(get_clock());
        own_ = std::make_shared<tf2_ros::TransformListener>(*buffer_);
        sub_ = std::make_shared<message_filters::Subscriber<std_msgs::msg::Bool>>(
          this, "in");
      }
    };
    int main() { rclcpp::spin(std::make_shared<Robot>()); }
    """
    assert _read(tmp_path, robot=node).unread == []


def test_programs_whose_nodes_have_one_name_and_other_ports_are_all_in_the_facts(tmp_path: Path) -> None:
    """By a class that adds a port, or by the main function; equal ones are there once."""
    facts = _read(
        tmp_path,
        base="""
        class Base : public rclcpp::Node {
         public:
          Base() : Node("server") { pub_ = create_publisher<std_msgs::msg::Bool>("out", 1); }
        };
        int main() { rclcpp::spin(std::make_shared<Base>()); }
        """,
        more="""
        class More : public Base {
         public:
          More() { sub_ = create_subscription<std_msgs::msg::Bool>("in", 1, [](auto) {}); }
        };
        int main() { rclcpp::spin(std::make_shared<More>()); }
        """,
        timed="""
        int main() {
          auto node = std::make_shared<Base>();
          auto timer = node->create_wall_timer(1s, []() {});
          rclcpp::spin(node);
        }
        """,
        again="int main() { rclcpp::spin(std::make_shared<Base>()); }",
    )
    kinds = sorted(sorted(each.kind for each in node.entities) for node in facts.nodes)
    assert kinds == [["publishers"], ["publishers", "subscriptions"], ["publishers", "timers"]]


def test_image_transport_makes_ports_by_its_methods(tmp_path: Path) -> None:
    facts = _read(
        tmp_path,
        camera="""
        class Camera : public rclcpp::Node {
         public:
          Camera() : Node("camera"), it_(std::shared_ptr<rclcpp::Node>(this, [](auto *) {})) {
            pub_ = it_.advertise("image", 1);
            sub_ = it_.subscribe("in", 2, &Camera::onImage, this);
            auto other = std::make_shared<image_transport::ImageTransport>(shared_from_this());
            cam_ = other->subscribeCamera("left/image", 3, [](const auto &, const auto &) {});
          }
          void onImage(const sensor_msgs::msg::Image::ConstSharedPtr & image) { pub_.publish(image); }
          image_transport::ImageTransport it_;
          image_transport::Publisher pub_;
        };
        int main() { rclcpp::spin(std::make_shared<Camera>()); }
        """,
    )
    (node,) = facts.nodes
    assert facts.unread == []
    assert [(each.kind, each.name, each.details["depth"]) for each in node.entities] == [
        ("publishers", "image", 1),
        ("subscriptions", "in", 2),
        ("subscriptions", "left/image", 3),
        ("subscriptions", "left/camera_info", 3),
    ]
    (callback,) = [each for each in node.callbacks if each.name == "onImage"]
    assert [each.do for each in callback.effects] == ["publish"]
