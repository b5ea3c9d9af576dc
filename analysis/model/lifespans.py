"""What answers without times assume of topics whose messages are removed when they are too old."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.times.given import with_lifespans


def unexpired(model: pn.Net) -> list[str]:
    """Return the assumptions that answers without times about all runs make, one for each such topic.

    Parameters
    ----------
    model : Net
        The model; only a system model by the rules of ROS 2 has such topics.
    """
    if not isinstance(model, sym.SystemModel) or model.middleware != sym.Middleware.ros2:
        return []
    return [
        f"no message of topic {channel.topic} is older than its lifespan when it is taken"
        for channel in with_lifespans(model)
    ]
