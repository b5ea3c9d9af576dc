"""What may come onto places whose tokens are sent: only what the transport can send.

It is asked before a firing commits, so that nothing is recorded as done, or sent, that nobody gets.
"""

from __future__ import annotations

from collections.abc import Mapping

from dineros.runtime.nets.engine import Tokens
from dineros.runtime.nets.ports import Check
from dineros.runtime.nets.structure import Structure


class Departures:
    """The checks of a node's sending places.

    Attributes
    ----------
    transitions : frozenset of int
        Those that put tokens onto a place with a check.
    """

    def __init__(self) -> None:
        self._checks: Mapping[int, Check] = {}
        self.transitions: frozenset[int] = frozenset()

    def check_by(self, checks: Mapping[int, Check], structure: Structure) -> None:
        """Check places from now on: place -> what raises for data that cannot be sent."""
        self._checks = checks
        self.transitions = frozenset(
            number
            for number, places in enumerate(structure.outputs)
            if any(place in checks for place, _ in places)
        )

    def refused(self, made: Tokens) -> Exception | None:
        """Return why tokens that a firing makes cannot be sent; None: they can, or need not be."""
        for place, tokens in made:
            check = self._checks.get(place)
            if check is not None:
                try:
                    for token in tokens:
                        check(token.data)
                except Exception as error:
                    return error
        return None
