"""What the display does: it shows what became of each piece."""

from __future__ import annotations

import logging

from . import firings

LOG = logging.getLogger("display")


@firings.on("Show")
def show(firing: firings.ShowFiring) -> None:
    """ResultHeard -> Shown."""
    piece = firing.data
    told = "sorted" if piece["isSorted"] else f"not sorted: {piece['note']}"
    LOG.info("%s: %s, interrupted %d times", piece["name"], told, piece["interruptions"])
