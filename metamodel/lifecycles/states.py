"""The states of a managed node and their changes (ROS 2 design article *Managed nodes*)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, get_args

State = Literal["unconfigured", "inactive", "active", "finalized"]
STATES: tuple[State, ...] = get_args(State)
"""The states, in their usual order."""
Label = Literal["configure", "activate", "deactivate", "cleanup", "shutdown"]

STATE_AFTER: Mapping[str, State] = {
    "configure": "inactive",
    "activate": "active",
    "deactivate": "inactive",
    "cleanup": "unconfigured",
    "shutdown": "finalized",
}
"""The state after a successful change, by the change."""

STATES_BEFORE: Mapping[str, tuple[State, ...]] = {
    "configure": ("unconfigured",),
    "activate": ("inactive",),
    "deactivate": ("active",),
    "cleanup": ("inactive",),
    "shutdown": ("unconfigured", "inactive", "active"),
}
"""The states in which a change can be requested; the state is kept if the change fails."""
