"""What the charger does: it executes its commands, and reports them."""

from __future__ import annotations

from . import firings


@firings.on("TSwitch")
def switch(firing: firings.TSwitchFiring) -> firings.Outcome:
    """PowerEntry -> PowerExit."""
    return {"powerOk": True, "note": "power is on" if firing.data["powerOn"] else "power is off"}
