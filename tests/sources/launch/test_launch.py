"""Launch files in Python, XML and YAML: what they start, under which names, with which parameters."""

from __future__ import annotations

import warnings
from pathlib import Path
from textwrap import dedent
from typing import Any

import pytest

from dineros.metamodel.errors import DinerosError
from dineros.sources.launch.parameters import parameters_for
from dineros.sources.launch.yaml_text import UnreadableError, parts_of
from dineros.sources.reading import Launch, read_source

PACKAGE = '<package format="3"><name>arm</name><version>0.0.0</version></package>'


def launched(folder: Path, name: str, text: str, **files: str) -> dict[str, Any]:
    """Return what a launch file of the package ``arm`` starts."""
    (folder / "launch").mkdir(exist_ok=True)
    (folder / "package.xml").write_text(PACKAGE)
    (folder / "launch" / name).write_text(dedent(text))
    for other, content in files.items():
        (folder / other.replace("__", "/").replace("_yaml", ".yaml")).write_text(dedent(content))
    facts = read_source(folder)
    assert facts.unread == []
    (found,) = [each for each in facts.launch if each["file"] == f"launch/{name}"]
    return found


IN_PYTHON = """
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, GroupAction, IncludeLaunchDescription, OpaqueFunction
from launch.conditions import IfCondition, UnlessCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution, PythonExpression
from launch.substitutions import TextSubstitution
from launch_ros.actions import ComposableNodeContainer, Node, PushRosNamespace, SetRemap
from launch_ros.descriptions import ComposableNode
from launch_ros.substitutions import FindPackageShare
from ament_index_python.packages import get_package_share_directory
import os

def late(context, extra):
    if LaunchConfiguration("simulated").perform(context) == "true":
        return [Node(package="sim", executable="sim", name="sim")]
    return [Node(package="real", executable="real", name=extra)]

def generate_launch_description():
    side = LaunchConfiguration("side")
    ld = LaunchDescription([
        DeclareLaunchArgument("side", default_value="left"),
        DeclareLaunchArgument("simulated", default_value="false"),
        Node(package="arm", executable="mover", name=[side, "_mover"], namespace=side,
             remappings=[("joints", [TextSubstitution(text="/"), side, "/joints"])],
             parameters=[os.path.join(get_package_share_directory("arm"), "config", "arm.yaml"),
                         {"rate": 3}]),
        Node(package="arm", executable="watch",
             condition=IfCondition(LaunchConfiguration("simulated"))),
        Node(package="arm", executable="guard", condition=UnlessCondition(
            PythonExpression(["'", side, "' == 'right'"]))),
        GroupAction([PushRosNamespace("inner"), SetRemap("a", "b"),
                     Node(package="p", executable="q", name="n")]),
        OpaqueFunction(function=late, args=["driver"]),
        ComposableNodeContainer(name="box", namespace="", package="rclcpp_components",
            executable="component_container_mt", composable_node_descriptions=[
                ComposableNode(package="c", plugin="c::C", name="part")]),
        IncludeLaunchDescription(
            PathJoinSubstitution([FindPackageShare("arm"), "launch", "other.launch.xml"])),
    ])
    for name in ("one", "two"):
        ld.add_action(Node(package="many", executable="many", name=f"many_{name}"))
    return ld
"""


def test_launch_files_in_python(tmp_path: Path) -> None:
    found = launched(tmp_path, "arm.launch.py", IN_PYTHON)
    assert found["arguments"] == {"side": "left", "simulated": "false"}
    nodes = found["nodes"]
    mover = nodes[0]
    assert mover["name"] == "/left/left_mover" and mover["namespace"] == "/left"
    assert mover["remappings"] == {"joints": "/left/joints"}
    assert mover["parameters"] == ["$(find arm)/config/arm.yaml", {"rate": 3}]
    assert nodes[1]["enabled"] is False and nodes[1]["when"] == "simulated (by default: no)"
    assert "enabled" not in nodes[2] and nodes[2]["when"].endswith("(by default: yes)")
    assert nodes[3]["name"] == "/inner/n" and nodes[3]["remappings"] == {"a": "b"}
    assert [each["name"] for each in nodes if each.get("package") == "real"] == ["/driver"]
    assert [each["name"] for each in nodes if each.get("package") == "sim"] == []
    (part,) = [each for each in nodes if each.get("kind") == "component"]
    assert (part["plugin"], part["container"], part["name"]) == ("c::C", "box", "/part")
    assert [each["include"] for each in nodes if "include" in each] == ["other.launch.xml"]
    assert [each["name"] for each in nodes if each.get("package") == "many"] == ["/many_one", "/many_two"]


IN_XML = """
<launch>
  <!-- a comment -->
  <arg name="side" default="left"/>
  <node pkg="arm" exec="mover" name="$(var side)_mover" namespace="$(var side)">
    <param name="rate" value="3"/>
    <param from="$(find-pkg-share arm)/config/arm.yaml"/>
    <remap from="joints" to="/$(var side)/joints"/>
  </node>
  <node pkg="arm" exec="guard" if="$(eval '\\'$(var side)\\' == \\'right\\'')"/>
  <group>
    <push_ros_namespace namespace="inner"/>
    <node pkg="p" exec="q" name="n" unless="false"/>
  </group>
  <include file="$(find-pkg-share arm)/launch/other.launch.xml"><arg name="x" value="1"/></include>
</launch>
"""
IN_YAML = """
launch:
- arg: {name: side, default: left}
- node:
    pkg: arm
    exec: mover
    name: $(var side)_mover
    namespace: $(var side)
    param:
    - {name: rate, value: 3}
    - {from: $(find-pkg-share arm)/config/arm.yaml}
    remap:
    - {from: joints, to: /$(var side)/joints}
- group:
  - push_ros_namespace: {namespace: inner}
  - node: {pkg: p, exec: q, name: n}
- include: {file: $(find-pkg-share arm)/launch/other.launch.xml}
"""


