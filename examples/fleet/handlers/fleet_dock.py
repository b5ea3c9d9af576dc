"""What the dock does: it has the charger switched on and off."""

from __future__ import annotations

from . import firings


@firings.on("TEnter")
def enter(firing: firings.TEnterFiring) -> firings.Outcome:
    """ChargeEntry + BayFree -> Plugged + PowerReq: power on."""
    return firing.give({"PowerReq": {"powerOn": True}})


@firings.on("TFull")
def full(firing: firings.TFullFiring) -> firings.Outcome:
    """Charging -> Leaving + PowerReq: power off."""
    return firing.give({"PowerReq": {"powerOn": False}})


@firings.on("TLeave")
def leave(firing: firings.TLeaveFiring) -> firings.Outcome:
    """Leaving + PowerRes -> ChargeExit + BayFree: send the charger's answer to the robot."""
    charger = firing.inputs["PowerRes"][0].data
    return {"note": charger["note"], "powerOk": charger["powerOk"]}
