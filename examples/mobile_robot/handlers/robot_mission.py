"""What the mission does: it sends the robot from waypoint to waypoint, and to its dock."""

from __future__ import annotations

import logging

from dineros.runtime import Candidates, Enabled, Net

from . import firings

LOG = logging.getLogger("robot.mission")


def configure(net: Net) -> None:
    """The battery goes before the next waypoint."""

    @net.selection
    def battery_first(enabled: Candidates) -> Enabled:
        return enabled.named("TRecall") or enabled.named("TDock") or enabled.random()


@firings.on("TRetry")
def retry(firing: firings.TRetryFiring) -> firings.Outcome:
    """Failed + UnderWay + Retry -> Goal + UnderWay + Tried: the same waypoint once more."""
    return {"note": "second try"}


@firings.on("TGiveUp")
def give_up(firing: firings.TGiveUpFiring) -> firings.Outcome:
    """Failed + UnderWay + Tried -> Closed + Idle + Tried: the way stays blocked."""
    LOG.warning("%(name)s cannot be reached", firing.data)
    return {"note": "given up"}


@firings.on("TRefused")
def refused(firing: firings.TRefusedFiring) -> firings.Outcome:
    """Refused + UnderWay -> Closed + Idle."""
    return {"note": "refused"}


@firings.on("TBack")
def back(firing: firings.TBackFiring) -> firings.Outcome:
    """Back + Recalled -> Waypoints + AskDock: its turn comes again after the dock."""
    return {"note": "none"}
