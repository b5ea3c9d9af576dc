"""Good orders of levels, kept in a file next to the model, so that a hard net is searched only once.

The file is ``.dineros/orders.json`` in the folder of the model. An order is kept for the *structure* of a
net: its places, transitions and arcs, without markings and weights, because an order that is good for few
objects is good for many. If the structure changes, the key changes too, and the order is no longer found.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dineros.analysis.nets.compiled import CompiledNet

if TYPE_CHECKING:
    from dineros.metamodel.files.confined import ConfinedFolder

Order = Sequence[Sequence[str]]

PLACE = ".dineros/orders.json"
#: Largest number of orders in a file; the oldest are removed first.
MOST_ORDERS = 64
#: Largest size of the file in bytes; the file comes with the model's folder and is untrusted.
SIZE_LIMIT = 4 << 20


def structure_key(net: CompiledNet) -> str:
    """Return a hash of a net's places, transitions and arcs, without weights and markings."""
    digest = hashlib.sha256()
    digest.update(json.dumps([net.places, net.transitions]).encode())
    for arcs in (net.pre, net.post, net.inhibitor):
        digest.update(arcs.pointer.tobytes())
        digest.update(arcs.place.tobytes())
    return digest.hexdigest()


@dataclass(frozen=True)
class OrderCache:
    """The file of orders of one model."""

    model: Path

    @property
    def path(self) -> Path:
        """The file with the orders."""
        return self.model.parent / PLACE

    def order(self, net: CompiledNet) -> Order | None:
        """Return the order kept for a net of this structure, if any; an unreadable file contains none."""
        order = self._read().get(structure_key(net))
        good = isinstance(order, list) and all(
            isinstance(group, list) and all(isinstance(place, str) for place in group) for group in order
        )
        return order if good else None

    def keep(self, net: CompiledNet, order: Order) -> None:
        """Keep an order; do nothing if the folder cannot be written."""
        from dineros.metamodel.errors import ModelFileError

        orders = self._read()
        key = structure_key(net)
        orders.pop(key, None)
        orders[key] = [list(group) for group in order]
        latest = dict(list(orders.items())[-MOST_ORDERS:])
        content = _encoded(latest)
        while len(content) > SIZE_LIMIT and latest:
            latest.pop(next(iter(latest)))
            content = _encoded(latest)
        with suppress(ModelFileError):
            self._folder.write(PLACE, content)

    def _read(self) -> dict[str, Any]:
        from dineros.metamodel.errors import DinerosError
        from dineros.metamodel.json_text import decode_json

        try:
            found = decode_json(self._folder.read(PLACE, SIZE_LIMIT) or b"{}")
        except DinerosError:
            return {}
        return found if isinstance(found, dict) else {}

    @property
    def _folder(self) -> ConfinedFolder:
        from dineros.metamodel.files.confined import ConfinedFolder

        return ConfinedFolder(self.model.parent)


def _encoded(orders: dict[str, Any]) -> bytes:
    return (json.dumps(orders) + "\n").encode()
