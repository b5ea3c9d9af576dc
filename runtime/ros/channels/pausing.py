"""Subscriptions that pause: a message that the node does not take stays in the history of the middleware."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def pausing_group(is_open: Callable[[], bool]) -> Any:
    """Return a mutually exclusive callback group whose `entity` is waited for only while the group is open.

    The executor does not wait for entities that cannot be executed. It checks this again in each round, and
    starts a new round whenever the node has done something: a group is opened only between two rounds.
    """
    from rclpy.callback_groups import MutuallyExclusiveCallbackGroup

    exclusive: Any = MutuallyExclusiveCallbackGroup  # without type hints

    class PausingGroup(exclusive):  # type: ignore[misc]
        entity: Any = None

        def can_execute(self, entity: Any) -> bool:
            """Return whether to wait for an entity."""
            # In this order: messages of a callback are counted before the callback ends.
            return bool(super().can_execute(entity)) and (entity is not self.entity or is_open())

    return PausingGroup()
