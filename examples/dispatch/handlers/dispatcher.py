"""What the dispatcher does: it counts how often an order was given to a robot."""

from __future__ import annotations

from dineros.runtime import Firing, Net


def configure(net: Net) -> None:
    """Count at each transition that assigns."""
    for transition in net.structure.transitions:
        if transition.startswith("Assign"):
            net.handler(transition)(assign)


def assign(firing: Firing) -> dict[str, object]:
    """Orders + Free -> Goal + UnderWay."""
    return {"attempts": firing.inputs["Orders"][0].data["attempts"] + 1}
