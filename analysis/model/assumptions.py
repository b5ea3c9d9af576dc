"""Assumptions that answers about all runs of a model make."""

from __future__ import annotations

from dineros.analysis.model.shared_responses import shared_responses
from dineros.metamodel import pn, sym
from dineros.metamodel.times.given import with_lifespans


def assumptions(model: pn.Net, *, with_times: bool) -> list[str]:
    """Return the assumptions about shared services and actions, and about lifespans of messages.

    Parameters
    ----------
    model : Net
        The model; only a system model by the rules of ROS 2 has such assumptions.
    with_times : bool
        Whether the answers take times into account: then messages that are too old are removed.
    """
    if not isinstance(model, sym.SystemModel) or model.middleware != sym.Middleware.ros2:
        return []
    aging = [] if with_times else with_lifespans(model)
    return [
        *shared_responses(model),
        *(f"no message of topic {each.topic} is older than its lifespan when it is taken" for each in aging),
    ]
