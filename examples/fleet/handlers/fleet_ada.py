"""What Ada does: it asks for routes, drives, says where it is, and takes care of its battery."""

from __future__ import annotations

from . import firings


@firings.on("TAcceptAda")
def accept(firing: firings.TAcceptAdaFiring) -> firings.Outcome:
    """Take a mission: the place is that of the order, whatever the battery's tokens say."""
    mission = firing.inputs["MissionAda"][0].data
    return {"order": mission["order"], "x": mission["x"], "y": mission["y"], "robot": "ada"}


@firings.on("TDriveAda", thread=True)
def drive(firing: firings.TDriveAdaFiring) -> firings.Outcome:
    """Follow the route; it takes a while, so it runs on a thread of its own."""
    load = dict(firing.data["cargo"])
    load["parcels"] = load.get("parcels", 0) + 1
    return {"cargo": load}


@firings.on("TArriveAda")
def arrive(firing: firings.TArriveAdaFiring) -> firings.Outcome:
    """Say where it is: the goal of the route."""
    x, y = (firing.data["route"] or [0.0, 0.0])[-2:]
    return firing.give({"ArrivalAda": {"robot": "ada", "x": x, "y": y}, "IdleAda": {"route": []}})


@firings.on("TChargeAda")
def charge(firing: firings.TChargeAdaFiring) -> firings.Outcome:
    """Ask for the dock."""
    return {"robot": "ada", "note": "battery low"}
