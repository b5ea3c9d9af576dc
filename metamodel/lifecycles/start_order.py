"""The order in which a manager starts the managed nodes of an application."""

from __future__ import annotations

import math
from typing import NamedTuple

from dineros.metamodel import pn, sym
from dineros.metamodel.elements import label, node_nets


class Start(NamedTuple):
    """One step of a manager: the change that a node is asked for, ``configure`` or ``activate``."""

    label: str
    node: sym.NodeNet


def managed_nodes(model: pn.Net) -> list[sym.NodeNet]:
    """Return the node nets with a lifecycle, in model order."""
    return [node for node in node_nets(model) if node.lifecycle is not None]


def start_steps(node: sym.NodeNet) -> dict[str, float]:
    """Return the steps in which a manager configures and activates a node; empty without a lifecycle.

    Nodes without a given step are configured first, and activated last.
    """
    life = node.lifecycle
    return (
        {} if life is None else {"configure": life.configureStep, "activate": life.activateStep or math.inf}
    )


def in_order(step: tuple[float, str]) -> tuple[float, bool]:
    """Return the sort key of a step: within a step, nodes are configured before any is activated."""
    return step[0], step[1] == "activate"


def start_order(model: pn.Net) -> list[Start]:
    """Return the sequence of a manager's steps, according to the start order of a model.

    Nodes without a given step are configured first, and activated last: then most nodes are configured when
    messages are published.

    >>> net = sym.SystemModel(id="application")
    >>> for name, steps in (("camera", (0, 2)), ("display", (0, 1))):
    ...     life = sym.Lifecycle(configureStep=steps[0], activateStep=steps[1])
    ...     _ = sym.NodeNet(id=name, net=net, lifecycle=life)
    >>> [f"{label} {node.id}" for label, node in start_order(net)]
    ['configure camera', 'configure display', 'activate display', 'activate camera']
    """
    steps = [
        (number, label, node) for node in managed_nodes(model) for label, number in start_steps(node).items()
    ]
    return [Start(what, node) for _, what, node in sorted(steps, key=lambda step: in_order(step[:2]))]


def manager_arguments(model: pn.Net) -> list[str]:
    """Return the arguments of an application's manager, in order, such as ``configure:/cell/camera``.

    Empty without managed nodes, and under rules without lifecycles.
    """
    if not isinstance(model, sym.SystemModel) or model.middleware != sym.Middleware.ros2:
        return []
    return [start_argument(what, node.namespace or "", label(node)) for what, node in start_order(model)]


def start_argument(what: str, namespace: str, name: str) -> str:
    """Return the argument of a manager for one node."""
    return f"{what}:{'/'.join(['', *filter(None, namespace.split('/')), name])}"
