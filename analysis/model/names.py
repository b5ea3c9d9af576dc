"""Names of a model on its net, for formulas, goals and answers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.logic.language.names import TableNames
from dineros.analysis.model.wording import signal_setting, source_of
from dineros.analysis.nets.compiled import CompiledNet
from dineros.metamodel import pn, sym
from dineros.metamodel.colours.origins import origins_of
from dineros.metamodel.elements import nodes

if TYPE_CHECKING:
    from dineros.transformations.flattening.traces import Link


def unique_names(net: pn.Net) -> dict[str, str]:
    """Return by id the names of places and transitions that no other node has as its name or id."""
    named = [node for node in nodes(net) if isinstance(node, (pn.Place, pn.Transition))]
    ids = {str(node.id) for node in named}
    counts = Counter(node.name for node in named if node.name)
    return {
        str(node.id): node.name
        for node in named
        if node.name and counts[node.name] == 1 and (node.name == node.id or node.name not in ids)
    }


class PlainNames(TableNames):
    """Names of a plain net: ids, and the names of its elements where they are unique.

    Tools that draw nets make ids of their own (``cId-77384``), and people know the names. In a net that was
    unfolded, the id of a coloured place means the sum over its colours, that of a coloured transition any of
    its bindings.

    `model`: the model that it was compiled from.
    """

    def __init__(self, net: CompiledNet, model: pn.Net) -> None:
        by_name = {name: id for id, name in unique_names(model).items()}
        tables: list[dict[str, tuple[int, ...]]] = [
            {id: (index,) for index, id in enumerate(ids)} for ids in (net.places, net.transitions)
        ]
        for table in tables:
            table.update({name: table[id] for name, id in by_name.items() if id in table})
        places, transitions = tables
        signals = {name: index for name, (index,) in places.items()}
        origins = origins_of(model)
        for table, coloured in ((places, origins.places), (transitions, origins.transitions)):
            table.update(
                {id: tuple(table[one][0] for one in unfolded) for id, unfolded in coloured.items()}
            )  # an id goes before the name of another element
        super().__init__(places, transitions, signals)
        self._shared: dict[type[pn.Element], dict[str, list[str]]] = {pn.Place: {}, pn.Transition: {}}
        for node in nodes(model):
            for kind, shared in self._shared.items():
                if isinstance(node, kind) and node.name:
                    shared.setdefault(node.name, []).append(str(node.id))

    def places(self, name: str) -> Sequence[int]:
        """Return the place of an id or of a unique name."""
        self._refuse_shared(pn.Place, self._places, name)
        return super().places(name)

    def transitions(self, name: str) -> Sequence[int]:
        """Return the transition of an id or of a unique name."""
        self._refuse_shared(pn.Transition, self._transitions, name)
        return super().transitions(name)

    def _refuse_shared(self, kind: type[pn.Element], known: Mapping[str, Sequence[int]], name: str) -> None:
        ids = self._shared[kind].get(name, ())
        if name not in known and ids:
            what = f"{kind.__name__.lower()}s"
            raise FormulaError(
                f"{len(ids)} {what} are named {name!r}" if len(ids) > 1 else f"{name!r} is not a unique name",
                hint=f"give the id: {', '.join(ids[:5])}",
            )


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
    signal, setting = source_of(link, sym.InputSignal), signal_setting(link)
    of_value = "" if setting is True else f".{setting}"
    signals[f"{signal.id}{of_value}"] = place
    if signal.name:
        signals.setdefault(f"{signal.name}{of_value}", place)


def _add(known: dict[str, list[int]], link: Link, index: int) -> None:
    names = {link.target.id: None}
    if link.role in ("place", "transition"):  # kept as it was, or replicated with its server page
        original = link.sources[0]
        assert isinstance(original, pn.Element)
        names[original.id] = None
    for name in names:
        known.setdefault(name, []).append(index)
