"""What the arm does: it moves on command, and brakes when a goal is to be canceled."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from dineros.metamodel.errors import DinerosError
from dineros.runtime import Candidates, Enabled, Net

from . import firings

COMMANDS = "/cell/arm"
POLL = 0.01  # seconds between two looks at a signal
AGAIN = 1.0  # seconds after which a command that shows no effect is sent again: the drive may have been down


@dataclass
class Arm:
    """Where the drive takes commands, a motion and a piece, and the node's net."""

    command: Callable[[str, str], None]
    net: Net | None = None


ARM = Arm(lambda motion, piece: None)  # nowhere yet


def configure(net: Net) -> None:
    """Connect the drive; who is asked to stop does that before anything else."""
    ARM.net = net
    net.selection(choose)
    with suppress(DinerosError):  # without ROS, whoever runs the node says so by `use`
        use(_drive(net))


def use(command: Callable[[str, str], None]) -> None:
    """Send commands there."""
    ARM.command = command


def choose(candidates: Candidates) -> Enabled | None:
    """Brake first."""
    urgent = (each for each in candidates if each.transition.startswith(("Brake", "Drop")))
    return next(urgent, None) or candidates.random()


def _drive(net: Net) -> Callable[[str, str], None]:
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from std_msgs.msg import String  # type: ignore[import-untyped]

    # Kept for a drive that is started again; only the last command counts.
    latched: Any = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)  # type: ignore[no-untyped-call]
    publisher = net.ros_node.create_publisher(String, COMMANDS, latched)

    def send(motion: str, piece: str) -> None:
        publisher.publish(String(data=json.dumps({"motion": motion, "piece": piece})))

    return send


async def _move(motion: str, piece: str) -> None:
    """Start a motion; return when the signals refer to it and to no earlier one."""
    assert ARM.net is not None
    while True:
        ARM.command(motion, piece)
        for _ in range(round(AGAIN / POLL)):
            if not ARM.net.signal("AtRest").value:
                return
            await asyncio.sleep(POLL)


@firings.on("MovePick", timeout=30.0)
async def move_pick(firing: firings.MovePickFiring) -> firings.Outcome:
    """PickAsked -> PickMoving."""
    await _move("pick", firing.data["name"])
    return {}


@firings.on("MovePlace", timeout=30.0)
async def move_place(firing: firings.MovePlaceFiring) -> firings.Outcome:
    """PlaceAsked -> PlaceMoving."""
    await _move("place", firing.data["name"])
    return {}


@firings.on("BrakePick")
def brake_pick(firing: firings.BrakePickFiring) -> firings.Outcome:
    """PickMoving + PickStop -> PickBraking."""
    ARM.command("brake", firing.data["name"])
    return {}


@firings.on("BrakePlace")
def brake_place(firing: firings.BrakePlaceFiring) -> firings.Outcome:
    """PlaceMoving + PlaceStop -> PlaceBraking."""
    ARM.command("brake", firing.data["name"])
    return {}


@firings.on("RestPick")
def rest_pick(firing: firings.RestPickFiring) -> firings.Outcome:
    """PickBraking -> PickGivenUp, while AtRest."""
    return {"interruptions": firing.data["interruptions"] + 1}


@firings.on("RestPlace")
def rest_place(firing: firings.RestPlaceFiring) -> firings.Outcome:
    """PlaceBraking -> PlaceGivenUp, while AtRest."""
    return {"interruptions": firing.data["interruptions"] + 1}


@firings.on("FinishPlace")
def finish_place(firing: firings.FinishPlaceFiring) -> firings.Outcome:
    """PlaceMoving -> PlaceDone, while AtRest & !Holding."""
    return {"isSorted": True}


@firings.on("FailPick")
def fail_pick(firing: firings.FailPickFiring) -> firings.Outcome:
    """PickMoving -> PickFailed, while AtRest & !Holding."""
    return {"note": "the gripper is empty"}


@firings.on("FailPlace")
def fail_place(firing: firings.FailPlaceFiring) -> firings.Outcome:
    """PlaceMoving -> PlaceFailed, while AtRest & Holding."""
    return {"note": "the gripper does not let go"}
