"""Assumptions that answers about all runs of a model make."""

from __future__ import annotations

from dineros.analysis.model.shared_responses import shared_responses
from dineros.metamodel import pn, sym
from dineros.metamodel.times.given import with_lifespans

MOST_NAMED = 3
"""Maximum number of assumptions about the source that are named; the model has all of them."""


def of_source(model: pn.Net) -> list[str]:
    """Return the assumption about the code or observations that a model was made from, if there is one.

    If such a model lacks a part, or presumes a value, the code can do what no run of the model does. So
    answers about all runs hold for the code only if these parts and values make no difference.
    """
    assumed = model.assumptions if isinstance(model, sym.SystemModel) else ()
    lines = [each.text for each in assumed if isinstance(each, sym.SourceAssumption)]
    if not lines:
        return []
    shown = [str(line) for line in lines[:MOST_NAMED]]
    if len(lines) > MOST_NAMED:
        shown.append(f"and {len(lines) - MOST_NAMED} more")
    return [f"what the model lacks changes nothing ({len(lines)}): {'; '.join(shown)}"]


def assumptions(model: pn.Net, *, with_times: bool) -> list[str]:
    """Return the assumptions about the source, about shared services and actions, and about lifespans.

    Parameters
    ----------
    model : Net
        The model; only a system model has such assumptions.
    with_times : bool
        Whether the answers take times into account: then messages that are too old are removed.
    """
    if not isinstance(model, sym.SystemModel) or model.middleware != sym.Middleware.ros2:
        return of_source(model)
    aging = [] if with_times else with_lifespans(model)
    return [
        *of_source(model),
        *shared_responses(model),
        *(f"no message of topic {each.topic} is older than its lifespan when it is taken" for each in aging),
    ]
