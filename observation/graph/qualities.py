"""Converts discovered quality of service to plain values."""

from __future__ import annotations

from typing import Any

from dineros.observation.systems import TopicEndpoint, quality_of_profile

_UNBOUNDED = 9_223_372_036
"""Seconds from which a time counts as unbounded: rmw uses 2^63 - 1 nanoseconds."""


def endpoint_of(topic: str, info: Any) -> TopicEndpoint:
    """Return a publisher or a subscription of a topic.

    Parameters
    ----------
    topic : str
        Full name.
    info : rclpy.topic_endpoint_info.TopicEndpointInfo
        The discovered endpoint.
    """
    profile = info.qos_profile
    quality = quality_of_profile(profile, _seconds)
    depths = {"KEEP_ALL": 0, "KEEP_LAST": profile.depth or None}
    return TopicEndpoint(topic, info.topic_type, quality, depths.get(profile.history.name))


def _seconds(duration: Any) -> float | None:
    seconds: float = duration.nanoseconds / 1e9
    return seconds if 0 < seconds < _UNBOUNDED - 1 else None
