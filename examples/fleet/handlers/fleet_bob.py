"""What Bob does: it asks for routes, drives, says where it is, and takes care of its battery."""

from __future__ import annotations

from . import firings


@firings.on("TAcceptBob")
def accept(firing: firings.TAcceptBobFiring) -> firings.Outcome:
    """Take a mission: the place is that of the order, whatever the battery's tokens say."""
    mission = firing.inputs["MissionBob"][0].data
    return {"order": mission["order"], "x": mission["x"], "y": mission["y"], "robot": "bob"}


@firings.on("TDriveBob", thread=True)
def drive(firing: firings.TDriveBobFiring) -> firings.Outcome:
    """Follow the route; it takes a while, so it runs on a thread of its own."""
    load = dict(firing.data["cargo"])
    load["parcels"] = load.get("parcels", 0) + 1
    return {"cargo": load}


@firings.on("TArriveBob")
def arrive(firing: firings.TArriveBobFiring) -> firings.Outcome:
    """Say where it is: the goal of the route."""
    x, y = (firing.data["route"] or [0.0, 0.0])[-2:]
    return firing.give({"ArrivalBob": {"robot": "bob", "x": x, "y": y}, "IdleBob": {"route": []}})


@firings.on("TChargeBob")
def charge(firing: firings.TChargeBobFiring) -> firings.Outcome:
    """Ask for the dock."""
    return {"robot": "bob", "note": "battery low"}
