"""Places and transition variants that guards add to a flattened net, with their descriptions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import NamedTuple

from dineros.metamodel import pn, pnm
from dineros.metamodel.elements import elements, fresh_id
from dineros.metamodel.guards.colours import Colour, Moves, Palette, Step, Variant
from dineros.metamodel.times.intervals import copied_interval
from dineros.transformations.flattening.rings import Ring, Touch
from dineros.transformations.flattening.traces import Link

RULE = "Guard"
"""Rule name in the trace for elements that guards add."""


MOST_CELLS = 128
"""Maximum number of cells of a queue whose order is kept: one for each message and colour."""


class Way(NamedTuple):
    """One way in which a transition of the net moves tokens with colours."""

    step: Step | None
    """Guard and assignments of the transition of the model."""
    moves: Moves
    """The moved tokens."""
    lost: pn.Place | None = None
    """The place of the net that loses a message to another message."""


class Chosen(NamedTuple):
    """A variant of a transition, with the way of which it is a variant."""

    way: Way
    variant: Variant


class ColouredNet:
    """Adds places for colours and variants of transitions to a flattened net.

    Parameters
    ----------
    net : pnm.PetriNetModel
        The net; it is changed.
    links : dict of model object to Link
        The links of its elements; added elements get links, too.
    originals : mapping of pn.Node to pn.Place
        For each place of the net, its place in the model.
    known : mapping of pn.Place to Palette
        The colours that guards distinguish.
    arcs : mapping of pn.Transition to sequence of pn.Arc
        The arcs of each transition without regard to guards.
    """

    def __init__(
        self,
        net: pnm.PetriNetModel,
        links: dict[pn.Element, Link],
        originals: Mapping[pn.Node, pn.Place],
        known: Mapping[pn.Place, Palette],
        arcs: Mapping[pn.Transition, Sequence[pn.Arc]],
    ) -> None:
        self._net, self._links, self._arcs_of = net, links, arcs
        self._original, self._known = originals, known
        (self._page,) = net.pages
        self._taken = {net.id, *(element.id for element in elements(net))}
        self._number = 1 + max((link.application for link in links.values()), default=0)
        self._coloured: dict[tuple[pn.Place, Colour], pn.Place] = {}
        self._rings: dict[pn.Place, Ring] = {}

    def add_colours(
        self, place: pn.Place, colours: Sequence[Colour], start: Counter[Colour], limit: int
    ) -> None:
        """Add a place for each colour, or the cells of a queue.

        Parameters
        ----------
        place : pn.Place
            The place of tokens of all colours.
        start : Counter of Colour
            Number of initial tokens of each colour.
        limit : int
            Maximum number of messages if it is a queue whose order matters, else 1.
        """
        palette = self._known[place]

        def make(part: str, tokens: int) -> pn.Place:
            made = pn.Place(
                id=fresh_id(f"{place.id}[{_joined(part)}]", self._taken), tokens=tokens, page=self._page
            )
            self._link(made, "colour", place)
            return made

        if limit > 1 and len(colours) > 1 and limit * len(colours) <= MOST_CELLS:
            ring = self._rings[place] = Ring(place, limit, colours, make, palette.text)
            parts = list(ring.cells.values())
            for name, choice in (("oldest", ring.heads), ("next", ring.tails)):
                self._certify(f"{place.id}: one {name} cell", 1, dict.fromkeys(choice, 1))
        else:
            for colour in colours:
                self._coloured[place, colour] = make(palette.text(colour), start[colour])
            parts = [self._coloured[place, colour] for colour in colours]
        self._certify(f"{place.id} is the sum of its colours", 0, {place: 1} | dict.fromkeys(parts, -1))

    def _certify(self, name: str, value: int, weights: Mapping[pn.Place, int]) -> None:
        terms = [pnm.InvariantTerm(place=place, weight=weight) for place, weight in weights.items()]
        self._net.certificate.append(pnm.PlaceInvariant(name=name, value=value, terms=terms))

    def split(self, transition: pn.Transition, chosen: Sequence[Chosen]) -> list[pn.Transition]:
        """Split a transition into one for each choice of colours; the first one is the transition itself."""
        if not chosen:
            return [transition]
        placed = [(each, touches) for each in chosen for touches in self._touches(each.variant)]
        made = [transition, *(self._copy(transition) for _ in placed[1:])]
        own_id = transition.id
        for each, ((way, variant), touches) in zip(made, placed, strict=True):
            for touch in touches:
                self._join(each, touch)
            if len(placed) > 1:
                values = self._text(way, variant, self._links[transition].maker is not None)
                each.id = fresh_id(f"{own_id}[{_joined(values)}]", self._taken)
                self._links[each] = replace(self._links[each], values=values)
        return made

    def _touches(self, variant: Variant) -> Iterator[list[Touch]]:
        """Yield the possible arcs for a variant's tokens: tokens of a queue may be in any of its cells."""
        plain = [
            Touch(kind, self._coloured[place, colour], weight)
            for kind, each in variant._asdict().items()
            for place, colours in each.items()
            if place not in self._rings
            for colour, weight in Counter(colours).items()
        ]
        queues = dict.fromkeys(place for each in variant for place in each if place in self._rings)
        in_cells = [
            self._rings[place].ways(variant.takes.get(place, ()), variant.puts.get(place, ()))
            for place in queues
        ]
        for choice in product(*in_cells):
            yield [*plain, *(touch for each in choice for touch in each)]

    def _text(self, way: Way, variant: Variant, is_rules: bool) -> str:
        """Describe the colours of a variant: by place, or of the message that a rule passes on."""
        if way.lost is not None and way.lost in variant.takes:
            return self._lost_text(way.lost, variant)
        shown = [variant.takes or variant.puts] if is_rules else variant
        words = dict.fromkeys(
            self._known[place].text(colour) if is_rules else self._colour_text(place, colour)
            for each in shown
            for place, colours in each.items()
            for colour in colours
        )
        return "; ".join(words)

    def _lost_text(self, place: pn.Place, variant: Variant) -> str:
        palette = self._known[place]
        lost, new = (palette.text(each[place][0]) for each in (variant.takes, variant.puts))
        return lost if lost == new else f"{lost}; keeps {new}"

    def _colour_text(self, place: pn.Place, colour: Colour) -> str:
        text = self._known[place].text(colour)
        return f"{self._original[place].id}: {text}" if place in self._original else text

    def _join(self, transition: pn.Transition, touch: Touch) -> None:
        """Add an arc between a transition and the place of a colour."""
        kind, place, weight = touch
        source, target = (transition, place) if kind == "puts" else (place, transition)
        id = fresh_id(f"{source.id}-{target.id}", self._taken)
        arc = pn.Arc(id=id, weight=weight, kind="read" if kind == "reads" else "normal")
        arc.source, arc.target, arc.page = source, target, self._page
        self._link(arc, "arc", place)

    def _link(self, made: pn.Element, role: str, place: pn.Place) -> None:
        """Record that guards added an element for a place of the net."""
        link = self._links[place]
        self._links[made] = Link(RULE, role, self._number, link.sources, link.index, made, link.client_index)
        self._number += 1

    def _copy(self, transition: pn.Transition) -> pn.Transition:
        link = self._links[transition]
        id, interval = fresh_id(transition.id, self._taken), copied_interval(transition.interval)
        made = pn.Transition(id=id, name=transition.name, interval=interval, page=self._page)
        made.overrides.extend(transition.overrides)
        self._links[made] = replace(link, target=made)
        for arc in self._arcs_of[transition]:
            joint = pn.Arc(
                id=fresh_id(arc.id, self._taken), weight=arc.weight, kind=arc.kind, page=self._page
            )
            joint.source = made if arc.source is transition else arc.source
            joint.target = made if arc.target is transition else arc.target
            self._links[joint] = replace(self._links[arc], target=joint)
        return made


def _joined(words: str) -> str:
    """Return words as a part of an id, without blanks."""
    return words.replace(" ", "")
