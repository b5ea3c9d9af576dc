"""Generated launch files without ROS's `launch` and `launch_ros`: what they describe, and what that starts.

Both packages are in no package index, so stand-ins keep what a launch file makes of them. `commands` turns
that into command lines as `launch_ros` does, with what it would pass on; executables run from their sources.
"""

from __future__ import annotations

import sys
import types
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest


class Kept:
    """Stands in for what a launch file makes: keeps what it is given."""

    def __init__(self, *arguments: Any, **named: Any) -> None:
        self.arguments, self.named = arguments, named

    def perform(self, given: Mapping[str, str]) -> str:
        """Return what a launch argument is given, as a `LaunchConfiguration` does."""
        return given.get(self.arguments[0], "")


LAUNCH = {
    "launch": ["LaunchContext", "LaunchDescription"],
    "launch.actions": [
        "DeclareLaunchArgument",
        "EmitEvent",
        "ExecuteProcess",
        "LogInfo",
        "OpaqueFunction",
        "RegisterEventHandler",
    ],
    "launch.event_handlers": ["OnProcessExit"],
    "launch.events": [],
    "launch.events.process": ["ProcessExited", "ShutdownProcess"],
    "launch.substitutions": [
        "AndSubstitution",
        "LaunchConfiguration",
        "NotEqualsSubstitution",
        "PathJoinSubstitution",
    ],
    "launch_ros": [],
    "launch_ros.actions": ["Node", "LifecycleNode"],
    "launch_ros.event_handlers": ["OnStateTransition"],
    "launch_ros.events": [],
    "launch_ros.events.lifecycle": ["ChangeState"],
    "launch_ros.substitutions": ["FindPackageShare"],
    "lifecycle_msgs": [],
    "lifecycle_msgs.msg": [],
}


def described(path: Path, given: Mapping[str, str] | None = None) -> list[Kept]:
    """Return what a launch file describes, with some arguments of the launch."""
    with pytest.MonkeyPatch.context() as patch:
        for name, classes in LAUNCH.items():
            module = types.ModuleType(name)
            for each in classes:
                setattr(module, each, type(each, (Kept,), {}))
            patch.setitem(sys.modules, name, module)
        sys.modules["launch.events"].matches_action = lambda node: node  # type: ignore[attr-defined]
        changes = types.SimpleNamespace(TRANSITION_CONFIGURE=1, TRANSITION_ACTIVATE=3)
        sys.modules["lifecycle_msgs.msg"].Transition = changes  # type: ignore[attr-defined]
        names: dict[str, Any] = {}
        exec(compile(path.read_text(encoding="utf-8"), str(path), "exec"), names)
        (actions,) = names["generate_launch_description"]().arguments
        (later,) = of_kind(actions, "OpaqueFunction")
        return [*actions, *later.named["function"](given or {})]


def of_kind(actions: Sequence[Kept], kind: str) -> list[Kept]:
    """Return the actions of a class."""
    return [action for action in actions if type(action).__name__ == kind]


def commands(path: Path, workspace: Path, given: Mapping[str, str]) -> dict[str, list[str]]:
    """Return the command line of each process, by its name; `given` are the arguments of the launch."""
    actions = described(path, given)
    found = {action.named["name"]: list(action.named["cmd"]) for action in of_kind(actions, "ExecuteProcess")}
    for action in of_kind(actions, "Node"):
        named = action.named
        command = [sys.executable, "-P", "-m", named["package"], "--ros-args"]
        command += ["-r", f"__node:={named['name']}"]
        command += ["-r", f"__ns:={named['namespace']}"] if named["namespace"] else []
        for parameters in named["parameters"]:
            if isinstance(parameters, dict):
                for name, value in parameters.items():
                    command += ["-p", f"{name}:={text(value, workspace, given)}"]
            else:
                command += ["--params-file", text(parameters, workspace, given)]
        found[named["name"]] = command
    return found


def text(value: object, workspace: Path, given: Mapping[str, str]) -> str:
    """Return what a substitution stands for."""
    if not isinstance(value, Kept):
        return str(value)
    kind, arguments = type(value).__name__, value.arguments
    if kind == "LaunchConfiguration":
        return value.perform(given)
    if kind == "FindPackageShare":
        return str(workspace / "src" / arguments[0])
    assert kind == "PathJoinSubstitution", kind
    return "/".join(text(part, workspace, given) for part in arguments[0])
