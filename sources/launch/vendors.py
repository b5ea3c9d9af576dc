"""Nodes of launch files whose code is not in the folder, with ports from a table.

``vendors.toml`` next to this file has the table. An entry of the same name in a user's table overrides it.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path

from dineros.sources.facts import CallbackFact, Entity, NodeFact
from dineros.sources.launch.started import Started
from dineros.sources.libraries.idioms import Idiom, read_idioms

_CALLED = {
    "subscriptions": ("callback", "subscription"),
    "services": ("callback", "service"),
    "action_servers": ("execute", "execute"),
}
"""By kind of entity: the role of its callback, and its kind."""
_QUALITY = ("depth", "reliability", "durability")


@cache
def known_vendors() -> dict[str, Idiom]:
    """Return the table that is stored next to this file."""
    return read_idioms(Path(__file__).with_name("vendors.toml"))


def vendor_node(started: Started, idioms: Mapping[str, Idiom]) -> NodeFact | None:
    """Return the node that a launch file starts, by the table; None: the table does not have it.

    The effects of its callbacks are open, and it publishes at any time.

    Parameters
    ----------
    started : Started
        The started node.
    idioms : mapping of str to Idiom
        The table of libraries, including entries of users.
    """
    program = f"{started.package}/{started.executable}"
    table = {**known_vendors(), **idioms}
    idiom = next((table[each] for each in (program, started.plugin) if each in table), None)
    if idiom is None or idiom.node is None:
        return None
    fact = NodeFact(
        started.plugin or program,
        started.at,
        started.name or idiom.node,
        executor="open: its code is not in the folder",
        threads="open",
        managed=idiom.managed,
        program=program,
    )
    fact.entities = [
        Entity(
            make["kind"],
            "(no variable)",
            started.at,
            make.get("name", "open"),
            make.get("type", "open"),
            {**{key: make[key] for key in _QUALITY if key in make}, "via": "the table of packages"},
        )
        for make in idiom.makes
    ]
    for entity in fact.entities:
        if entity.kind in _CALLED:
            role, kind = _CALLED[entity.kind]
            entity.callbacks[role] = CallbackFact(kind, kind, started.at, is_open=True)
    if any(each.kind in ("publishers", "clients", "action_clients") for each in fact.entities):
        own = Entity("timers", "(no variable)", started.at, details={"period": "open: its code is missing"})
        own.callbacks["callback"] = CallbackFact("runs", "timer", started.at, is_open=True)
        fact.entities.append(own)
    fact.callbacks = [each for entity in fact.entities for each in entity.callbacks.values()]
    return fact
