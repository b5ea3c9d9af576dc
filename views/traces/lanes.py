"""The lanes of a trace: of managed nodes, signals, queues, clients, transitions, places of the property."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, get_args

from dineros.metamodel.clauses import SignalSetting

Group = Literal["property", "lifecycle", "signals", "topics", "services", "actions", "transitions"]
Kind = Literal["state", "signal", "queue", "client", "transition", "place"]

GROUPS: tuple[Group, ...] = get_args(Group)


@dataclass(frozen=True)
class Lane:
    """One lane.

    Attributes
    ----------
    index : int
        Its number, by which marks refer to it.
    group : str
        Its heading.
    kind : str
        Its form.
    id : str
        Id of its element: node net, signal, place of a port, client, transition.
    label, note : str
        What stands before it, and what stands behind that in small letters.
    node : str or None
        Node net it belongs to.
    channel : str or None
        Id of its channel, of queues and clients.
    queue : str or None
        ``publisher``, ``dispatcher`` or ``subscriber``.
    capacity : int or None
        Of a queue, where it is known.
    initial : int
        Value or level before the first step.
    values : list of str or None
        Of a signal with values: their names; its level is the position of one.
    """

    index: int
    group: Group
    kind: Kind
    id: str
    label: str
    note: str = ""
    node: str | None = None
    channel: str | None = None
    queue: str | None = None
    capacity: int | None = None
    initial: int = 0
    values: list[str] | None = None

    def level_of(self, value: SignalSetting) -> int:
        """Return the level of a signal; a name that is not known yet gets the next one.

        Traces of others may give a signal with names a truth value, which is then a name, too.
        """
        if self.values is None:
            return int(bool(value))
        name = str(value).lower() if isinstance(value, bool) else value
        if name not in self.values:
            self.values.append(name)
        return self.values.index(name)

    def setting(self, level: int) -> SignalSetting:
        """Return the value of a signal at a level."""
        return bool(level) if self.values is None else self.values[level]

    def to_json(self) -> dict[str, Any]:
        """Return the lane for the page; its index is its position."""
        return {name: value for name, value in vars(self).items() if name != "index" and value is not None}


class Lanes:
    """All lanes of a trace, found by key and created on first use."""

    def __init__(self) -> None:
        self.all: list[Lane] = []
        self._by_key: dict[tuple[str | None, ...], Lane] = {}

    def get(self, *key: str | None) -> Lane | None:
        """Return the lane with a key, if there is one."""
        return self._by_key.get(key)

    def make(self, *key: str | None, **features: Any) -> Lane:
        """Return the lane with a key; create it if missing."""
        lane = self._by_key.get(key)
        if lane is None:
            lane = self._by_key[key] = Lane(len(self.all), **features)
            self.all.append(lane)
        return lane
