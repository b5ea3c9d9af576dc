"""How many tokens the places of a net hold along a firing sequence."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence

from dineros.analysis.nets.compiled import CompiledNet


class TokenLevels:
    """The levels of all places at all positions; only their changes are stored.

    `sequence`: transitions, from the initial marking; each is enabled when it is its turn.
    """

    def __init__(self, net: CompiledNet, sequence: Sequence[int]) -> None:
        self._net, self._sequence = net, sequence
        self._positions: list[list[int]] = [[0] for _ in net.places]
        self._values: list[list[int]] = [[tokens] for tokens in net.initial.tolist()]
        for number, transition in enumerate(sequence, 1):
            for place, change in net.delta[transition].items():
                self._positions[place].append(number)
                self._values[place].append(self._values[place][-1] + change)

    def marking(self, position: int) -> list[int]:
        """Return the marking after a number of firings."""
        return [
            values[bisect_right(positions, position) - 1]
            for positions, values in zip(self._positions, self._values, strict=True)
        ]

    def marking_near(self, position: int) -> Callable[[int], list[int]]:
        """Return a function from positions to markings that is quick where it is asked step by step."""
        marking, here = self.marking(position), position

        def at(wanted: int) -> list[int]:
            nonlocal here
            while here != wanted:
                sign = 1 if wanted > here else -1
                transition = self._sequence[here if sign > 0 else here - 1]
                for place, change in self._net.delta[transition].items():
                    marking[place] += sign * change
                here += sign
            return marking

        return at

    def since(self, place: int, test: Callable[[int], bool], position: int) -> int:
        """Return from which position on a place's level has passed a test, which it does at a position."""
        positions, values = self._positions[place], self._values[place]
        at = bisect_right(positions, position) - 1
        while at and test(values[at - 1]):
            at -= 1
        return positions[at]

    def until(self, place: int, test: Callable[[int], bool], position: int) -> int:
        """Return up to which position a place's level passes a test, which it does at a position."""
        positions, values = self._positions[place], self._values[place]
        at = bisect_right(positions, position)
        while at < len(positions) and test(values[at]):
            at += 1
        return positions[at] - 1 if at < len(positions) else len(self._sequence)
