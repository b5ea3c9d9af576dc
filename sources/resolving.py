"""Full names of nodes and of their topics, services and actions, with namespaces and remappings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from dineros.sources.facts import NODE, SPACE, Entity, NodeFact, is_open


def full_node_name(node: NodeFact) -> str:
    """Return the name of a node with its namespace; a namespace that is unknown counts as none.

    Examples
    --------
    >>> from dineros.sources.places import Place
    >>> full_node_name(NodeFact("Arm", Place("arm.py", 1), "arm", "left"))
    '/left/arm'
    """
    return _in_namespace(node.name, node)


def own_name(node: NodeFact, given: Mapping[str, Any], method: str) -> str | None:
    """Return what a node learns of its own name or namespace; open, or None, if it is unknown.

    Parameters
    ----------
    node : NodeFact
        The node, as its code makes it.
    given : mapping of str to object
        What a launch file gives, its name and namespace among it.
    method : {"get_name", "get_namespace", "get_fully_qualified_name"}
        The method by which it asks.
    """
    own = replace(node, name=given.get(NODE, node.name))
    own.namespace = given.get(SPACE, node.namespace)
    if method == "get_namespace":
        return own.namespace if is_open(own.namespace) else f"/{own.namespace.strip('/')}"
    if is_open(own.name) or (is_open(own.namespace) and method == "get_fully_qualified_name"):
        return None
    return own.name if method == "get_name" else full_node_name(own)


def full_name(name: str, node: NodeFact) -> str:
    """Return the full name of a topic, service or action of a node; open if it is unknown.

    Examples
    --------
    >>> from dineros.sources.places import Place
    >>> new = {"goal": "/goal", "~/x": "{side}/x"}
    >>> arm = NodeFact("Arm", Place("arm.py", 1), "arm", "left", remappings=new)
    >>> [full_name(each, arm) for each in ("pose", "~/pose", "/pose", "goal", "/left/goal", "~/x")]
    ['/left/pose', '/left/arm/pose', '/pose', '/goal', '/goal', '{side}/x']
    """
    own = _expanded(name, node)
    for source, target in node.remappings.items():
        if own == _expanded(source, node):
            return _expanded(target, node)
    return own


def full_name_of(entity: Entity, node: NodeFact) -> str:
    """Return the full name of a port of a node; open if it is unknown."""
    return full_name(entity.name, node)


def _expanded(name: str, node: NodeFact) -> str:
    if is_open(name):
        return name
    if name == "~" or name.startswith("~/"):
        return f"{full_node_name(node)}{name[1:]}"
    return _in_namespace(name, node)


def _in_namespace(name: str, node: NodeFact) -> str:
    if name.startswith("/"):
        return name
    namespace = "" if is_open(node.namespace) else node.namespace
    return "/".join(["", *filter(None, namespace.split("/")), name])
