"""Queues whose order matters, because guards distinguish their messages: a ring of one-message cells.

The head marks the cell of the oldest message, the tail the cell for the next one. An empty queue starts again
at the first cell, so that a queue with few messages has few markings.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from dineros.metamodel import pn
from dineros.metamodel.guards.colours import Colour


class Touch(NamedTuple):
    """One arc between a transition and a place: ``takes``, ``reads`` or ``puts``, and its weight."""

    kind: str
    place: pn.Place
    weight: int = 1


class Ring:
    """The cells of one queue.

    Parameters
    ----------
    load : pn.Place
        The place of its messages.
    size : int
        Its capacity, at least two.
    colours : sequence of Colour
        The possible colours of messages.
    make : callable
        Makes a place from a part of its id and its tokens.
    text : callable
        Describes a colour.
    """

    def __init__(
        self,
        load: pn.Place,
        size: int,
        colours: Sequence[Colour],
        make: Callable[[str, int], pn.Place],
        text: Callable[[Colour], str],
    ) -> None:
        self._load, self._size = load, size
        numbers = range(size)
        self.cells = {
            (number, colour): make(f"{number + 1}: {text(colour)}", 0)
            for number in numbers
            for colour in colours
        }
        self.heads = [make(f"oldest={number + 1}", int(number == 0)) for number in numbers]
        self.tails = [make(f"next={number + 1}", int(number == 0)) for number in numbers]

    def ways(self, taken: Sequence[Colour], put: Sequence[Colour]) -> Iterator[list[Touch]]:
        """Yield the ways to move a message: it enters, it leaves, or a new one replaces the oldest."""
        assert len(taken) <= 1 and len(put) <= 1, "messages come and leave one at a time"
        if not taken:
            return self._enter(put[0])
        return self._replace(taken[0], put[0]) if put else self._leave(taken[0])

    def _enter(self, colour: Colour) -> Iterator[list[Touch]]:
        for number, tail in enumerate(self.tails):
            yield [
                Touch("takes", tail),
                Touch("puts", self.tails[self._after(number)]),
                Touch("puts", self.cells[number, colour]),
            ]

    def _leave(self, colour: Colour) -> Iterator[list[Touch]]:
        for number, head in enumerate(self.heads):
            after = self._after(number)
            oldest = [Touch("takes", head), Touch("takes", self.cells[number, colour])]
            # The transition itself takes one message of the load, so this requires a second one.
            yield [*oldest, Touch("puts", self.heads[after]), Touch("reads", self._load)]
            yield [
                *oldest,
                Touch("takes", self.tails[after]),
                Touch("puts", self.heads[0]),
                Touch("puts", self.tails[0]),
            ]

    def _replace(self, oldest: Colour, new: Colour) -> Iterator[list[Touch]]:
        for number, head in enumerate(self.heads):
            after = self._after(number)
            yield [
                Touch("takes", head),
                Touch("takes", self.tails[number]),
                Touch("takes", self.cells[number, oldest]),
                Touch("puts", self.cells[number, new]),
                Touch("puts", self.heads[after]),
                Touch("puts", self.tails[after]),
            ]

    def _after(self, number: int) -> int:
        return (number + 1) % self._size
