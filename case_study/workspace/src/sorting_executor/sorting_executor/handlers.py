"""What the node `/executor` does when its transitions fire: the arms move, and stop for a human."""

from __future__ import annotations

import asyncio

from dineros.runtime import Candidates, Choice, Enabled, Net
from sorting_cell.cell import Cell, connect
from sorting_cell.world import Operation

from . import firings

POLL = 0.005  # seconds between two looks at a signal
AGAIN = 1.5  # seconds after which a command that shows no effect is sent again
PAUSE = 0.2  # seconds before the sensor is asked again
FIRST = ("TPickAbort", "TPlaceAbort", "TStop")
"""Transitions that never wait for others."""

_cell: Cell
_net: Net


def configure(net: Net) -> None:
    """Connect the arms, and prefer what keeps people safe."""
    global _cell, _net
    _cell, _net = connect(net), net
    net.selection(choose)


def choose(candidates: Candidates) -> Enabled | Choice | None:
    """Stop and give up before anything else; believe the sensor."""
    for name in FIRST:
        urgent = candidates.named(name)
        if urgent is not None:
            return urgent
    safe = candidates.named("TSafe")
    if safe is not None:
        (response,) = safe.inputs["SensorRes"]
        return candidates.named("TUnsafe") if response.data["humanDetected"] else safe
    return candidates.random()


@firings.on("TRetry")
async def retry(firing: firings.TRetryFiring) -> firings.Outcome:
    """Unsafe -> SensorReq, not faster than a human walks."""
    await asyncio.sleep(PAUSE)
    return {}


async def _start(operation: Operation, name: str) -> None:
    """Send a motion to the arm; return when the signals speak of this motion and no earlier one.

    A command may be lost when this node or the cell has just been started again: it is sent until it shows.
    """
    while True:
        _cell.command(operation, name)
        for _ in range(round(AGAIN / POLL)):
            if not (_net.signal("RobotIsIdle").value or _net.signal("RobotHasFinished").value):
                return
            await asyncio.sleep(POLL)


@firings.on("TPick", timeout=30.0)
async def pick(firing: firings.TPickFiring) -> firings.Outcome:
    """PickEntry + Safe -> PickRun + Safe."""
    await _start("pick", firing.data["name"])
    return {}


@firings.on("TPickSuccess")
def picked(firing: firings.TPickSuccessFiring) -> firings.Outcome:
    """PickRun -> PickExit, while (RobotIsIdle | RobotHasFinished) & ObjectIsPicked."""
    return {"pickSuccess": True}


@firings.on("TPickFail")
def pick_failed(firing: firings.TPickFailFiring) -> firings.Outcome:
    """PickRun -> PickExit, while (RobotIsIdle | RobotHasFinished) & !ObjectIsPicked."""
    return {"pickSuccess": False, "errors": [*firing.data["errors"], "pick failed"]}


@firings.on("TPickAbort")
def pick_given_up(firing: firings.TPickAbortFiring) -> firings.Outcome:
    """PickRun + Unsafe -> PickExit + Unsafe."""
    _cell.abort()
    return {"pickSuccess": False, "errors": [*firing.data["errors"], "pick given up for a human"]}


@firings.on("TPlace", timeout=30.0)
async def place(firing: firings.TPlaceFiring) -> firings.Outcome:
    """PlaceEntry + Safe -> PlaceRun + Safe; the arm fetches what it does not hold."""
    await _start("place", firing.data["name"])
    return {}


@firings.on("TPlaceSuccess")
def placed(firing: firings.TPlaceSuccessFiring) -> firings.Outcome:
    """PlaceRun -> PlaceExit, while (RobotIsIdle | RobotHasFinished) & ObjectIsPlaced."""
    return {"placeSuccess": True}


@firings.on("TPlaceFail")
def place_failed(firing: firings.TPlaceFailFiring) -> firings.Outcome:
    """PlaceRun -> PlaceExit, while (RobotIsIdle | RobotHasFinished) & !ObjectIsPlaced."""
    return {"placeSuccess": False, "errors": [*firing.data["errors"], "place failed"]}


@firings.on("TPlaceAbort")
def place_given_up(firing: firings.TPlaceAbortFiring) -> firings.Outcome:
    """PlaceRun + Unsafe -> PlaceExit + Unsafe."""
    _cell.abort()
    return {"placeSuccess": False, "errors": [*firing.data["errors"], "place given up for a human"]}
