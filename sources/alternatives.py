"""Ports with one name and different types that branches of a node create: a run creates one of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from dineros.sources.facts import Entity, is_open

_CHANNELS = {
    **dict.fromkeys(("publishers", "subscriptions"), "topic"),
    **dict.fromkeys(("services", "clients"), "service"),
    **dict.fromkeys(("action_servers", "action_clients"), "action"),
}
"""By kind of port: the kind of channel to which it belongs."""

Types = dict[tuple[str, str], list[tuple[str, int]]]
"""Types of ports, each with the number of its node, by channel and full name; certain ones first."""


def types_of(nodes: Iterable[Mapping[Entity, str]]) -> Types:
    """Return the types of all names.

    `nodes`: the ports of each node, with their full names.
    """
    certain: Types = {}
    others: Types = {}
    for number, names in enumerate(nodes):
        for port, name in names.items():
            if port.kind in _CHANNELS and not is_open(port.type):
                found = others if "conditional" in port.details else certain
                found.setdefault((_CHANNELS[port.kind], name), []).append((port.type, number))
    return {key: [*certain.get(key, ()), *others.get(key, ())] for key in {**certain, **others}}


def taken_of(names: Mapping[Entity, str], node: int, types: Types) -> dict[tuple[str, str], Entity]:
    """Return the chosen alternative of a node: one with the type that other nodes use, or the first.

    Parameters
    ----------
    names : mapping of Entity to str
        The ports of the node, with their full names.
    node : int
        Its number.
    types : Types
        Of all nodes.

    Returns
    -------
    dict of (str, str) to Entity
        By kind and full name.
    """
    found: dict[tuple[str, str], Entity] = {}
    for port, name in names.items():
        if "conditional" not in port.details or port.kind not in _CHANNELS or is_open(port.type):
            continue
        said = types.get((_CHANNELS[port.kind], name), [])
        wanted = [type for type, number in said if number != node]
        first = found.setdefault((port.kind, name), port)
        ranks = [wanted.index(each.type) if each.type in wanted else len(wanted) for each in (port, first)]
        if ranks[0] < ranks[1]:
            found[port.kind, name] = port
    return found
