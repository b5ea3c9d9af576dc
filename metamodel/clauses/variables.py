"""Literals of clauses as numbers for a SAT solver, which has to know that a signal has one value."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import combinations
from typing import Generic, TypeVar

from dineros.metamodel.clauses.expressions import SignalSetting

Key = TypeVar("Key")


class LiteralVariables(Generic[Key]):
    """Numbers, from 1, of the statements that literals make about signals.

    Parameters
    ----------
    values : callable
        Returns the names of all values of a signal.
    """

    def __init__(self, values: Callable[[Key], Iterable[str]]) -> None:
        self._values = values
        self._numbers: dict[tuple[Key, str | None], int] = {}

    def __len__(self) -> int:
        return len(self._numbers)

    def number(self, signal: Key, value: str | None, negated: bool) -> int:
        """Return a literal: the number of a variable, with a minus sign if it is negated."""
        if (signal, value) not in self._numbers:
            for each in [None] if value is None else dict.fromkeys([value, *self._values(signal)]):
                self._numbers[signal, each] = len(self._numbers) + 1
        number = self._numbers[signal, value]
        return -number if negated else number

    def rules(self) -> Iterator[list[int]]:
        """Yield the clauses that say: each signal with values has exactly one of them."""
        of: dict[Key, list[int]] = {}
        for (signal, value), number in self._numbers.items():
            if value is not None:
                of.setdefault(signal, []).append(number)
        for numbers in of.values():
            yield numbers
            for one, other in combinations(numbers, 2):
                yield [-one, -other]

    def near(self, settings: Mapping[Key, SignalSetting]) -> list[int]:
        """Return the literals that hold under settings of the signals."""
        return [
            number if settings[signal] == (True if value is None else value) else -number
            for (signal, value), number in self._numbers.items()
        ]

    def chosen(self, model: Iterable[int]) -> dict[Key, SignalSetting]:
        """Return what each signal is in a model that a solver found; what is not in it is left out."""
        signs = {abs(number): number > 0 for number in model}
        found: dict[Key, SignalSetting] = {}
        for (signal, value), number in self._numbers.items():
            if number in signs and (value is None or signs[number]):
                found[signal] = signs[number] if value is None else value
        return found
