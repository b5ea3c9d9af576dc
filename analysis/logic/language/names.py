"""The elements that names in formulas refer to; the caller decides, since it knows the model of a net."""

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
        """Return the places whose tokens are added for the name; a place that occurs twice counts twice."""

    def transitions(self, name: str) -> Sequence[int]:
        """Return the transitions with the name; any of them is meant."""

    def signal(self, name: str) -> int:
        """Return the place that is marked exactly while the input signal is true."""


class TableNames:
    """Names given by tables.

    Parameters
    ----------
    places, transitions : mapping of str to sequence of int
        By name.
    signals : mapping of str to int
        For each name, the place that is marked while the signal is true.
    signal : str
        Name of signals in errors.
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
        """Return the places whose tokens are added for the name."""
        return look_up(self._places, "place", name)

    def transitions(self, name: str) -> Sequence[int]:
        """Return the transitions with the name; any of them is meant."""
        return look_up(self._transitions, "transition", name)

    def signal(self, name: str) -> int:
        """Return the place that is marked exactly while the input signal is true."""
        return look_up(self._signals, self._signal, name)


class NetNames(TableNames):
    """Names of a place/transition net, unchanged. A signal is a place that may hold one token.

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
    """Names of a net for a derived net, in which places were removed and transitions were split.

    Attributes
    ----------
    original : Names
        Names of the net.
    place : mapping of int to int
        For each place of the net, the place that represents it; removed places have none.
    images : mapping of int to sequence of int
        For each transition of the net, those that fire it.
    """

    original: Names
    place: Mapping[int, int]
    images: Mapping[int, Sequence[int]]

    def places(self, name: str) -> Sequence[int]:
        """Return the places that represent those with the name."""
        return [self._there(place, name) for place in self.original.places(name)]

    def transitions(self, name: str) -> Sequence[int]:
        """Return the transitions that fire those with the name."""
        return [image for t in self.original.transitions(name) for image in self.images.get(t, ())]

    def signal(self, name: str) -> int:
        """Return the place that represents the signal."""
        return self._there(self.original.signal(name), name)

    def _there(self, place: int, name: str) -> int:
        if place not in self.place:
            raise FormulaError(f"the place of {name!r} is left out")
        return self.place[place]


def look_up(known: Mapping[str, Found], kind: str, name: str) -> Found:
    """Return the elements with a name; raises `FormulaError` for an unknown one."""
    if name not in known:
        raise FormulaError(f"no {kind} is named {name!r}", hint=near_matches(name, known))
    return known[name]


def resolved(resolve: Callable[[str], Found], name: Name) -> Found:
    """Return the elements with a name in a formula; an error gets its column."""
    try:
        return resolve(name.text)
    except FormulaError as error:
        raise error.at(name.column or None) from None