@pytest.mark.parametrize(("name", "text"), [("a.launch.xml", IN_XML), ("a.launch.yaml", IN_YAML)])
def test_launch_files_in_xml_and_yaml(tmp_path: Path, name: str, text: str) -> None:
    found = launched(tmp_path, name, text)
    assert found["arguments"] == {"side": "left"}
    mover = found["nodes"][0]
    assert (mover["name"], mover["executable"]) == ("/left/left_mover", "mover")
    assert mover["remappings"] == {"joints": "/left/joints"}
    assert mover["parameters"] == [{"rate": 3}, "$(find arm)/config/arm.yaml"]
    assert mover["at"] == f"launch/{name}:{5 if name.endswith('xml') else 4}"
    assert [each["name"] for each in found["nodes"] if each.get("package") == "p"] == ["/inner/n"]
    assert found["nodes"][-1]["include"] == "other.launch.xml"
    guards = [each for each in found["nodes"] if each.get("executable") == "guard"]
    assert all(each["enabled"] is False for each in guards) and len(guards) == name.endswith("xml")


def test_parameters_without_a_default_come_from_launch_files(tmp_path: Path) -> None:
    program = """
    import rclpy
    from rclpy.node import Node
    from std_msgs.msg import String
    class Mover(Node):
        def __init__(self):
            super().__init__("mover")
            self.declare_parameter("topic")
            self.declare_parameter("other", "of_code")
            self.create_publisher(String, self.get_parameter("topic").value, 1)
            self.create_publisher(String, self.get_parameter("other").value, 1)
    def main():
        rclpy.init(); rclpy.spin(Mover())
    """
    (tmp_path / "arm").mkdir()
    (tmp_path / "arm/mover.py").write_text(dedent(program))
    (tmp_path / "setup.py").write_text("setup(entry_points={'console_scripts': ['mover = arm.mover:main']})")
    (tmp_path / "config").mkdir()
    launched(
        tmp_path,
        "a.launch.yaml",
        IN_YAML,
        config__arm_yaml="/**:\n  ros__parameters: {topic: of_file, other: not_by_default}\n",
    )
    (node,) = read_source(tmp_path).nodes
    assert [each.name for each in node.of("publishers")] == ["of_file", "of_code"]


@pytest.mark.parametrize(
    ("key", "name", "fits"),
    [
        ("/**", "/a/b", True),
        ("b", "/b", True),
        ("/a/b", "/a/b", True),
        ("b", "/a/b", False),
        ("/*/b", "/a/b", True),
        ("/a/**", "/a/b", True),
        ("/**/b", "/x/y/b", True),
        ("/a", "/a/b", False),
    ],
)
def test_which_node_an_entry_of_a_file_means(key: str, name: str, fits: bool) -> None:
    text = f'"{key}":\n  ros__parameters: {{x: 1}}\n'
    assert parameters_for(text, name) == ({"x": 1} if fits else {})


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[" * 100 + "]" * 100, "nested deeper"),
        (
            "a: &a ["
            + "1, " * 300
            + "]\n"
            + "".join(f"{c}: &{c} [{('*' + p + ', ') * 20}]\n" for p, c in ("ab", "bc", "cd")),
            "has more than",
        ),
        ("a: [", "is not YAML"),
        ("x" * 300_000, "characters"),
    ],
    ids=("deep", "bomb", "broken", "huge"),
)
def test_hostile_yaml(text: str, expected: str) -> None:
    with pytest.raises(UnreadableError, match=expected):
        parts_of(text)


def test_launch_files_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    (tmp_path / "bad.launch.xml").write_text("<launch>")
    (tmp_path / "bad.launch.yaml").write_text("launch: [")
    (tmp_path / "loop.launch.xml").write_text('<launch><include file="loop.launch.xml"/></launch>')
    facts = read_source(tmp_path)
    assert [line.partition(":")[0] for line in facts.unread] == ["bad.launch.xml", "bad.launch.yaml"]


def test_a_launch_file_is_named_by_the_end_of_its_path(tmp_path: Path) -> None:
    (tmp_path / "launch").mkdir()
    for name in ("launch/robot.launch.xml", "launch/arm.launch.xml"):
        (tmp_path / name).write_text("<launch/>")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "arm.launch.xml").write_text("<launch/>")
    assert read_source(tmp_path, launch=Launch("robot.launch.xml")).nodes == []
    with pytest.raises(DinerosError, match="there is no launch file arm"):
        read_source(tmp_path, launch=Launch("arm.launch.xml"))


def test_a_launch_file_is_named_by_a_path_from_the_current_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("robot/launch/robot.launch.xml", "robot/other/robot.launch.xml", "outside.launch.xml"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("<launch/>")
    monkeypatch.chdir(tmp_path)
    for name in ("robot/launch/robot.launch.xml", str(tmp_path / "robot/other/robot.launch.xml")):
        assert read_source(Path("robot"), launch=Launch(name)).nodes == []
    for name in ("outside.launch.xml", "robot/../outside.launch.xml", "robot/launch", "\0"):
        with pytest.raises(DinerosError, match="there is no launch file"):
            read_source(Path("robot"), launch=Launch(name))


def test_a_name_of_a_value_in_yaml_may_be_given_again() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = parts_of("a: &same 1\nb: *same\nc: &same 2\nd: *same\n")
    assert found.plain() == {"a": 1, "b": 1, "c": 2, "d": 2}
