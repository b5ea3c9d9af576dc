"""Guards on a flattened net: tokens of a place are told apart where a guard does (unfolding).

It runs after all rules. A place keeps its tokens, its capacity and its arcs. Beside it there is a place for
each colour that guards tell apart; these have as many tokens as the place (a place invariant says so). A
transition that takes, puts or reads such tokens becomes one transition for each choice of colours. So limits
of queues, locks and slots stay shared by all colours (unfolding of coloured nets: Jensen, Coloured Petri
Nets 1, 1992, Sect. 2.4).

Data does not travel through channels here: a token that a rule's transition puts has any value of its range.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from itertools import islice
from typing import NamedTuple

from dineros.metamodel import pn, pnm, sym
from dineros.metamodel.elements import elements, nodes, places, transitions
from dineros.metamodel.errors import GuardError
from dineros.metamodel.guards.colours import Colour, Moves, Palette, Step, Variant, palettes, variants
from dineros.metamodel.guards.reading import read_assignments, read_guard
from dineros.metamodel.token_data import FieldType, read_data
from dineros.metamodel.token_types.declared import token_type_of, type_of_place
from dineros.transformations.flattening.bounding import fresh
from dineros.transformations.flattening.traces import Link, Trace

RULE = "Guard"
"""Name in the trace of what guards add."""

MOST_VARIANTS = 20_000
"""Most transitions that guards may make of those of one net."""


class _Arcs(NamedTuple):
    """The arcs between a transition of the net and places of the net."""

    takes: Counter[pn.Place]
    reads: Counter[pn.Place]
    puts: Counter[pn.Place]


def unfold_guards(model: sym.SystemModel, net: pnm.PetriNetModel, trace: Trace) -> Trace:
    """Let the guards of a model decide in its flattened net; return the trace with what is added.

    Parameters
    ----------
    model : sym.SystemModel
        The model.
    net : pnm.PetriNetModel
        Its flattened net, which is changed.
    trace : Trace
        How it was made.

    Raises
    ------
    GuardError
        A guard or an assignment cannot be read, or too many transitions are needed.
    """
    return _Unfolding(model, net, trace).run()


class _Unfolding:
    def __init__(self, model: sym.SystemModel, net: pnm.PetriNetModel, trace: Trace) -> None:
        self._model, self._net = model, net
        (self._page,) = net.pages
        self._links = {link.target: link for link in trace}
        self._taken = {net.id, *(element.id for element in elements(net))}
        self._number = 1 + max((link.application for link in trace), default=0)
        self._fields_of: dict[pn.Place, dict[str, FieldType]] = {}
        self._original: dict[pn.Node, pn.Place] = {}
        for node in nodes(net):
            link = self._links[node]
            if link.role == "place" and link.maker is None and isinstance(link.sources[0], pn.Place):
                self._original[node] = link.sources[0]
        self._arcs_of: dict[pn.Transition, list[pn.Arc]] = {each: [] for each in transitions(net)}
        for arc in self._page.arcs:
            end = arc.source if isinstance(arc.source, pn.Transition) else arc.target
            assert isinstance(end, pn.Transition)
            self._arcs_of[end].append(arc)
        self._coloured: dict[tuple[pn.Place, Colour], pn.Place] = {}

    def run(self) -> Trace:
        arcs = {transition: self._arcs(transition) for transition in self._arcs_of}
        steps = self._steps(arcs)
        known = palettes(steps, self._fields)
        for place in places(self._net):
            if self._original.get(place) in known:
                self._add_colours(place, known[self._original[place]])
        copies: dict[pn.Transition, list[pn.Transition]] = {}
        for transition, own in arcs.items():
            step = steps.get(self._origin(transition))  # type: ignore[arg-type]
            copies[transition] = self._split(transition, own, step, known)
            if sum(map(len, copies.values())) - len(copies) > MOST_VARIANTS:
                raise GuardError(
                    f"guards make more than {MOST_VARIANTS} transitions",
                    element=self._id(transition),
                    hint="ask about fewer fields, or let transitions take fewer tokens",
                )
        for transition, higher in copies.items():
            for lower in list(transition.overrides):
                for each in higher:
                    each.overrides.extend(copies[lower][1:])
        return Trace(self._links.values())

    def _steps(self, arcs: Mapping[pn.Transition, _Arcs]) -> dict[sym.Transition, Step]:
        """Return what each transition of the model asks and assigns."""
        steps: dict[sym.Transition, Step] = {}
        for transition, own in arcs.items():
            origin = self._origin(transition)
            if origin is None or origin in steps or not (origin.guard or origin.assigns):
                continue
            seen = self._model_places(own.takes + own.reads)
            puts = self._model_places(own.puts)
            try:
                guard = read_guard(origin.guard, seen, self._fields) if origin.guard else {}
                assigned = (
                    read_assignments(origin.assigns, seen, puts, self._fields) if origin.assigns else {}
                )
            except GuardError as error:
                error.element = origin.id
                raise
            steps[origin] = Step(guard, assigned)
        return steps

    def _origin(self, transition: pn.Transition) -> sym.Transition | None:
        """Return the transition of the model that one of the net is; None: a rule made it."""
        link = self._links[transition]
        if link.maker is None and link.sources and isinstance(link.sources[0], sym.Transition):
            return link.sources[0]
        return None

    def _model_places(self, counts: Counter[pn.Place]) -> Counter[pn.Place]:
        found: Counter[pn.Place] = Counter()
        for place, count in counts.items():
            if place in self._original:
                found[self._original[place]] += count
        return found

    def _fields(self, place: pn.Place) -> Mapping[str, FieldType]:
        if place not in self._fields_of:
            declared = token_type_of(type_of_place(place, self._model))
            self._fields_of[place] = {field.name: field for field in declared.fields}
        return self._fields_of[place]

    def _arcs(self, transition: pn.Transition) -> _Arcs:
        found = _Arcs(Counter(), Counter(), Counter())
        for arc in self._arcs_of[transition]:
            if isinstance(arc.target, pn.Place):
                found.puts[arc.target] += arc.weight
            elif isinstance(arc.source, pn.Place) and arc.kind != pn.ArcKind.inhibitor:
                (found.reads if arc.kind == pn.ArcKind.read else found.takes)[arc.source] += arc.weight
        return found

    # ------------------------------------------------------------------------------------------- making

    def _add_colours(self, place: pn.Place, palette: Palette) -> None:
        """Add a place for each colour, with the tokens that have it at the start."""
        fields = self._fields(self._original[place])
        default = {name: field.default for name, field in fields.items()}
        original = self._original[place]
        balloons = list(original.balloons) if isinstance(original, sym.Place) else []
        data = [default | read_data(each.data or "{}", fields) for each in balloons]
        data += [default] * (place.tokens - len(data))
        start = Counter(palette.colour_of(each) for each in data[: place.tokens])
        terms = [pnm.InvariantTerm(place=place, weight=1)]
        for colour in palette.colours:
            id = fresh(f"{place.id}[{_joined(palette.text(colour))}]", self._taken)
            made = pn.Place(id=id, tokens=start[colour], page=self._page)
            self._coloured[place, colour] = made
            self._link(made, "colour", place)
            terms.append(pnm.InvariantTerm(place=made, weight=-1))
        self._net.certificate.append(
            pnm.PlaceInvariant(name=f"{place.id} is the sum of its colours", value=0, terms=terms)
        )

    def _split(
        self, transition: pn.Transition, own: _Arcs, step: Step | None, known: Mapping[pn.Place, Palette]
    ) -> list[pn.Transition]:
        """Make of a transition one for each choice of colours; the first of them is the transition itself."""

        def coloured(counts: Counter[pn.Place]) -> dict[pn.Place, int]:
            return {place: n for place, n in counts.items() if self._original.get(place) in known}

        moves = [coloured(counts) for counts in own]
        if not any(moves):
            return [transition]
        on_net = {self._original[place]: place for each in moves for place in each}
        ways = variants(
            step,
            Moves(*({self._original[place]: n for place, n in each.items()} for each in moves)),
            known,
        )
        chosen = list(islice(ways, MOST_VARIANTS + 1))
        assert chosen, "a guard that no token can fulfil is refused"
        made = [transition, *(self._copy(transition) for _ in chosen[1:])]
        own_id = transition.id
        for each, way in zip(made, chosen, strict=True):
            self._join(each, way, on_net)
            if len(chosen) > 1:
                values = self._text(way, known)
                each.id = fresh(f"{own_id}[{_joined(values)}]", self._taken)
                self._links[each] = replace(self._links[each], values=values)
        return made

    def _text(self, way: Variant, known: Mapping[pn.Place, Palette]) -> str:
        """Return the colours of a variant in words, by place."""
        words = dict.fromkeys(
            f"{place.id}: {known[place].text(colour)}"
            for each in way
            for place, colours in each.items()
            for colour in colours
        )
        return "; ".join(words)

    def _join(self, transition: pn.Transition, way: Variant, on_net: Mapping[pn.Place, pn.Place]) -> None:
        """Add the arcs between a transition and the colours that it takes, reads and puts."""
        for kind, each in zip(("takes", "reads", "puts"), way, strict=True):
            for original, colours in each.items():
                for colour, weight in Counter(colours).items():
                    place = self._coloured[on_net[original], colour]
                    source, target = (transition, place) if kind == "puts" else (place, transition)
                    id = fresh(f"{source.id}-{target.id}", self._taken)
                    arc = pn.Arc(id=id, weight=weight, kind="read" if kind == "reads" else "normal")
                    arc.source, arc.target, arc.page = source, target, self._page
                    self._link(arc, "arc", on_net[original])

    def _link(self, made: pn.Element, role: str, place: pn.Place) -> None:
        """Record that guards added an element for a place of the net."""
        index = self._links[place].index
        self._links[made] = Link(RULE, role, self._number, (self._original[place],), index, made)
        self._number += 1

    def _id(self, transition: pn.Transition) -> str:
        origin = self._origin(transition)
        return transition.id if origin is None else origin.id

    def _copy(self, transition: pn.Transition) -> pn.Transition:
        link = self._links[transition]
        made = pn.Transition(id=fresh(transition.id, self._taken), name=transition.name, page=self._page)
        made.overrides.extend(transition.overrides)
        self._links[made] = replace(link, target=made)
        for arc in self._arcs_of[transition]:
            joint = pn.Arc(id=fresh(arc.id, self._taken), weight=arc.weight, kind=arc.kind, page=self._page)
            joint.source = made if arc.source is transition else arc.source
            joint.target = made if arc.target is transition else arc.target
            self._links[joint] = replace(self._links[arc], target=joint)
        return made


def _joined(words: str) -> str:
    """Return words as a part of an id, which has no blanks."""
    return words.replace(" ", "")
