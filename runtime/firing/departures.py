"""Checks that the transport can send tokens before they are put onto a place from which they are sent.

The check runs before a firing commits, so that no firing or message is recorded that cannot be sent.
"""

from __future__ import annotations

from collections.abc import Mapping

from dineros.runtime.nets.passing import Tokens
from dineros.runtime.nets.ports import Check
from dineros.runtime.nets.structure import Structure


class Departures:
    """The checks of a node's sending places.

    Attributes
    ----------
    transitions : frozenset of int
        Transitions that put tokens onto a place with a check.
    """

    def __init__(self) -> None:
        self._checks: Mapping[int, Check] = {}
        self.transitions: frozenset[int] = frozenset()

    def check_by(self, checks: Mapping[int, Check], structure: Structure) -> None:
        """Use these checks from now on: place -> function that raises for data that cannot be sent."""
        self._checks = checks
        self.transitions = frozenset(
            number
            for number, places in enumerate(structure.outputs)
            if any(place in checks for place, _ in places)
        )

    def refused(self, made: Tokens) -> Exception | None:
        """Return why tokens made by a firing cannot be sent; None: they can, or they are not sent."""
        for place, tokens in made:
            check = self._checks.get(place)
            if check is not None:
                try:
                    for token in tokens:
                        check(token.data)
                except Exception as error:
                    return error
        return None
