"""Guards on a flattened net: tokens are distinguished by their data as far as guards need (unfolding).

This runs after all rules. A place keeps its tokens, its capacity and its arcs. In addition, there is a place
for each colour that guards distinguish; together these have as many tokens as the place, which is a place
invariant. A transition that takes, puts or reads such tokens is replaced by one transition for each choice of
colours. So all colours share the limits of queues, locks and slots (unfolding of coloured nets: Jensen,
Coloured Petri Nets 1, 1992, Sect. 2.4).

Data sent by a port arrives: rules declare which of their places carry data
(`dineros.transformations.flattening.data_flow`). Each other token put by a rule's transition has any value of
its range.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from dineros.metamodel import pn, pnm, sym
from dineros.metamodel.elements import nodes, places, transitions
from dineros.metamodel.errors import GuardError
from dineros.metamodel.guards.colours import (
    Colour,
    Moves,
    Palette,
    Step,
    Variant,
    can_be_handed,
    needed,
    occurring,
    palettes,
    variants,
)
from dineros.metamodel.guards.reading import Source, read_assignments, read_guard
from dineros.metamodel.token_data import FieldType, read_data
from dineros.metamodel.token_types.declared import token_type_of, type_of_place
from dineros.transformations.flattening.coloured import Chosen, ColouredNet, Way
from dineros.transformations.flattening.data_flow import Arcs, DataFlow, Flow
from dineros.transformations.flattening.traces import Trace
from dineros.transformations.language.creation import New

MOST_VARIANTS = 20_000
"""Maximum number of transitions that guards may create for the transitions of one net."""


def unfold_guards(model: sym.SystemModel, net: pnm.PetriNetModel, trace: Trace) -> Trace:
    """Apply the guards of a model to its flattened net; return the trace with the added elements.

    Parameters
    ----------
    net : pnm.PetriNetModel
        Its flattened net; it is changed.
    trace : Trace
        The trace of the flattening.

    Raises
    ------
    GuardError
        A guard or an assignment is invalid, or too many transitions are needed.
    """
    return _Unfolding(model, net, trace).run()


class _Unfolding:
    def __init__(self, model: sym.SystemModel, net: pnm.PetriNetModel, trace: Trace) -> None:
        self._model, self._net = model, net
        self._links = {link.target: link for link in trace}
        self._fields_of: dict[pn.Place, dict[str, FieldType]] = {}
        self._original: dict[pn.Node, pn.Place] = {}
        self._known: dict[pn.Place, Palette] = {}
        for node in nodes(net):
            link = self._links[node]
            if link.role == "place" and link.maker is None and isinstance(link.sources[0], pn.Place):
                assert isinstance(node, pn.Place)
                self._original[node] = link.sources[0]
        self._arcs_of: dict[pn.Transition, list[pn.Arc]] = {each: [] for each in transitions(net)}
        for arc in net.pages[0].arcs:
            end = arc.source if isinstance(arc.source, pn.Transition) else arc.target
            assert isinstance(end, pn.Transition)
            self._arcs_of[end].append(arc)
        self._starts: dict[pn.Place, Counter[Colour]] = {}
        self._colours: dict[pn.Place, list[Colour]] = {}

    def run(self) -> Trace:
        arcs = {transition: self._arcs(transition) for transition in self._arcs_of}
        steps = self._steps(arcs)
        flow = DataFlow(self._model, self._links, self._original, arcs, self._fields)
        known = palettes(steps, flow.fields, flow.copied())
        for place in places(self._net):
            if flow.key(place) in known:
                self._known[place] = known[flow.key(place)]
        chosen = {
            transition: self._variants(transition, self._ways(transition, own, steps, flow))
            for transition, own in arcs.items()
        }
        self._drop_impossible(chosen, flow)
        limits = flow.limits()
        made = ColouredNet(self._net, self._links, self._original, self._known, self._arcs_of)
        for place in self._known:
            made.add_colours(place, self._colours[place], self._starts[place], limits.get(place, 1))
        copies: dict[pn.Transition, list[pn.Transition]] = {}
        for transition, ways in chosen.items():
            copies[transition] = made.split(transition, ways)
            if sum(map(len, copies.values())) - len(copies) > MOST_VARIANTS:
                raise self._too_many(transition)
        for transition, higher in copies.items():
            for lower in list(transition.overrides):
                for each in higher:
                    each.overrides.extend(copies[lower][1:])
        return Trace(self._links.values())

    def _ways(
        self, transition: pn.Transition, own: Arcs, steps: Mapping[sym.Transition, Step], flow: DataFlow
    ) -> list[Way]:
        origin = self._origin(transition)
        if origin is None and transition in flow.flows:
            return [self._handed(way, flow) for way in flow.flows[transition]]
        return [self._stepping(None if origin is None else steps.get(origin), own)]

    def _variants(self, transition: pn.Transition, ways: Sequence[Way]) -> list[Chosen]:
        """Return the variants of a transition; empty: colours do not affect it."""
        if not any(any(way.moves) for way in ways):
            return []
        found = ((way, each) for way in ways for each in variants(way.step, way.moves, self._known))
        chosen: dict[tuple[object, ...], Chosen] = {}
        for number, (way, variant) in enumerate(found):
            if number == MOST_VARIANTS:
                raise self._too_many(transition)
            chosen.setdefault(_change(variant), Chosen(way, variant))
        assert chosen, "a guard that no token can satisfy is rejected"
        return list(chosen.values())

    def _too_many(self, transition: pn.Transition) -> GuardError:
        return GuardError(
            f"guards make more than {MOST_VARIANTS} transitions",
            element=self._id(transition),
            hint="use fewer fields in guards, or let transitions take fewer tokens",
        )

    def _drop_impossible(self, chosen: dict[pn.Transition, list[Chosen]], flow: DataFlow) -> None:
        """Remove variants that take tokens of colours that never occur; a dead transition keeps one."""
        self._starts = {
            place: Counter(self._at_start(place, flow.fields(flow.key(place)))) for place in self._known
        }
        start = [(place, colour) for place, colours in self._starts.items() for colour in colours]
        occur = occurring(start, (each.variant for every in chosen.values() for each in every))
        for transition, every in chosen.items():
            possible = [each for each in every if occur.issuperset(needed(each.variant))]
            chosen[transition] = possible or every[:1]
        left = (each.variant for every in chosen.values() for each in every)
        used = {
            (place, colour)
            for variant in left
            for each in variant
            for place, colours in each.items()
            for colour in colours
        }
        self._colours = {
            place: [each for each in palette.colours if place in self._original or (place, each) in used]
            for place, palette in self._known.items()
        }

    def _steps(self, arcs: Mapping[pn.Transition, Arcs]) -> dict[sym.Transition, Step]:
        """Return the guard and assignments of each transition of the model."""
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
        """Return the transition of the model that a transition is or repeats; None: a rule made it."""
        link = self._links[transition]
        if link.maker is None:
            return link.sources[0] if link.sources and isinstance(link.sources[0], sym.Transition) else None
        made = link.maker.created.get(link.role)
        if isinstance(made, New) and made.repeats:
            return next(each for each in link.sources if isinstance(each, sym.Transition))
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

    def _stepping(self, step: Step | None, own: Arcs) -> Way:
        """Return how a transition of the model moves tokens between places of the net."""
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
        return Way(step, Moves(*map(self._coloured_of, own)))

    def _handed(self, way: Flow, flow: DataFlow) -> Way:
        """Return how a transition of a rule passes messages on."""
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
        return Way(Step({}, assigned), moves, way.lost)

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

    def _at_start(self, place: pn.Place, fields: Mapping[str, FieldType]) -> list[Colour]:
        """Return the colours of the initial tokens of a place."""
        default = {name: field.default for name, field in fields.items()}
        original = self._original.get(place)
        balloons = list(original.balloons) if isinstance(original, sym.Place) else []
        data = [default | read_data(each.data or "{}", fields) for each in balloons]
        data += [default] * (place.tokens - len(data))
        return [self._known[place].colour_of(each) for each in data[: place.tokens]]

    def _id(self, transition: pn.Transition) -> str:
        origin = self._origin(transition)
        return transition.id if origin is None else origin.id


def _change(variant: Variant) -> tuple[object, ...]:
    """Return the tokens that a variant takes, reads and puts, for comparison."""
    return tuple(frozenset((p, tuple(sorted(c))) for p, c in each.items()) for each in variant)
