"""What the board does: it lists what was delivered."""

from __future__ import annotations

import logging

from . import firings

LOG = logging.getLogger("board")


@firings.on("List")
def list_delivery(firing: firings.ListFiring) -> None:
    """Heard -> Listed."""
    errand = firing.data
    LOG.info(
        "order %d delivered to bay %d by %s, attempt %d",
        errand["number"],
        errand["bay"],
        errand["robot"],
        errand["attempts"],
    )
