"""What the map does: it plans routes from the entrance."""

from __future__ import annotations

from . import firings


@firings.on("TPlan")
def plan(firing: firings.TPlanFiring) -> firings.Outcome:
    """PlanEntry + MapLoaded (read) -> PlanExit: first along x, then along y."""
    x, y = firing.data["x"], firing.data["y"]
    return {"route": [0.0, 0.0, x, 0.0, x, y]}
