"""What the navigator does: it drives to a waypoint, looks ahead, and brakes."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from dineros.metamodel.errors import DinerosError
from dineros.runtime import Candidates, Enabled, Net

from . import firings

NEAR = 0.5  # metres to what is ahead at which it stops
SETTLES = 1.0  # seconds after which a waypoint is where the robot stands already
FIRST = ("TBrake", "TStay", "TArrive")
"""Transitions that never wait for others."""
SEEING = ("TBlocked", "TProceed")

_net: Net
_move: Callable[[float, float, bool], None]


def configure(net: Net) -> None:
    """Connect the wheels, and believe the lidar."""
    global _net, _move
    _net, _move = net, wheels(net)
    net.selection(choose)


def wheels(net: Net) -> Callable[[float, float, bool], None]:
    """Return what sends the wheels their target; z of the point says whether to move at all."""
    try:
        node = net.ros_node
    except DinerosError:  # there are none without ROS
        return lambda x, y, moves: None
    from geometry_msgs.msg import Point  # type: ignore[import-untyped]

    publisher = node.create_publisher(Point, "/wheels/target", 10)
    return lambda x, y, moves: publisher.publish(Point(x=x, y=y, z=1.0 if moves else 0.0))


def choose(candidates: Candidates) -> Enabled | None:
    """Brake before all else; continue or stop by what is ahead."""
    for name in FIRST:
        urgent = candidates.named(name)
        if urgent is not None:
            return urgent
    blocked = candidates.named("TBlocked")
    if blocked is not None:
        distance = blocked.inputs["Scan"][0].data["data"]
        assert isinstance(distance, float)
        decided = blocked if distance < NEAR else candidates.named("TProceed")
        if decided is not None:
            return decided
    others = [each for each in candidates if not each.transition.endswith(SEEING)]
    return others[0] if others else None


@firings.on("TDrive", timeout=30.0)
async def drive(firing: firings.TDriveFiring) -> firings.TDriveOutcome:
    """Target + Permits + Standing -> Driving + Leg: off, until the robot is no longer where it was."""
    loop = asyncio.get_running_loop()
    end = loop.time() + SETTLES
    while True:
        _move(firing.data["x"], firing.data["y"], True)
        await asyncio.sleep(0.05)
        if not _net.signal("AtGoal").value or loop.time() > end:
            return {}


@firings.on("TProceed")
def proceed(firing: firings.TProceedFiring) -> firings.TProceedOutcome:
    """Driving + Scan -> Driving + Told: send the command to the wheels again, and feedback to the client."""
    trip = firing.inputs["Driving"][0].data
    _move(trip["x"], trip["y"], True)
    return firing.give({"Told": {"distance": firing.inputs["Scan"][0].data["data"]}})


@firings.on("TBlocked")
def blocked(firing: firings.TBlockedFiring) -> firings.TBlockedOutcome:
    """Driving + Scan -> Blocked + Standing."""
    _move(0.0, 0.0, False)
    return {"note": "blocked"}


@firings.on("TBrake")
def brake(firing: firings.TBrakeFiring) -> firings.Outcome:
    """Driving + Stop -> Stopped + Standing."""
    _move(0.0, 0.0, False)
    return {"note": "canceled"}


@firings.on("TArrive")
def arrive(firing: firings.TArriveFiring) -> firings.Outcome:
    """Driving -> There + Standing, while AtGoal."""
    return {"note": "reached"}
