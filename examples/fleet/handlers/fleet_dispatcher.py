"""What the dispatcher does: it gives orders to robots and notes what was delivered."""

from __future__ import annotations

import logging

from dineros.runtime import Candidates, Enabled, Net

from . import firings

LOG = logging.getLogger("fleet.dispatcher")


def configure(net: Net) -> None:
    """Prefer closing missions to assigning new ones."""

    @net.selection
    def close_first(enabled: Candidates) -> Enabled:
        return enabled.named("TClose") or enabled.random()


@firings.on("TAssignAda")
def assign_ada(firing: firings.TAssignAdaFiring) -> firings.Outcome:
    """Orders + Slots -> SendAda: the mission is Ada's."""
    return {"robot": "ada"}


@firings.on("TAssignBob")
def assign_bob(firing: firings.TAssignBobFiring) -> firings.Outcome:
    """Orders + Slots -> SendBob: the mission is Bob's."""
    return {"robot": "bob"}


@firings.on("TClose")
def close(firing: firings.TCloseFiring) -> firings.Outcome:
    """Arrived -> Closed + Slots: a robot is where it should be."""
    LOG.debug("%(robot)s arrived at %(x)g, %(y)g", firing.data)
    return {}
