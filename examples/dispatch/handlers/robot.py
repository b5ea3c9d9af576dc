"""What each robot does, all with this file: it crosses the aisle, and turns back when it is recalled."""

from __future__ import annotations

import asyncio
from contextlib import suppress

from dineros.metamodel.errors import DinerosError
from dineros.runtime import Firing, Net

CROSSING = 0.4
"""Seconds in the aisle; on ROS the parameter `crossing_time`."""


def configure(net: Net) -> None:
    """Give the robot of this number its handlers; what can be done about a recall goes first."""
    number = net.id.removeprefix("robot")
    seconds = crossing_time(net)

    @net.selection
    def choose(candidates):  # type: ignore[no-untyped-def]
        for name in ("Stay", "GiveUp", "TurnBack"):
            urgent = candidates.named(f"{name}{number}")
            if urgent is not None:
                return urgent
        return candidates.random()

    @net.handler(f"Cross{number}")
    async def cross(firing: Firing) -> None:
        # A recall ends it early. The request inhibits the transition, so that the net turns back then.
        with suppress(TimeoutError):
            await asyncio.wait_for(firing.cancel, seconds)

    @net.handler(f"Unload{number}")
    def unload(firing: Firing) -> dict[str, object]:
        return {"robot": net.id}


def crossing_time(net: Net) -> float:
    """Return what the parameter says, or the default where there is no ROS."""
    try:
        parameter = net.ros_node.declare_parameter("crossing_time", CROSSING)
    except DinerosError:
        return CROSSING
    return float(parameter.value)
