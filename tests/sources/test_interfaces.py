"""Interfaces of a folder: their fields as those of installed packages, what is missing, what is damaged."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from dineros.metamodel.token_types.installed import installed_interfaces, installed_part
from dineros.sources.folders import open_folder
from dineros.sources.interfaces import Interfaces, read_interfaces
from dineros.sources.packages import packages_of

GRIP = """
# Closes the hand.
uint8 OPEN=0
uint8 SHUT = 1      # as hard as it can
string WHO="a # b"
uint8 wanted 1
string<=20 hand "left"
---
bool success
geometry_msgs/Point[2] ends
Touch[<=4] touches
"""
MOVE = "float64 x 0.5\nfloat64[] path\n---\nbool done\n---\nstd_msgs/Header header\n"


def interfaces(folder: Path, **files: str) -> tuple[Interfaces, list[str]]:
    (folder / "arm_msgs").mkdir(exist_ok=True)
    (folder / "arm_msgs" / "package.xml").write_text("<package><name>arm_msgs</name></package>")
    for name, text in files.items():
        kind, _, end = name.rpartition("_")
        path = folder / "arm_msgs" / end / f"{kind}.{end}"
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    opened = open_folder(folder)
    return read_interfaces(opened, packages_of(opened)), opened.unread


def test_fields_defaults_and_constants(tmp_path: Path) -> None:
    found, unread = interfaces(tmp_path, Grip_srv=GRIP, Touch_msg="int8 where -3", Move_action=MOVE)
    assert unread == []
    assert found.types["arm_msgs/srv/Grip"] == "arm_msgs/srv/Grip.srv"
    wanted, hand = found.fields("arm_msgs/srv/Grip_Request") or ()
    assert (wanted.name, wanted.kind, wanted.ros, wanted.default) == ("wanted", "integer", "uint8", 1)
    assert (hand.kind, hand.ros, hand.default) == ("text", "string<=20", "left")
    assert found.constants("arm_msgs/srv/Grip_Request") == {"OPEN": 0, "SHUT": 1, "WHO": "a # b"}
    success, ends, touches = found.fields("arm_msgs/srv/Grip_Response") or ()
    assert (success.kind, success.default) == ("boolean", False)
    assert (ends.kind, ends.element_kind, ends.length) == ("list", "record", 2)
    assert [each.name for each in ends.fields] == ["x", "y", "z"]
    assert (touches.bound, touches.fields[0].default) == (4, -3)
    feedback = found.fields("arm_msgs/action/Move_Feedback") or ()
    assert [each.ros for each in feedback] == ["std_msgs/msg/Header"]
    assert found.fields("arm_msgs/action/Move") is None


@pytest.mark.parametrize(
    "name",
    [
        *("std_msgs/msg/Header", "std_msgs/msg/ColorRGBA", "geometry_msgs/msg/PoseWithCovarianceStamped"),
        *("sensor_msgs/msg/Imu", "sensor_msgs/msg/JointState", "std_msgs/msg/String"),
    ],
)
def test_a_file_has_the_fields_of_its_type_description(tmp_path: Path, name: str) -> None:
    """The text of an installed message, read here, against what its own generator wrote as JSON."""
    package, kind, message = name.split("/")
    text = (Path(sys.prefix) / "share" / package / kind / f"{message}.msg").read_text()
    found = Interfaces()
    found.define(f"{package}/msg/Copy", ".msg", text, "Copy.msg")
    assert found.fields(f"{package}/msg/Copy") == installed_part(name)


def test_parts_of_installed_services() -> None:
    assert [each.name for each in installed_part("std_srvs/srv/Trigger_Response")] == ["success", "message"]
    assert installed_interfaces("no_such_package") is None
    assert Interfaces().fields("std_srvs/srv/Trigger_Request") == ()
    assert Interfaces().fields("std_srvs/srv/Trigger_Goal") is None


def test_types_that_are_not_there(tmp_path: Path) -> None:
    found, _ = interfaces(tmp_path, Grip_srv=GRIP)
    assert found.doubt("arm_msgs/srv/Grip") is None and found.doubt("std_srvs/srv/Trigger") is None
    assert found.doubt("arm_msgs/srv/Gripp") == (
        "the package arm_msgs has no service Gripp (did you mean 'arm_msgs/srv/Grip'?)"
    )
    assert found.is_missing("arm_msgs/srv/Gripp") and not found.is_missing("arm_msgs/srv/Grip")
    assert found.doubt("far_msgs/msg/Away") == (
        "no file in the folder defines far_msgs/msg/Away, and the package far_msgs is not installed"
    )
    assert not found.is_missing("far_msgs/msg/Away")


@pytest.mark.parametrize(
    "text", ["bool", "bool 3x", "bool a\n---\n", "bool a\n{}", "os.system('x')", "bool[-1] a", "=" * 40]
)
def test_a_damaged_file_is_named_and_its_package_stays_open(tmp_path: Path, text: str) -> None:
    found, unread = interfaces(tmp_path, Odd_msg=text)
    assert len(unread) == 1 and "arm_msgs/msg/Odd.msg: it is not an interface definition" in unread[0]
    assert found.doubt("arm_msgs/msg/Other") is None


def test_hostile_definitions_end_at_once(tmp_path: Path) -> None:
    """Messages in themselves, and twice in each of thirty levels; lists that would fill the memory."""
    levels = {f"L{at}_msg": f"L{at + 1} a\nL{at + 1} b\n" for at in range(30)}
    found, _ = interfaces(
        tmp_path,
        Own_msg="Own again\nOwn twice\n",
        Huge_msg="Big[4000] all\n",
        Big_msg="bool[4000] all\n",
        Vast_msg="int8[999999999] all\n",
        L30_msg="bool a\n",
        **levels,
    )
    for name in ("Own", "Vast", "L0"):
        assert found.fields(f"arm_msgs/msg/{name}") is None
    assert len(found.fields("arm_msgs/msg/Huge") or ()) == 1


def test_idl_files_leave_a_package_open(tmp_path: Path) -> None:
    found, unread = interfaces(tmp_path, Odd_idl="module arm_msgs {};", Grip_srv=GRIP)
    assert found.doubt("arm_msgs/msg/Odd") is None and unread == []


def test_folders_together_know_what_one_defines(tmp_path: Path) -> None:
    found, _ = interfaces(tmp_path, Grip_srv=GRIP)
    both = Interfaces()
    both.add(found)
    both.add(Interfaces())
    assert both.doubt("arm_msgs/srv/Grip") is None and both.is_missing("arm_msgs/srv/Gripp")
