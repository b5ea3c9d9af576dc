"""Names of a system model on its flattened net, for formulas and goals."""

from __future__ import annotations

from collections.abc import Iterable

from dineros.analysis.logic.language.names import TableNames
from dineros.analysis.nets.compiled import CompiledNet
from dineros.metamodel import pn, sym
from dineros.transformations.flattening.traces import Link


class ModelNames(TableNames):
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
        places: dict[str, list[int]] = {}
        transitions: dict[str, list[int]] = {}
        signals: dict[str, int] = {}
        place_index = {name: index for index, name in enumerate(net.places)}
        transition_index = {name: index for index, name in enumerate(net.transitions)}
        for link in links:
            if isinstance(link.target, pn.Place):
                _add(places, link, place_index[link.target.id])
                if link.meaning is not None and link.meaning.value:
                    _add_signal(signals, link, place_index[link.target.id])
            elif isinstance(link.target, pn.Transition):
                _add(transitions, link, transition_index[link.target.id])
        super().__init__(places, transitions, signals, "input signal in use")


def _add_signal(signals: dict[str, int], link: Link, place: int) -> None:
    (signal,) = link.sources
    assert isinstance(signal, sym.InputSignal)
    signals[signal.id] = place
    if signal.name:
        signals.setdefault(signal.name, place)


def _add(known: dict[str, list[int]], link: Link, index: int) -> None:
    names = {link.target.id: None}
    if link.role in ("place", "transition"):  # kept as it was, or replicated with its server page
        original = link.sources[0]
        assert isinstance(original, pn.Element)
        names[original.id] = None
    for name in names:
        known.setdefault(name, []).append(index)
