"""What the detector does: it looks for the dock's marker."""

from __future__ import annotations

from dineros.runtime import Candidates, Enabled, Net


def configure(net: Net) -> None:
    """Decide by the picture."""
    net.selection(decide)


def decide(candidates: Candidates) -> Enabled | None:
    """Tell of pictures with the marker, leave the others."""
    found = candidates.named("TDetect")
    if found is None:
        nothing = candidates.named("TNothing")
        return nothing if nothing and not nothing.inputs["Seen"][0].data["marker"] else None
    return found if found.inputs["Seen"][0].data["marker"] else candidates.named("TNothing")
