"""The plain net of an unfolded symmetric net, as a model."""

from __future__ import annotations

from collections.abc import Mapping

from lxml import etree

from dineros.metamodel import pn
from dineros.metamodel.colours.origins import Origins, remember_origins
from dineros.metamodel.colours.sorts import DOT, Sort
from dineros.metamodel.colours.unfolding import ColouredPlace, ColouredTransition, Unfolding
from dineros.metamodel.files.pnml.source import Source, child, text_of
from dineros.metamodel.positions import remember


def build_net(
    net: etree._Element,
    places: list[ColouredPlace],
    transitions: list[ColouredTransition],
    nodes: Mapping[str, etree._Element],
    unfolding: Unfolding,
    source: Source,
) -> pn.Net:
    """Make the plain net, and keep with it which colours its places have.

    ``Fork`` with the colour 3 becomes ``Fork(3)``, a transition ``Take`` with x = 3 and y = 4 becomes
    ``Take(3,4)``. A place with one colour only, the dot, keeps its id.
    """
    ids = _Ids()
    model = pn.Net(id=ids(source.attribute(net, "id")))
    page = pn.Page(id=ids("page"))
    made: dict[tuple[int, int], pn.Place] = {}
    found_places: dict[str, tuple[str, ...]] = {}
    for index, place in enumerate(places):
        xml = nodes[place.id]
        for value in sorted(unfolding.colours[index]):
            colour = _colour(place.sort, value)
            one = pn.Place(id=ids(place.id + colour), tokens=place.marking.get(value, 0))
            one.name = _name(xml, colour, str(one.id))
            remember(one, source.location(xml))
            made[index, value] = one
        found_places[place.id] = tuple(
            str(made[index, value].id) for value in sorted(unfolding.colours[index])
        )
    sorts = [transition.variables() for transition in transitions]
    firings: list[pn.Transition] = []
    arcs: list[pn.Arc] = []
    found: dict[str, list[str]] = {transition.id: [] for transition in transitions}
    for firing in sorted(unfolding.firings, key=lambda each: (each.transition, tuple(each.binding.values()))):
        transition = transitions[firing.transition]
        xml = nodes[transition.id]
        values = [sorts[firing.transition][name].sort.label(value) for name, value in firing.binding.items()]
        colour = f"({','.join(values)})" if values else ""
        fired = pn.Transition(id=ids(transition.id + colour))
        fired.name = _name(xml, colour, str(fired.id))
        remember(fired, source.location(xml))
        firings.append(fired)
        found[transition.id].append(str(fired.id))
        for key, weight in firing.takes.items():
            arcs.append(
                pn.Arc(id=ids(f"{made[key].id}-{fired.id}"), source=made[key], target=fired, weight=weight)
            )
        for key, weight in firing.puts.items():
            arcs.append(
                pn.Arc(id=ids(f"{fired.id}-{made[key].id}"), source=fired, target=made[key], weight=weight)
            )
    page.objects.extend([*made.values(), *firings])
    page.arcs.extend(arcs)
    model.pages.append(page)
    remember_origins(model, Origins(found_places, {id: tuple(each) for id, each in found.items()}))
    return model


class _Ids:
    """Gives each id once."""

    def __init__(self) -> None:
        self._used: set[str] = set()

    def __call__(self, wanted: str) -> str:
        id, number = wanted, 2
        while id in self._used:
            id, number = f"{wanted}.{number}", number + 1
        self._used.add(id)
        return id


def _colour(sort: Sort, value: int) -> str:
    return "" if sort == DOT else f"({sort.label(value)})"


def _name(xml: etree._Element, colour: str, id: str) -> str | None:
    label = child(xml, "name")
    text = text_of(label) if label is not None else ""
    return f"{text}{colour}" if text and f"{text}{colour}" != id else None
