"""Scopes of launch files: what groups, includes and conditions set, and for which nodes it holds."""

from __future__ import annotations

from pathlib import Path
from textwrap import dedent, indent
from typing import Any

import pytest

from dineros.sources.launch.parameters import parameters_for
from dineros.sources.reading import Launch, read_source
from dineros.sources.resolving import full_name_of

PACKAGE = '<package format="3"><name>arm</name><version>0.0.0</version></package>'
IMPORTS = """
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction, IncludeLaunchDescription
from launch.actions import SetLaunchConfiguration, TimerAction
from launch.conditions import IfCondition, LaunchConfigurationEquals, UnlessCondition
from launch.substitutions import EnvironmentVariable, LaunchConfiguration, PythonExpression
from launch_ros.actions import ComposableNodeContainer, LoadComposableNodes, Node
from launch_ros.actions import PushRosNamespace, SetParameter, SetRemap
from launch_ros.descriptions import ComposableNode

def generate_launch_description():
    return LaunchDescription([
"""


def launched(folder: Path, actions: str, **others: str) -> list[dict[str, Any]]:
    """Return the entries of a launch file in Python with some actions."""
    (folder / "package.xml").write_text(PACKAGE)
    (folder / "robot.launch.py").write_text(f"{IMPORTS}{indent(dedent(actions), ' ' * 8)}\n    ])\n")
    for name, text in others.items():
        (folder / name.replace("__", ".")).write_text(dedent(text))
    facts = read_source(folder)
    assert facts.unread == []
    (found,) = [each for each in facts.launch if each["file"] == "robot.launch.py"]
    return found["nodes"]  # type: ignore[no-any-return]


def names(entries: list[dict[str, Any]]) -> list[str]:
    return [each["name"] for each in entries if "name" in each]


LATER = 'Node(package="p", executable="q", name="n")'
SCOPES = {
    'PushRosNamespace("a", condition=IfCondition("true")),': "/a/n",
    'PushRosNamespace("a", condition=IfCondition("false")),': "/n",
    'PushRosNamespace("a", condition=UnlessCondition("false")), PushRosNamespace("b"),': "/a/b/n",
    'GroupAction([PushRosNamespace("a")]),': "/n",
    'GroupAction([PushRosNamespace("a")], scoped=False),': "/a/n",
    'PushRosNamespace("a"), GroupAction([PushRosNamespace("/b")], scoped=False),': "/b/n",
    'TimerAction(period=1.0, actions=[PushRosNamespace("a")]),': "/n",
    'DeclareLaunchArgument("x", default_value="a"), PushRosNamespace(LaunchConfiguration("x")),': "/a/n",
    'SetLaunchConfiguration("x", "a", condition=IfCondition("1")), '
    'PushRosNamespace(LaunchConfiguration("x")),': "/a/n",
    'SetLaunchConfiguration("x", "a"), PushRosNamespace("b", '
    'condition=LaunchConfigurationEquals("x", "a")),': "/b/n",
    'PushRosNamespace("a", condition=IfCondition(PythonExpression(["3", " > ", "2"]))),': "/a/n",
    "PushRosNamespace(\"a\", condition=IfCondition(PythonExpression([\"'Yes'.lower() != 'yes'\"]))),": "/n",
    "PushRosNamespace(\"a\", condition=IfCondition(PythonExpression([\"'x' not in 'abc'\"]))),": "/a/n",
}


@pytest.mark.parametrize(("actions", "expected"), SCOPES.items())
def test_what_an_action_sets_holds_in_its_scope(tmp_path: Path, actions: str, expected: str) -> None:
    assert names(launched(tmp_path, f"{actions}\n{LATER},")) == [expected]


@pytest.mark.parametrize("scoped", [True, False])
def test_a_group_may_begin_without_the_configurations_around_it(tmp_path: Path, scoped: bool) -> None:
    group = f'GroupAction([{LATER}], scoped={scoped}, forwarding=False, launch_configurations={{"x": "1"}})'
    (name,) = names(launched(tmp_path, f'PushRosNamespace("a"), {group},'))
    assert name == ("/n" if scoped else "/a/n")


def test_a_namespace_under_an_unknown_condition_is_open(tmp_path: Path) -> None:
    actions = f'PushRosNamespace("a", condition=IfCondition(EnvironmentVariable("REAL"))), {LATER},'
    (name,) = names(launched(tmp_path, actions))
    assert "{" in name


