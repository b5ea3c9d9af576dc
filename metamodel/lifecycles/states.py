"""The states of a managed node, and what leads from one to another (ROS 2 design article *Managed nodes*)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, get_args

State = Literal["unconfigured", "inactive", "active", "finalized"]
STATES: tuple[State, ...] = get_args(State)
"""In the order in which a node goes through them."""
Label = Literal["configure", "activate", "deactivate", "cleanup", "shutdown"]

STATE_AFTER: Mapping[str, State] = {
    "configure": "inactive",
    "activate": "active",
    "deactivate": "inactive",
    "cleanup": "unconfigured",
    "shutdown": "finalized",
}
"""The state that a node has when what it was asked for has succeeded."""

STATES_BEFORE: Mapping[str, tuple[State, ...]] = {
    "configure": ("unconfigured",),
    "activate": ("inactive",),
    "deactivate": ("active",),
    "cleanup": ("inactive",),
    "shutdown": ("unconfigured", "inactive", "active"),
}
"""The states in which a node can be asked for it; it keeps that state when it fails."""
