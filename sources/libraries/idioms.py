"""The table of library idioms: entities and effects of library classes and functions, as data.

``idioms.toml`` next to this file has the table and describes its format.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.files.reading import read_bytes
from dineros.metamodel.files.toml import decode_toml
from dineros.sources.branches import Do
from dineros.sources.facts import CallbackFact, Effect, Entity
from dineros.sources.libraries.idiom_tables import checked

MOST_BYTES = 1 << 20
"""Limit of the bytes of a table."""


@dataclass(frozen=True)
class Idiom:
    """The entities and effects of a class or a function of a library."""

    path: str
    """Dotted name."""
    arguments: tuple[str, ...] = ()
    """Names of its arguments, in order."""
    makes: tuple[Mapping[str, Any], ...] = ()
    """Entities that it creates on the node; ``{name}`` is the argument of that name."""
    methods: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """Effects of its methods."""
    node: str | None = None
    """Name of the node that it is: the class is one."""
    does: Mapping[str, Any] = field(default_factory=dict)
    """What a call of the function does: ``do``, ``what``, ``how``."""
    synchronizes: str | None = None
    """Argument that has the subscriptions whose messages one callback takes together."""
    quality: Mapping[str, Any] = field(default_factory=dict)
    """Quality of service that a call of the function returns: ``depth``, ``reliability``, ``durability``."""
    managed: bool = False
    """Whether the node has a lifecycle."""
    others: str = ""
    """What it makes of its own if it gets no node, in words."""


def read_idioms(path: Path) -> dict[str, Idiom]:
    """Read a table of idioms.

    Raises
    ------
    DinerosError
        The file cannot be read, is not TOML, or an entry is not as the guide describes it.
    """
    found = {}
    table = decode_toml(read_bytes(path, MOST_BYTES), path)
    for key in table:
        if key != "idiom":
            raise DinerosError(f"{key}: is unknown", location=Location(path), hint="known is [[idiom]]")
    entries = table.get("idiom", [])
    if not isinstance(entries, list) or not all(isinstance(each, dict) for each in entries):
        raise DinerosError("idiom: is not a list of tables", location=Location(path))
    for number, entry in enumerate(entries, start=1):
        checked(entry, number, path)
        idiom = Idiom(
            entry["path"],
            tuple(entry.get("arguments", ())),
            tuple(entry.get("makes", ())),
            entry.get("methods", {}),
            entry.get("node"),
            {key: entry[key] for key in ("do", "what", "how") if key in entry},
            entry.get("synchronizes"),
            entry.get("quality", {}),
            entry.get("managed", False),
            entry.get("others", ""),
        )
        for name in (idiom.path, *entry.get("also", ())):
            found[name] = idiom
    return found


@cache
def known_idioms() -> dict[str, Idiom]:
    """Return the table that is stored next to this file."""
    return read_idioms(Path(__file__).with_name("idioms.toml"))


def publish_at_each_tick(timer: Entity, publisher: Entity) -> None:
    """Give the timer of a library its callback, which publishes.

    The callback is not in the code of the folder, so it is not in the list of the callbacks of its node.
    """
    effect = Effect("publish", publisher.port, timer.at, "always", entity=publisher)
    found = CallbackFact(f"timer of {timer.details['via']}", "timer", timer.at, [effect])
    found.body = [Do(effect)]
    timer.callbacks["callback"] = found
