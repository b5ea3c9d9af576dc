"""The ids of goals: texts in the net, bytes in tables, messages in ROS."""

from __future__ import annotations

import uuid
from typing import Any


def text_of(goal_id: Any) -> str:
    """Return a goal's id as the net has it.

    Parameters
    ----------
    goal_id : unique_identifier_msgs.msg.UUID
        As a message has it.
    """
    return str(uuid.UUID(bytes=bytes(goal_id.uuid)))


def bytes_of(goal: str) -> bytes:
    """Return the 16 bytes of a goal's id."""
    return uuid.UUID(goal).bytes


def ros_id(goal: bytes) -> Any:
    """Return a goal's id as messages have it."""
    from unique_identifier_msgs.msg import UUID

    return UUID(uuid=list(goal))
