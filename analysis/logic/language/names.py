"""What names in formulas stand for; the caller decides, since it knows the model behind a net."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.nets.compiled import CompiledNet
from dineros.metamodel.errors import near_matches


class Names(Protocol):
    """Resolves names to indices of a compiled net. Each method raises `FormulaError` for an unknown name."""

    def places(self, name: str) -> Sequence[int]:
        """Return the places whose tokens are added up for the name; one that occurs twice counts twice."""

    def transitions(self, name: str) -> Sequence[int]:
        """Return the transitions that the name stands for, any of them."""

    def signal(self, name: str) -> int:
        """Return the place that is marked exactly while the input signal is true."""


class NetNames:
    """Names of a place/transition net, each exactly itself. A signal is a place that may hold one token.

    Parameters
    ----------
    net : CompiledNet
    """

    def __init__(self, net: CompiledNet) -> None:
        self._places = {name: index for index, name in enumerate(net.places)}
        self._transitions = {name: index for index, name in enumerate(net.transitions)}

    def places(self, name: str) -> Sequence[int]:
        """Return the one place of this name."""
        return [_look_up(self._places, "place", name)]

    def transitions(self, name: str) -> Sequence[int]:
        """Return the one transition of this name."""
        return [_look_up(self._transitions, "transition", name)]

    def signal(self, name: str) -> int:
        """Return the place of this name."""
        return _look_up(self._places, "signal", name)


def _look_up(known: dict[str, int], kind: str, name: str) -> int:
    if name not in known:
        raise FormulaError(f"no {kind} is named {name!r}", hint=near_matches(name, known))
    return known[name]
