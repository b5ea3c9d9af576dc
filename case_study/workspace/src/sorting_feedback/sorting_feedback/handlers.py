"""What the node `/feedback` does when its transitions fire: the user sees each result."""

from __future__ import annotations

import logging

from dineros.runtime import Net

from . import firings

LOG = logging.getLogger("sorting")


def configure(net: Net) -> None:
    """Leave the net as it is."""


@firings.on("TShowResult")
def show(firing: firings.TShowResultFiring) -> None:
    """Feedback -> Shown."""
    data = firing.data
    placed = "sorted" if data["placeSuccess"] else "not sorted"
    LOG.info("%s: %s%s", data["name"], placed, "".join(f"; {error}" for error in data["errors"]))
