"""Full names of nodes and of their topics, services and actions, with namespaces and remappings."""

from __future__ import annotations

from dineros.sources.facts import Entity, NodeFact, is_open


def full_node_name(node: NodeFact) -> str:
    """Return the name of a node with its namespace; a namespace that is unknown counts as none.

    Examples
    --------
    >>> from dineros.sources.places import Place
    >>> full_node_name(NodeFact("Arm", Place("arm.py", 1), "arm", "left"))
    '/left/arm'
    """
    return _in_namespace(node.name, node)


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
