"""Names in C++ that several files define: namespaces, included headers and folders say which one is meant."""

from pathlib import Path

import pytest

from dineros.sources.cpp.tables.headers import Headers
from dineros.sources.reading import read_source

pytest.importorskip("tree_sitter_cpp")

PART = """
#include <{include}>
class Base : public rclcpp::Node {{
 public:
  Base() : Node("{name}") {{ create_publisher<std_msgs::msg::String>("{name}_out", 1); }}
}};
"""
MAIN = """
#include "{header}"
int main() {{ rclcpp::spin(std::make_shared<Base>()); }}
"""


def _written(folder: Path, **files: str) -> Path:
    for name, text in files.items():
        path = folder / name.replace("__", "/")
        path = path.with_suffix(".cpp" if name.endswith("main") else ".hpp")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return folder


def test_a_class_is_that_of_the_header_that_is_included(tmp_path: Path) -> None:
    """It may be in another folder than a class of the same name that is nearer."""
    folder = _written(
        tmp_path,
        far__base=PART.format(include="rclcpp/rclcpp.hpp", name="far"),
        far__all='#include "far/base.hpp"\n',
        near__base=PART.format(include="rclcpp/rclcpp.hpp", name="near"),
        near__main=MAIN.format(header="far/all.hpp"),
    )
    nodes = read_source(folder, cache=tmp_path.parent / "kept").nodes
    assert next(each.name for each in nodes if each.program.endswith("main")) == "far"
    (folder / "far" / "all.hpp").write_text('#include "near/base.hpp"\n', encoding="utf-8")
    nodes = read_source(folder, cache=tmp_path.parent / "kept").nodes
    assert next(each.name for each in nodes if each.program.endswith("main")) == "near"


def test_a_class_for_ros_1_is_not_that_of_a_program_for_ros_2(tmp_path: Path) -> None:
    folder = _written(
        tmp_path,
        old=PART.format(include="ros/ros.h", name="old").replace("rclcpp", "ros"),
        new=PART.format(include="rclcpp/rclcpp.hpp", name="new"),
        main="#ifdef ROS1\n#include <old.hpp>\n#else\n#include <new.hpp>\n#endif\n"
        + MAIN.format(header="new.hpp"),
    )
    assert [each.name for each in read_source(folder).nodes] == ["new"]


def test_files_that_are_equally_near_are_all_meant() -> None:
    headers = Headers()
    for path in ("a/x.hpp", "b/x.hpp", "c/main.cpp"):
        headers.add(path)
    assert headers.nearest("c/main.cpp", ["a/x.hpp", "b/x.hpp"]) == {"a/x.hpp", "b/x.hpp"}
    headers.includes["c/main.cpp"] = ["b/x.hpp"]
    assert headers.included("a/x.hpp") == {"a/x.hpp"}


def test_names_of_a_sub_node_are_in_its_namespace(tmp_path: Path) -> None:
    (tmp_path / "robot.cpp").write_text(
        """
#include <rclcpp/rclcpp.hpp>
int main() {
  auto node = rclcpp::Node::make_shared("robot");
  auto arm = node->create_sub_node("arm");
  arm->create_publisher<std_msgs::msg::String>("joints", 1);
  arm->create_publisher<std_msgs::msg::String>("/joints", 1);
  arm->create_publisher<std_msgs::msg::String>("~/joints", 1);
  arm->create_publisher<std_msgs::msg::String>(unknown(), 1);
  node->create_publisher<std_msgs::msg::String>("joints", 1);
  rclcpp::spin(node);
}
""",
        encoding="utf-8",
    )
    (node,) = read_source(tmp_path).nodes
    assert [each.name for each in node.entities] == [
        "arm/joints",
        "/joints",
        "~/joints",
        "arm/{value}",
        "joints",
    ]
