"""What both formats of Romeo have in common: names, numbers, and priorities as one order."""

from __future__ import annotations

import re
from math import isfinite
from pathlib import Path

from dineros.metamodel import pn, sym
from dineros.metamodel.elements import places, transitions
from dineros.metamodel.errors import Location, ModelFileError
from dineros.metamodel.files.exact import decimal_text, fraction_of

_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_NOT_PLAIN = re.compile(r"[^A-Za-z0-9_]")


class NetOfRomeo:
    """A net that is written for Romeo.

    Parameters
    ----------
    net, path
        The net, and the file that messages name.

    Raises
    ------
    ModelFileError
        It has channels, capacities or clauses, which Romeo cannot express.
    """

    def __init__(self, net: pn.Net, path: Path | None) -> None:
        self._net = net
        self._location = Location(path)
        self._names: set[str] = set()
        if isinstance(net, sym.SystemModel) and len(net.channels):
            raise ModelFileError(
                "a system model with channels cannot be written for Romeo",
                location=self._location,
                hint="flatten it first",
            )
        self._places, self._transitions = list(places(net)), list(transitions(net))
        for place in self._places:
            if place.capacity is not None:
                raise self._error(place, "has a capacity, which Romeo cannot express", "use .pnml, or .xmi")
        for transition in self._transitions:
            if isinstance(transition, sym.Transition) and transition.clause is not None:
                raise self._error(
                    transition, "has a clause, which Romeo cannot express", "flatten the model first"
                )

    def _error(self, node: pn.Node, what: str, hint: str) -> ModelFileError:
        kind = "place" if isinstance(node, pn.Place) else "transition"
        return ModelFileError(
            f"{kind} {node.id!r} {what}", location=self._location, element=node.id, hint=hint
        )

    def _bound(self, transition: pn.Transition, bound: float) -> str:
        if not isfinite(bound) or bound < 0:
            raise self._error(
                transition, f"has an interval with the bound {bound}", "bounds are numbers from 0"
            )
        exact = fraction_of(bound)
        text = decimal_text(exact)
        return f"{exact.numerator}/{exact.denominator}" if text is None else text

    def _identifier(self, id: str) -> str:
        stem = id if _PLAIN.fullmatch(id) else _NOT_PLAIN.sub("_", id if id[:1].isalpha() else f"_{id}")
        identifier, number = stem, 1
        while identifier in self._names:
            number += 1
            identifier = f"{stem}_{number}"
        self._names.add(identifier)
        return identifier

    def _ranks(self) -> list[int]:
        """Return a number by transition: higher ones go before all lower ones, as priorities say."""
        ordered = self._transitions
        below = [_below(transition) for transition in ordered]
        ranks: dict[pn.Transition, int] = {}
        for transition, under in sorted(
            zip(ordered, below, strict=True), key=lambda pair: (len(pair[1]), ordered.index(pair[0]))
        ):
            if transition in under:
                raise self._error(transition, "has priority over itself", "break the circle of priorities")
            ranks[transition] = 1 + max((ranks[low] for low in under), default=-1)
        for transition, under in zip(ordered, below, strict=True):
            for other in ordered:
                if (ranks[other] < ranks[transition]) != (other in under):
                    hint = f"give one of {transition.id} and {other.id} priority over the other, or neither"
                    what = "has priorities that Romeo's numbers, which order all transitions, cannot express"
                    raise self._error(transition, what, hint)
        return [ranks[transition] for transition in ordered]


def _below(transition: pn.Transition) -> set[pn.Transition]:
    """Return what a transition has priority over, directly or through others."""
    found: set[pn.Transition] = set()
    todo = list(transition.overrides)
    while todo:
        low = todo.pop()
        if low not in found:
            found.add(low)
            todo.extend(low.overrides)
    return found
