"""Guards on a flattened net: tokens of a place are told apart where a guard does (unfolding).

It runs after all rules. A place keeps its tokens, its capacity and its arcs. Beside it there is a place for
each colour that guards tell apart; these have as many tokens as the place (a place invariant says so). A
transition that takes, puts or reads such tokens becomes one transition for each choice of colours. So limits
of queues, locks and slots stay shared by all colours (unfolding of coloured nets: Jensen, Coloured Petri
Nets 1, 1992, Sect. 2.4).

What a port sends arrives: rules say which of their places carry data (`dineros.transformations.flattening.
data_flow`). Any other token that a rule's transition puts has any value of its range.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import islice
from typing import NamedTuple

from dineros.metamodel import pn, pnm, sym
from dineros.metamodel.elements import elements, nodes, places, transitions
from dineros.metamodel.errors import GuardError
from dineros.metamodel.guards.colours import (
    Colour,
    Moves,
    Palette,
    Step,
    Variant,
    can_be_handed,
    palettes,
    variants,
)
from dineros.metamodel.guards.reading import Source, read_assignments, read_guard
from dineros.metamodel.token_data import FieldType, read_data
from dineros.metamodel.token_types.declared import token_type_of, type_of_place
from dineros.transformations.flattening.bounding import fresh
from dineros.transformations.flattening.data_flow import Arcs, DataFlow, Flow
from dineros.transformations.flattening.traces import Link, Trace

RULE = "Guard"
"""Name in the trace of what guards add."""

MOST_VARIANTS = 20_000
"""Most transitions that guards may make of those of one net."""


class _Way(NamedTuple):
    """One way in which a transition of the net moves tokens whose colours matter.

    Attributes
    ----------
    step : Step or None
        What it asks and assigns.
    moves : Moves
        Its tokens.
    lost : pn.Place or None
        The place of the net that loses a message in favour of another one.
    """

    step: Step | None
    moves: Moves
    lost: pn.Place | None = None


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
        self._known: dict[pn.Place, Palette] = {}
        for node in nodes(net):
            link = self._links[node]
            if link.role == "place" and link.maker is None and isinstance(link.sources[0], pn.Place):
                assert isinstance(node, pn.Place)
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
        flow = DataFlow(self._model, self._links, self._original, arcs, self._fields)
        known = palettes(steps, flow.fields, flow.copied())
        for place in places(self._net):
            if flow.key(place) in known:
                self._known[place] = known[flow.key(place)]
        for place in self._known:
            self._add_colours(place, flow.fields(flow.key(place)))
        copies: dict[pn.Transition, list[pn.Transition]] = {}
        for transition, own in arcs.items():
            if transition in flow.flows:
                ways = [self._handed(way, flow) for way in flow.flows[transition]]
            else:
                step = steps.get(self._origin(transition))  # type: ignore[arg-type]
                ways = [self._stepping(step, own)]
            copies[transition] = self._split(transition, ways)
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

    def _steps(self, arcs: Mapping[pn.Transition, Arcs]) -> dict[sym.Transition, Step]:
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

    def _stepping(self, step: Step | None, own: Arcs) -> _Way:
        """Return how a transition of the model moves tokens, in places of the net."""
        on_net = {self._original[place]: place for each in own for place in each if place in self._original}
        if step is not None:
            step = Step(
                {on_net[place]: condition for place, condition in step.guard.items()},
                {
                    on_net[place]: {
                        name: (on_net[value[0]], value[1]) if isinstance(value, tuple) else value
                        for name, value in given.items()
                    }
                    for place, given in step.assigned.items()
                },
            )
        return _Way(step, Moves(*map(self._coloured_of, own)))

    def _handed(self, way: Flow, flow: DataFlow) -> _Way:
        """Return how a transition of a rule hands messages on."""
        assigned: dict[pn.Place, dict[str, int | Source]] = {}
        for target, source in way.copies.items():
            if target in self._known and source in self._known:
                before, after = flow.fields(flow.key(source)), flow.fields(flow.key(target))
                assigned[target] = {
                    name: (source, name)
                    for name in self._known[target].fields
                    if can_be_handed(name, before, after)
                }
        moves = Moves(self._coloured_of(way.takes), {}, self._coloured_of(way.puts))
        return _Way(Step({}, assigned), moves, way.lost)

    def _coloured_of(self, counts: Counter[pn.Place]) -> dict[pn.Place, int]:
        return {place: n for place, n in counts.items() if place in self._known}

    def _arcs(self, transition: pn.Transition) -> Arcs:
        found = Arcs(Counter(), Counter(), Counter())
        for arc in self._arcs_of[transition]:
            if isinstance(arc.target, pn.Place):
                found.puts[arc.target] += arc.weight
            elif isinstance(arc.source, pn.Place) and arc.kind != pn.ArcKind.inhibitor:
                (found.reads if arc.kind == pn.ArcKind.read else found.takes)[arc.source] += arc.weight
        return found

    # ------------------------------------------------------------------------------------------- making

    def _add_colours(self, place: pn.Place, fields: Mapping[str, FieldType]) -> None:
        """Add a place for each colour, with the tokens that have it at the start."""
        palette = self._known[place]
        default = {name: field.default for name, field in fields.items()}
        original = self._original.get(place)
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

    def _split(self, transition: pn.Transition, ways: Sequence[_Way]) -> list[pn.Transition]:
        """Make of a transition one for each choice of colours; the first of them is the transition itself."""
        if not any(any(way.moves) for way in ways):
            return [transition]
        found = ((way, each) for way in ways for each in variants(way.step, way.moves, self._known))
        chosen: dict[tuple[object, ...], tuple[_Way, Variant]] = {}
        for way, variant in islice(found, MOST_VARIANTS + 1):
            chosen.setdefault(_change(variant), (way, variant))
        assert chosen, "a guard that no token can fulfil is refused"
        made = [transition, *(self._copy(transition) for _ in range(len(chosen) - 1))]
        own_id = transition.id
        for each, (way, variant) in zip(made, chosen.values(), strict=True):
            self._join(each, variant)
            if len(chosen) > 1:
                values = self._text(way, variant)
                each.id = fresh(f"{own_id}[{_joined(values)}]", self._taken)
                self._links[each] = replace(self._links[each], values=values)
        return made

    def _text(self, way: _Way, variant: Variant) -> str:
        """Return the colours of a variant in words: by place, of a message that a rule hands on without."""
        if way.lost is not None and way.lost in variant.takes:
            return self._lost_text(way.lost, variant)
        words = dict.fromkeys(
            self._colour_text(place, colour)
            for each in variant
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

    def _join(self, transition: pn.Transition, variant: Variant) -> None:
        """Add the arcs between a transition and the colours that it takes, reads and puts."""
        for kind, each in zip(("takes", "reads", "puts"), variant, strict=True):
            for uncoloured, colours in each.items():
                for colour, weight in Counter(colours).items():
                    place = self._coloured[uncoloured, colour]
                    source, target = (transition, place) if kind == "puts" else (place, transition)
                    id = fresh(f"{source.id}-{target.id}", self._taken)
                    arc = pn.Arc(id=id, weight=weight, kind="read" if kind == "reads" else "normal")
                    arc.source, arc.target, arc.page = source, target, self._page
                    self._link(arc, "arc", uncoloured)

    def _link(self, made: pn.Element, role: str, place: pn.Place) -> None:
        """Record that guards added an element for a place of the net."""
        link = self._links[place]
        self._links[made] = Link(RULE, role, self._number, link.sources, link.index, made, link.client_index)
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


def _change(variant: Variant) -> tuple[object, ...]:
    """Return what a variant takes, reads and puts, to compare."""
    return tuple(frozenset((p, tuple(sorted(c))) for p, c in each.items()) for each in variant)


def _joined(words: str) -> str:
    """Return words as a part of an id, which has no blanks."""
    return words.replace(" ", "")
