"""In which order a manager brings the managed nodes of an application up."""

from __future__ import annotations

import math
from typing import NamedTuple

from dineros.metamodel import pn, sym
from dineros.metamodel.elements import node_nets


class Start(NamedTuple):
    """One thing that a manager does.

    Attributes
    ----------
    label : {"configure", "activate"}
        What the node is asked for.
    node : sym.NodeNet
        The node.
    """

    label: str
    node: sym.NodeNet


def managed_nodes(model: pn.Net) -> list[sym.NodeNet]:
    """Return the node nets that have a lifecycle, in the order of the model."""
    return [node for node in node_nets(model) if node.lifecycle is not None]


def start_order(model: pn.Net) -> list[Start]:
    """Return what a manager does, one after the other, so that it obeys the start order of a model.

    What the model leaves open is configured first, and activated last: then most is there when something is
    published.

    >>> net = sym.SystemModel(id="application")
    >>> for name, steps in (("camera", (0, 2)), ("display", (0, 1))):
    ...     life = sym.Lifecycle(configureStep=steps[0], activateStep=steps[1])
    ...     _ = sym.NodeNet(id=name, net=net, lifecycle=life)
    >>> [f"{label} {node.id}" for label, node in start_order(net)]
    ['configure camera', 'configure display', 'activate display', 'activate camera']
    """
    steps: list[tuple[float, Start]] = []
    for node in managed_nodes(model):
        assert node.lifecycle is not None
        steps.append((node.lifecycle.configureStep, Start("configure", node)))
        steps.append((node.lifecycle.activateStep or math.inf, Start("activate", node)))
    # Of the same step, nodes are configured before any is activated.
    return [start for _, start in sorted(steps, key=lambda each: (each[0], each[1].label == "activate"))]
