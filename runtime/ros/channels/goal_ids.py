"""Conversions of goal ids: texts in the net, bytes in tables, messages in ROS."""

from __future__ import annotations

import uuid
from typing import Any


def text_of(goal_id: Any) -> str:
    """Return the id of a goal in a message, as text."""
    return str(uuid.UUID(bytes=bytes(goal_id.uuid)))


def bytes_of(goal: str) -> bytes:
    """Return the 16 bytes of a goal's id."""
    return uuid.UUID(goal).bytes


def ros_id(goal: bytes) -> Any:
    """Return a goal id as a ROS message."""
    from unique_identifier_msgs.msg import UUID

    return UUID(uuid=list(goal))
