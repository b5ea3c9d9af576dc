"""Names of a system model on its flattened net, for formulas and goals."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeVar

from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.nets.compiled import CompiledNet
from dineros.metamodel import pn, sym
from dineros.metamodel.errors import near_matches
from dineros.transformations.flattening.traces import Link

V = TypeVar("V")


class ModelNames:
    """Names of a system model on its flattened net.

    A replicated element's name means the sum over its instances (places) or any of them (transitions);
    ``Pick[2].PickRun`` is that of server instance 2. Names of made elements are known as well.

    Parameters
    ----------
    net : CompiledNet
        The flattened net.
    links : iterable of Link
        How its elements were made.
    """

    def __init__(self, net: CompiledNet, links: Iterable[Link]) -> None:
        self._places: dict[str, list[int]] = {}
        self._transitions: dict[str, list[int]] = {}
        self._signals: dict[str, int] = {}
        place_index = {name: index for index, name in enumerate(net.places)}
        transition_index = {name: index for index, name in enumerate(net.transitions)}
        for link in links:
            if isinstance(link.target, pn.Place):
                _add(self._places, link, place_index[link.target.id])
                if link.meaning is not None and link.meaning.value:
                    self._add_signal(link, place_index[link.target.id])
            elif isinstance(link.target, pn.Transition):
                _add(self._transitions, link, transition_index[link.target.id])

    def _add_signal(self, link: Link, place: int) -> None:
        (signal,) = link.sources
        assert isinstance(signal, sym.InputSignal)
        self._signals[signal.id] = place
        if signal.name:
            self._signals.setdefault(signal.name, place)

    def places(self, name: str) -> Sequence[int]:
        """Return the places whose tokens are added up for the name."""
        return _look_up(self._places, "place", name)

    def transitions(self, name: str) -> Sequence[int]:
        """Return the transitions that the name stands for, any of them."""
        return _look_up(self._transitions, "transition", name)

    def signal(self, name: str) -> int:
        """Return the place that is marked exactly while the input signal is true."""
        return _look_up(self._signals, "input signal in use", name)


def _add(known: dict[str, list[int]], link: Link, index: int) -> None:
    names = {link.target.id: None}
    if link.role in ("place", "transition"):  # kept as it was, or replicated with its server page
        original = link.sources[0]
        assert isinstance(original, pn.Element)
        names[original.id] = None
    for name in names:
        known.setdefault(name, []).append(index)


def _look_up(known: dict[str, V], kind: str, name: str) -> V:
    if name not in known:
        raise FormulaError(f"no {kind} is named {name!r}", hint=near_matches(name, known))
    return known[name]
