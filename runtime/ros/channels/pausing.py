"""Subscriptions that pause: a message that the node does not take stays in the middleware, in its history."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def pausing_group(is_open: Callable[[], bool]) -> Any:
    """Return a mutually exclusive callback group: its `entity` is waited for only while the group is open.

    What cannot be executed stays out of the set that an executor waits for. It asks again at each round, and
    goes round again whenever the node has done something: whatever opens a group is done between two rounds.
    """
    from rclpy.callback_groups import MutuallyExclusiveCallbackGroup

    exclusive: Any = MutuallyExclusiveCallbackGroup  # it has no types

    class PausingGroup(exclusive):  # type: ignore[misc]
        entity: Any = None

        def can_execute(self, entity: Any) -> bool:
            """Return whether to wait for something."""
            # In this order: what a callback brings is counted before it ends.
            return bool(super().can_execute(entity)) and (entity is not self.entity or is_open())

    return PausingGroup()
