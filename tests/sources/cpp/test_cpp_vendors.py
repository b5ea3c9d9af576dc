"""Code in C++ that is not in the folder, and gets or is a node: a line names it."""

from pathlib import Path

import pytest

from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

NODE = """
#include <rclcpp/rclcpp.hpp>
class Kept {
 public:
  Kept(const Kept &) = delete;
  rclcpp::Node * node;
};
class Helper {
 public:
  explicit Helper(rclcpp::Node * node);
};
class Other : public vendor::Base {
 public:
  explicit Other(rclcpp::Node * node) : vendor::Base(node) {}
};
class Robot : public rclcpp::Node, public vendor::Mixin {
 public:
  Robot() : Node("robot"), vendor::Mixin(this) {
    BODY
    pub_ = create_publisher<std_msgs::msg::String>("out", 1);
  }
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr pub_;
  std::unique_ptr<vendor::Thing> thing_;
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  rclcpp::spin(std::make_shared<Robot>());
}
"""


def _lines(folder: Path, code: str) -> list[str]:
    (folder / "a.cpp").write_text(code, encoding="utf-8")
    return read_source(folder).unread


@pytest.mark.parametrize(
    ("body", "named"),
    [
        ("", ""),
        ("auto helper = std::make_shared<Helper>(this);", "Helper"),
        ("auto other = std::make_unique<Other>(this);", "vendor::Base"),
        ("thing_.reset(new vendor::Thing(shared_from_this()));", "vendor::Thing"),
        ("auto kept = Kept{this};", ""),
        ("RCLCPP_INFO(get_logger(), vendor::hello());", ""),
    ],
)
def test_what_gets_the_node_is_named(tmp_path: Path, body: str, named: str) -> None:
    lines = _lines(tmp_path, NODE.replace("BODY", body))
    assert all("receives the node, but its code is not in the folder" in line for line in lines)
    wanted = {"vendor::Mixin", named} - {""}
    assert {line.split(": ", 1)[1].split(" receives")[0] for line in lines} == wanted


MAIN = """
#include <rclcpp/rclcpp.hpp>
class Driver : public vendor::DriverNode {
 public:
  Driver() : vendor::DriverNode("driver") {}
};
class Plain : public rclcpp::Node {
 public:
  Plain() : Node("plain") { timer_ = create_wall_timer(std::chrono::seconds(1), []() {}); }
  rclcpp::TimerBase::SharedPtr timer_;
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  auto node = std::make_shared<KIND>();
  SPIN
}
"""
ADDED = """rclcpp::executors::SingleThreadedExecutor all;
  all.add_node(node);
  all.spin();"""


def test_an_item_of_a_container_is_not_named(tmp_path: Path) -> None:
    kept = ADDED.replace("add_node(node)", 'add_node(nodes.at("a"))')
    code = MAIN.replace("SPIN", f"NodeMap nodes = make_nodes();\n  {kept}").replace("KIND", "Plain")
    assert _lines(tmp_path, code) == []


@pytest.mark.parametrize("spin", ["rclcpp::spin(node);", ADDED])
@pytest.mark.parametrize(
    ("kind", "is_known"), [("Plain", True), ("Driver", False), ("vendor::Driver", False)]
)
def test_a_node_of_a_vendor_that_is_spun_is_named(
    tmp_path: Path, kind: str, is_known: bool, spin: str
) -> None:
    lines = _lines(tmp_path, MAIN.replace("KIND", kind).replace("SPIN", spin))
    wanted = f"{kind} is spun as a node, but its code or that of its base class is not in the folder"
    assert len([line for line in lines if wanted in line]) == (not is_known)


@pytest.mark.parametrize(
    ("plugin", "wanted"),
    [
        ("Plain", []),
        ("Driver", ["a.cpp: the component Driver is not a node that can be read"]),
        ("vendor::Driver", ["a.cpp: the component vendor::Driver is not in the folder"]),
    ],
)
def test_a_component_of_a_vendor_is_named(tmp_path: Path, plugin: str, wanted: list[str]) -> None:
    code = MAIN.partition("int main")[0] + f"RCLCPP_COMPONENTS_REGISTER_NODE({plugin})\n"
    lines = _lines(tmp_path, code)
    assert len(lines) == len(wanted)
    assert all(line.startswith(text) or f"/{text}" in line for line, text in zip(lines, wanted, strict=True))


def test_a_pointer_that_is_given_a_helper_holds_it(tmp_path: Path) -> None:
    code = """
#include <rclcpp/rclcpp.hpp>
class Helper {
 public:
  explicit Helper(rclcpp::Node * node) { pub_ = node->create_publisher<std_msgs::msg::String>("out", 1); }
  void beat() { pub_->publish(std_msgs::msg::String()); }
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr pub_;
};
class Robot : public rclcpp::Node {
 public:
  Robot() : Node("robot") {
    helper_.reset(new Helper(this));
    timer_ = create_wall_timer(std::chrono::seconds(1), [this]() { helper_->beat(); });
  }
  std::unique_ptr<Helper> helper_;
  rclcpp::TimerBase::SharedPtr timer_;
};
"""
    (tmp_path / "a.cpp").write_text(code, encoding="utf-8")
    facts = read_source(tmp_path)
    (node,) = facts.nodes
    assert facts.unread == []
    timer = next(each for each in node.callbacks if each.kind == "timer")
    assert [each.entity.name for each in timer.effects if each.entity is not None] == ["out"]


ADAPTED = """
class Bridge : public rclcpp::Node {
 public:
  Bridge() : Node("bridge") {
    const auto adaptor = component_interface_utils::NodeAdaptor(this);
    group_ = create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive);
    adaptor.init_cli(cli_route_, group_);
    adaptor.init_sub(sub_route_, this, &Bridge::on_route);
    pub_ = create_publisher<std_msgs::msg::String>("route", 1);
  }
  void on_route(const Route::ConstSharedPtr msg) { cli_route_->call(request_); pub_->publish(*msg); }
  component_interface_utils::Client<Route>::SharedPtr cli_route_;
  component_interface_utils::Subscription<Route>::SharedPtr sub_route_;
};
"""


def test_ports_of_an_adaptor_have_open_names(tmp_path: Path) -> None:
    (tmp_path / "bridge.cpp").write_text(ADAPTED)
    (node,) = read_source(tmp_path).nodes
    (client,), (sub,) = node.of("clients"), node.of("subscriptions")
    assert client.name.startswith("open") and client.details["group"] == "group_"
    assert sub.callbacks["callback"].name == "on_route"
    assert [each.do for each in sub.callbacks["callback"].effects] == ["call", "publish"]
