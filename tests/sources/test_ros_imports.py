"""Programs that cannot use ROS are not followed; others are, also code for two versions of it."""

from __future__ import annotations

import textwrap
from pathlib import Path

import pytest

from dineros.sources.language.machine import Machine
from dineros.sources.language.modules import Modules
from dineros.sources.reading import Launch, read_source
from tests.sources.support import HEAD, node_of, written

_NODE = f"{HEAD}\nclass Robot(Node):\n    def __init__(self):\n        super().__init__('robot')\n"
_MAIN = "\ndef main():\n    rclpy.init()\n    rclpy.spin(Robot())\nif __name__ == '__main__': main()\n"


@pytest.mark.parametrize(
    "imports",
    [
        "from robot import Robot, rclpy",
        "from helper import *",
        "import helper\nRobot, rclpy = helper.Robot, helper.rclpy",
        "from part.inner import Robot, rclpy",
        "from part import inner\nRobot, rclpy = inner.Robot, inner.rclpy",
        "if True:\n    from part.inner import Robot, rclpy",
        "def later():\n    global Robot, rclpy\n    from robot import Robot, rclpy\nlater()",
    ],
)
def test_programs_that_come_to_ros_by_other_modules_are_followed(tmp_path: Path, imports: str) -> None:
    helper = "from robot import Robot, rclpy"
    files = {"robot": _NODE, "helper": helper, "part____init__": "", "part__inner": "from helper import *"}
    names = [each.name for each in read_source(written(tmp_path, start=imports + _MAIN, **files)).nodes]
    assert names == ["robot"]


@pytest.mark.parametrize(
    "imports", ["", "from importlib.util import find_spec", "from importlib.metadata import version"]
)
def test_programs_without_ros_are_not_followed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, imports: str
) -> None:
    """They take most of the time in folders with windows and calculations."""
    steps: list[int] = []
    monkeypatch.setattr(Machine, "step", lambda self: steps.append(1))
    main = (
        imports + "\nimport numpy\ndef main():\n    print(numpy.ones(3))\nif __name__ == '__main__': main()\n"
    )
    assert not read_source(written(tmp_path, start=main)).nodes
    assert not steps


VERSION = """
import os
def ros_version():
    found = int({read})
    if found not in (1, 2):
        raise RuntimeError("not set")
    return found
ROS_VERSION = ros_version()
if ROS_VERSION == 1:
    import rospy
    class Compatible(object):
        def __init__(self, name): pass
        def new_publisher(self, type, name): return rospy.Publisher(name, type)
elif ROS_VERSION == 2:
    import rclpy
    class Compatible(rclpy.node.Node):
        def __init__(self, name): super().__init__(name)
        def new_publisher(self, type, name): return self.create_publisher(type, name, 3)
"""
PROGRAM = """
import rclpy
from std_msgs.msg import String
from version import Compatible
class Robot(Compatible):
    def __init__(self):
        super(Robot, self).__init__("robot")
        self.pub = self.new_publisher(String, "out")
def main():
    rclpy.init()
    rclpy.spin(Robot())
if __name__ == "__main__":
    main()
"""


@pytest.mark.parametrize("read", ['os.environ.get("ROS_VERSION", 0)', 'os.environ["ROS_VERSION"]'])
def test_the_version_of_ros_decides_which_class_a_node_extends(tmp_path: Path, read: str) -> None:
    (tmp_path / "version.py").write_text(VERSION.format(read=read))
    (tmp_path / "program.py").write_text(PROGRAM)
    (node,) = read_source(tmp_path).nodes
    assert (node.name, [(each.kind, each.name) for each in node.entities]) == (
        "robot",
        [("publishers", "out")],
    )


@pytest.mark.parametrize("change", ["def f():\n    global MODE\n    MODE = 2", "MODE = 2"])
def test_a_constant_that_the_module_changes_does_not_decide(tmp_path: Path, change: str) -> None:
    text = f"MODE = 1\n{change}\nif MODE == 1:\n    NAME = 'one'\nelse:\n    NAME = 'two'\n"
    body = (
        '\ndef __init__(self):\n    super().__init__("robot")\n    self.create_publisher(String, NAME, 3)\n'
    )
    node = node_of(tmp_path, body, before=text)
    assert {each["name"] for each in node["publishers"]} == {"one", "two"}


def test_a_parameter_object_is_the_value_if_the_parameter_is_not_set(tmp_path: Path) -> None:
    package = tmp_path / "robot"
    (package / "launch").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>robot</name></package>")
    (package / "setup.py").write_text(
        "from setuptools import setup\nsetup(entry_points={'console_scripts': ['go = robot.program:main']})\n"
    )
    (package / "robot").mkdir()
    (package / "robot" / "program.py").write_text(
        textwrap.dedent("""
        import rclpy
        from rclpy import Parameter
        from std_msgs.msg import String
        class Robot(rclpy.node.Node):
            def __init__(self):
                super().__init__("robot")
                role = self.get_param("role", "hero")
                self.create_publisher(String, f"/car/{role}/out", 3)
            def get_param(self, name, other=None):
                return self.get_parameter_or(name, Parameter(name, value=other)).value
        def main():
            rclpy.init()
            rclpy.spin(Robot())
        """)
    )
    (package / "launch" / "go.launch.xml").write_text(
        '<launch><node pkg="robot" exec="go"><param name="role" value="ego"/></node></launch>'
    )
    (by_default,) = read_source(tmp_path).nodes
    (launched,) = read_source(tmp_path, launch=Launch("go.launch.xml")).nodes
    assert [each.name for each in by_default.of("publishers")] == ["/car/hero/out"]
    assert [each.name for each in launched.of("publishers")] == ["/car/ego/out"]


@pytest.mark.parametrize(("call", "runs"), [("main()", 1), ("sys.exit(main())", 1), ("main('other')", 2)])
def test_a_script_that_is_an_entry_point_is_read_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: str, runs: int
) -> None:
    """Both call one function; it is the one with the parameters of launch files that is read."""
    (tmp_path / "robot").mkdir()
    (tmp_path / "package.xml").write_text("<package><name>robot</name></package>")
    (tmp_path / "CMakeLists.txt").write_text("install(PROGRAMS robot/go.py DESTINATION lib/robot)")
    (tmp_path / "setup.py").write_text("setup(entry_points={'console_scripts': ['go = robot.go:main']})")
    text = PROGRAM.replace("from version import Compatible", "import sys").replace(
        "Compatible", "rclpy.node.Node"
    )
    text = text.replace("self.new_publisher(", "self.create_publisher(").replace('"out")', '"out", 1)')
    text = text.replace("def main()", "def main(name=None)").replace("    main()", f"    {call}")
    (tmp_path / "robot" / "go.py").write_text(text)
    read: list[str] = []
    init = Machine.__init__

    def begin(self: Machine, modules: Modules, program: str) -> None:
        read.append(program)
        init(self, modules, program)

    monkeypatch.setattr(Machine, "__init__", begin)
    (node,) = read_source(tmp_path).nodes
    assert len([each for each in read if each.startswith("robot/go")]) == runs
    assert {node.program, *node.also_in} == {"robot/go", "robot/go.py"}
