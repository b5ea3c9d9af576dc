"""What names in formulas stand for; the caller decides, since it knows the model behind a net."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.logic.language.syntax import Name
from dineros.analysis.nets.compiled import CompiledNet
from dineros.metamodel.errors import near_matches

Found = TypeVar("Found")


class Names(Protocol):
    """Resolves names to indices of a compiled net. Each method raises `FormulaError` for an unknown name."""

    def places(self, name: str) -> Sequence[int]:
        """Return the places whose tokens are added up for the name; one that occurs twice counts twice."""

    def transitions(self, name: str) -> Sequence[int]:
        """Return the transitions that the name stands for, any of them."""

    def signal(self, name: str) -> int:
        """Return the place that is marked exactly while the input signal is true."""


class TableNames:
    """Names that stand in tables.

    Parameters
    ----------
    places, transitions : mapping of str to sequence of int
        By name.
    signals : mapping of str to int
        By name, the place that is marked while it is true.
    signal : str
        What errors call one.
    """

    def __init__(
        self,
        places: Mapping[str, Sequence[int]],
        transitions: Mapping[str, Sequence[int]],
        signals: Mapping[str, int],
        signal: str = "signal",
    ) -> None:
        self._places, self._transitions, self._signals = places, transitions, signals
        self._signal = signal

    def places(self, name: str) -> Sequence[int]:
        """Return the places whose tokens are added up for the name."""
        return look_up(self._places, "place", name)

    def transitions(self, name: str) -> Sequence[int]:
        """Return the transitions that the name stands for, any of them."""
        return look_up(self._transitions, "transition", name)

    def signal(self, name: str) -> int:
        """Return the place that is marked exactly while the input signal is true."""
        return look_up(self._signals, self._signal, name)


class NetNames(TableNames):
    """Names of a place/transition net, each exactly itself. A signal is a place that may hold one token.

    Parameters
    ----------
    net : CompiledNet
    """

    def __init__(self, net: CompiledNet) -> None:
        places, transitions = (
            {name: (index,) for index, name in enumerate(names)} for names in (net.places, net.transitions)
        )
        super().__init__(places, transitions, {name: index for name, (index,) in places.items()})


@dataclass(frozen=True)
class LimitedNames:
    """Names of a net on one in which places left, and transitions became several.

    Attributes
    ----------
    original : Names
        Names of the net.
    place : mapping of int to int
        By place of the net: the one that stands for it; places that left have none.
    images : mapping of int to sequence of int
        By transition of the net: those that fire it.
    """

    original: Names
    place: Mapping[int, int]
    images: Mapping[int, Sequence[int]]

    def places(self, name: str) -> Sequence[int]:
        """Return the places that stand for those of the name."""
        return [self._there(place, name) for place in self.original.places(name)]

    def transitions(self, name: str) -> Sequence[int]:
        """Return the transitions that fire those of the name."""
        return [image for t in self.original.transitions(name) for image in self.images.get(t, ())]

    def signal(self, name: str) -> int:
        """Return the place that stands for the signal."""
        return self._there(self.original.signal(name), name)

    def _there(self, place: int, name: str) -> int:
        if place not in self.place:
            raise FormulaError(f"the place of {name!r} is left out")
        return self.place[place]


def look_up(known: Mapping[str, Found], kind: str, name: str) -> Found:
    """Return what a name stands for; `FormulaError` where it is unknown."""
    if name not in known:
        raise FormulaError(f"no {kind} is named {name!r}", hint=near_matches(name, known))
    return known[name]


def resolved(resolve: Callable[[str], Found], name: Name) -> Found:
    """Return what a name in a formula stands for; an error gets its column."""
    try:
        return resolve(name.text)
    except FormulaError as error:
        raise error.at(name.column or None) from None
