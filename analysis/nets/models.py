"""Compiles model objects to nets: pages are removed, references resolved."""

from __future__ import annotations

from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.metamodel import pn, sym
from dineros.metamodel.elements import arcs, places, resolve, transitions
from dineros.metamodel.errors import DinerosError


def compile_net(net: pn.Net) -> CompiledNet:
    """Compile a plain net or a Petri-net model; names are the ids of its places and transitions.

    Time intervals do not restrict what is compiled: the markings of a time Petri net are among those of the
    net without time (Berthomieu and Diaz, IEEE TSE 17(3), 1991).

    Raises
    ------
    DinerosError
        A system model (flatten it first), an incomplete arc, priorities, which the engines do not support, or
        capacities, which must be expressed by arcs (see `dineros.transformations.flattening.bounding`).
    """
    if isinstance(net, sym.SystemModel) and len(net.channels):
        raise DinerosError(f"{net.id} is a system model", element=net.id, hint="flatten it first")
    for transition in transitions(net):
        if len(transition.overrides):
            raise DinerosError(
                f"transition {transition.id} has priority over others, which only questions with times know",
                element=transition.id,
                hint="ask with --time, or remove its overrides",
            )
    initial, named = initial_and_arcs(net)
    return CompiledNet.build(initial, named)


def initial_and_arcs(net: pn.Net) -> tuple[dict[str, int], list[Transition]]:
    """Return the initial marking of a plain net, and its transitions with their arcs.

    Raises
    ------
    DinerosError
        An arc connects two nodes of the same kind, or a capacity is not expressed by arcs.
    """
    rows: dict[pn.Node, tuple[dict[str, int], dict[str, int], dict[str, int], dict[str, int]]]
    rows = {transition: ({}, {}, {}, {}) for transition in transitions(net)}
    for arc in arcs(net):
        source, target = resolve(arc.source), resolve(arc.target)
        if isinstance(source, pn.Place) and isinstance(target, pn.Transition):
            kind = {pn.ArcKind.normal: 0, pn.ArcKind.inhibitor: 2, pn.ArcKind.read: 3}[arc.kind]
            _add(rows[target][kind], source.id, arc.weight, least=kind == 2)
        elif isinstance(source, pn.Transition) and isinstance(target, pn.Place):
            _add(rows[source][1], target.id, arc.weight)
        else:
            raise DinerosError(f"arc {arc.id} joins two {type(source).__name__.lower()}s", element=arc.id)
    initial = {}
    for place in places(net):
        if place.capacity is not None:
            raise DinerosError(f"place {place.id} has a capacity that no arc enforces", element=place.id)
        initial[place.id] = place.tokens
    return initial, [Transition(str(transition.id), *row) for transition, row in rows.items()]


def _add(row: dict[str, int], place: str, weight: int, least: bool = False) -> None:
    """Parallel arcs add up; of parallel inhibitor arcs the smallest weight decides."""
    if place not in row:
        row[place] = weight
    else:
        row[place] = min(row[place], weight) if least else row[place] + weight


def to_model(net: CompiledNet, id: str) -> pn.Net:
    """Return a compiled net as a model of one page, so that it can be saved."""
    made, page, place_nodes, transition_nodes = model_of_nodes(net, id)
    joined = []
    for number, transition in enumerate(transition_nodes):
        for place, weight in net.pre.row(number):
            joined.append(_arc(place_nodes[place], transition, weight, "normal"))
        for place, weight in net.post.row(number):
            joined.append(_arc(transition, place_nodes[place], weight, "normal"))
        for place, weight in net.inhibitor.row(number):
            joined.append(_arc(place_nodes[place], transition, weight, "inhibitor"))
    page.arcs.extend(joined)
    return made


def model_of_nodes(net: CompiledNet, id: str) -> tuple[pn.Net, pn.Page, list[pn.Place], list[pn.Transition]]:
    """Return a new model with the places and transitions of a net on one page, without arcs."""
    made = pn.Net(id=id)
    page = pn.Page(id=f"{id}.page", net=made)
    tokens = zip(net.places, net.initial.tolist(), strict=True)
    places = [pn.Place(id=name, tokens=number) for name, number in tokens]
    transitions = [pn.Transition(id=name) for name in net.transitions]
    page.objects.extend([*places, *transitions])
    return made, page, places, transitions


def _arc(source: pn.Node, target: pn.Node, weight: int, kind: str) -> pn.Arc:
    suffix = "" if kind == "normal" else f"-{kind}"
    return pn.Arc(
        id=f"{source.id}-{target.id}{suffix}", source=source, target=target, weight=weight, kind=kind
    )