INNER = """
    <launch>
      <arg name="side" default="none"/>
      <push_ros_namespace namespace="$(var side)"/>
      <node pkg="p" exec="q.py" name="n"/>
    </launch>
    """
INCLUDE = 'IncludeLaunchDescription("inner.launch.xml"{})'


def included(folder: Path, actions: str) -> list[str]:
    """Return the names of the nodes that a launch file starts with the files that it includes."""
    program = "import rclpy\nfrom rclpy.node import Node\nrclpy.init()\nrclpy.spin(Node('code'))\n"
    (folder / "q.py").write_text(program)
    launched(folder, actions, inner__launch__xml=INNER)
    (folder / "package.xml").write_text(PACKAGE.replace(">arm<", ">p<"))
    facts = read_source(folder, launch=Launch("robot.launch.py"))
    return [f"{node.namespace}/{node.name}" for node in facts.nodes]


def test_an_included_file_has_no_scope_of_its_own(tmp_path: Path) -> None:
    side = INCLUDE.format(', launch_arguments={"side": "left"}.items()')
    later = 'Node(package="p", executable="q.py", name="n")'
    assert included(tmp_path, f"{side}, {later},") == ["/left/n", "/left/n"]
    assert included(tmp_path, f"GroupAction([{side}]), {later},") == ["/left/n", "/n"]
    # The argument of the first include is still set when the second one declares it.
    assert included(tmp_path, f"{side}, PushRosNamespace('/'), {INCLUDE.format('')},") == ["/left/n"] * 2


def test_the_first_rule_of_several_for_a_name_holds(tmp_path: Path) -> None:
    node = 'Node(package="p", executable="q", remappings=[("a", "own"), ("b", "own")])'
    (entry,) = launched(tmp_path, f'SetRemap("a", "all"), {node},')
    assert entry["remappings"] == {"a": "all", "b": "own"}


def test_arguments_of_ros_are_names_and_parameters(tmp_path: Path) -> None:
    arguments = (
        '["-r", "__ns:=/b", "--ros-args", "-p", "rate:=3", "--remap", "a:=c", "--params-file", "x.yaml"]'
    )
    (entry,) = launched(tmp_path, f'Node(package="p", executable="q", name="n", ros_arguments={arguments}),')
    assert (entry["name"], entry["remappings"]) == ("/b/n", {"a": "c"})
    assert entry["parameters"] == [{"rate": 3}, "x.yaml"]


@pytest.mark.parametrize(
    ("key", "name", "fits"),
    [
        *(("/*", "/arm", True), ("/*", "/left/arm", False), ("/*/arm", "/left/arm", True)),
        *(("/*/arm", "/a/left/arm", False), ("/**/arm", "/arm", True), ("/**/arm", "/a/b/arm", True)),
        *(("/left/**", "/left/a/b", True), ("/left/**", "/leftmost", False), ("/a.m", "/arm", False)),
    ],
)
def test_wildcards_in_files_of_parameters(key: str, name: str, fits: bool) -> None:
    assert bool(parameters_for(f"{key}:\n  ros__parameters: {{rate: 3}}", name)) is fits


XML = """
<launch>
  <let name="x" value="a"/>
  <group scoped="false"><push_ros_namespace namespace="g"/></group>
  <timer period="2.0"><node pkg="p" exec="q" name="late"/></timer>
  <node pkg="p" exec="q" name="same" if="$(equals $(var x) a)"/>
  <node pkg="p" exec="q" name="other" if="$(not-equals '$(var x)' 'a')"/>
  <node pkg="p" exec="q" name="both" if="$(and true $(or false true))"/>
</launch>
"""
YAML = """
launch:
- let: {name: x, value: a}
- group: {scoped: false, actions: [{push_ros_namespace: {namespace: g}}]}
- timer:
    period: 2.0
    children:
    - node: {pkg: p, exec: q, name: late}
- node: {pkg: p, exec: q, name: same, if: "$(equals $(var x) a)"}
- node: {pkg: p, exec: q, name: other, if: "$(not-equals $(var x) a)"}
- node: {pkg: p, exec: q, name: both, if: "$(and true $(or false true))"}
"""


