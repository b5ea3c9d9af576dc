"""Programs that cannot use ROS are not followed; others are, however they come to it."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.sources.language.machine import Machine
from dineros.sources.reading import read_source
from tests.sources.support import HEAD, written

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


def test_programs_without_ros_are_not_followed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They take most of the time in folders with windows and calculations."""
    steps: list[int] = []
    monkeypatch.setattr(Machine, "step", lambda self: steps.append(1))
    main = "import numpy\ndef main():\n    print(numpy.ones(3))\nif __name__ == '__main__': main()\n"
    assert not read_source(written(tmp_path, start=main)).nodes
    assert not steps
