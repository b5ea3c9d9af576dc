"""What the battery does: it counts legs."""

from __future__ import annotations

import logging

from . import firings

LOG = logging.getLogger("robot.battery")


@firings.on("TWarn")
def warn(firing: firings.TWarnFiring) -> firings.TWarnOutcome:
    """Watching + 2 Spent (read) -> Warned + Warning."""
    LOG.info("the battery is low")
    return {}


@firings.on("TFull")
def full(firing: firings.TFullFiring) -> firings.TFullOutcome:
    """Charging + no Spent -> ChargeExit + Watching."""
    LOG.info("the battery is full")
    return {"note": "full"}