@pytest.mark.parametrize(("name", "text"), [("r.launch.xml", XML), ("r.launch.yaml", YAML)])
def test_scopes_and_conditions_in_xml_and_yaml(tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text(text)
    facts = read_source(tmp_path)
    (found,) = facts.launch
    assert names(found["nodes"]) == ["/g/late", "/g/same", "/g/other", "/g/both"]
    assert [each.get("enabled", True) for each in found["nodes"]] == [True, True, False, True]


CONTAINER = (
    'ComposableNodeContainer(name="box", namespace="{0}", package="rclcpp_components", '
    'executable="component_container{1}", composable_node_descriptions=[ComposableNode(package="c", '
    'plugin="c::Part", name="part", namespace="{0}")]),'
)


def table(folder: Path) -> Path:
    """Return a table of libraries with two components."""
    made = 'makes = [{kind = "publishers", name = "scan", type = "sensor_msgs/msg/LaserScan"}]'
    idioms = (f'[[idiom]]\npath = "{path}"\nnode = "part"\n{made}\n' for path in ("c::Part", "c::C"))
    (folder / "table.toml").write_text("\n".join(idioms))
    return folder / "table.toml"


def test_containers_of_one_name_in_two_namespaces_are_two(tmp_path: Path) -> None:
    launched(tmp_path, CONTAINER.format("left", "") + CONTAINER.format("right", "_mt"))
    facts = read_source(tmp_path, [table(tmp_path)], launch=Launch("robot.launch.py"))
    assert [(each.namespace, each.threads) for each in facts.nodes] == [
        ("/left", 1),
        ("/right", "processors"),
    ]
    assert len({(each.program, each.pool) for each in facts.nodes}) == 2


LOAD = (
    'LoadComposableNodes(target_container="{0}", composable_node_descriptions=[ComposableNode('
    'package="c", plugin="c::C", name="part")]),'
)


@pytest.mark.parametrize(
    ("target", "threads"), [("/left/box", 1), ("/right/box", "processors"), ("box", "open"), ("none", "open")]
)
def test_a_component_is_loaded_into_the_container_of_that_name(
    tmp_path: Path, target: str, threads: int | str
) -> None:
    launched(tmp_path, CONTAINER.format("left", "") + CONTAINER.format("right", "_mt") + LOAD.format(target))
    facts = read_source(tmp_path, [table(tmp_path)], launch=Launch("robot.launch.py"))
    (node,) = [each for each in facts.nodes if each.plugin == "c::C" or each.cls == "c::C"]
    assert node.threads == threads


OWN_NAMES = """
import rclpy
from rclpy.node import Node
from std_msgs.msg import String

class Code(Node):
    def __init__(self):
        super().__init__("code")
        self.create_publisher(String, f"{self.get_namespace()}/a", 1)
        self.create_publisher(String, "/" + self.get_name() + "/b", 1)
        self.create_publisher(String, self.get_fully_qualified_name() + "/c", 1)

rclpy.init()
rclpy.spin(Code())
"""
OWN_NAMES_IN_CPP = """
#include <rclcpp/rclcpp.hpp>
#include <std_msgs/msg/string.hpp>
class Code : public rclcpp::Node {
 public:
  Code() : Node("code") {
    a_ = create_publisher<std_msgs::msg::String>(std::string(get_namespace()) + "/a", 1);
    b_ = create_publisher<std_msgs::msg::String>("/" + std::string(get_name()) + "/b", 1);
    c_ = create_publisher<std_msgs::msg::String>(std::string(get_fully_qualified_name()) + "/c", 1);
  }
  rclcpp::Publisher<std_msgs::msg::String>::SharedPtr a_, b_, c_;
};
int main() { rclcpp::init(0, nullptr); rclcpp::spin(std::make_shared<Code>()); }
"""


@pytest.mark.parametrize("file", ["q.py", "q.cpp"])
def test_a_node_learns_its_own_name_from_the_launch_file(tmp_path: Path, file: str) -> None:
    if file == "q.cpp":
        pytest.importorskip("tree_sitter_cpp")
    (tmp_path / file).write_text(OWN_NAMES if file == "q.py" else OWN_NAMES_IN_CPP)
    program = "q.py" if file == "q.py" else "q"
    nodes = [
        f'Node(package="arm", executable="{program}", name="{each}", namespace="{space}"),'
        for each, space in (("one", "left"), ("two", "right"))
    ]
    launched(tmp_path, "\n".join(nodes))
    facts = read_source(tmp_path, launch=Launch("robot.launch.py"))
    found = [full_name_of(each, node) for node in facts.nodes for each in node.of("publishers")]
    assert found == ["/left/a", "/one/b", "/left/one/c", "/right/a", "/two/b", "/right/two/c"]
