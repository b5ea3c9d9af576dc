"""Proved bounds of places, from semiflows and from the linear relaxation of the state equation.

A bound is the value of a weighting y >= 0 with y . C <= 0: no firing increases y . m, so m(p) <= y . m0 /
y(p). Linear programming proposes a weighting in floating point; it is accepted only after an exact check in
integers. One program usually bounds a whole part of the net, so few are solved; each place's bound is then
improved by removing weights of places from which no tokens can flow to it.

The program of a place gives the best of its bounds by weightings. A bound by the program of another place
holds, too, but may be weaker, so some places get a program of their own as well: all of them in small nets.

References
----------
M. Silva, E. Teruel, J. M. Colom, *Linear algebraic and linear programming techniques for the analysis of
place/transition net systems*, Lectures on Petri Nets I, LNCS 1491, 1998.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.graph_parts import strongly_connected_parts
from dineros.analysis.nets.linear_programs import LinearProgram, in_whole_numbers
from dineros.analysis.nets.semiflows import in_order, is_consistent, semiflows
from dineros.analysis.nets.siphons import unmarked_siphon
from dineros.analysis.nets.structure import PlaceInvariant

LEAST_OWN = 16
"""Number of places, those with the largest bounds first, that get a program of their own in any case."""

MOST_FRUITLESS = 4
"""Number of programs in a row that may fail to improve the bounds by semiflows; then no others are tried."""


@dataclass(frozen=True)
class Bound:
    """A proved bound: at most ``value`` tokens, by the weighting ``weights`` (place -> weight > 0)."""

    value: int
    weights: dict[int, int]


def place_bounds(net: CompiledNet) -> Sequence[Bound | None]:
    """Return a bound for each place, or None if no weighting gives one.

    Large nets take seconds, and many questions need the bounds, so they are kept with the net.
    """
    return net.once(_bounds_without_flows)


def _bounds_without_flows(net: CompiledNet) -> list[Bound | None]:
    return _bounds_by(net, ())


def _bounds_by(net: CompiledNet, flows: Iterable[PlaceInvariant]) -> list[Bound | None]:
    """Return a bound for each place by semiflows that are known, and by linear programs."""
    bounds: list[Bound | None] = [None] * len(net.places)
    producers = producers_of(net)
    for flow in flows:
        _use(net, bounds, flow.weights)
    for place, putting in enumerate(producers):
        if bounds[place] is None and not putting:
            _use(net, bounds, {place: 1})
    weightings = {tuple(b.weights.items()): b.weights for b in bounds if b is not None and b.value > 1}
    by_flows = [place for place, bound in enumerate(bounds) if bound is not None]
    unknown = [place for place, bound in enumerate(bounds) if bound is None]
    if unknown:
        _bound_by_programs(net, unknown, bounds, weightings, producers)
    for weights in weightings.values():
        if any(_value(bounds[place]) > 1 for place in weights):
            _use_parts(net, bounds, producers, weights)
    _improve(net, [place for place in by_flows if _value(bounds[place]) > 1], bounds, producers)
    return bounds


def _improve(
    net: CompiledNet,
    places: list[int],
    bounds: list[Bound | None],
    producers: Sequence[Sequence[int]],
) -> None:
    """Improve bounds by semiflows: a weighting that some firings decrease may be better.

    An example is messages that get lost: each is sent once, but a semiflow counts those of all receivers.
    In a consistent net, every weighting that no firing increases is a semiflow, so nothing can be improved.
    """
    if not places or is_consistent(net):
        return
    program, fruitless = LinearProgram(net.delta, len(net.places)), 0
    for place in sorted(places, key=lambda place: -_value(bounds[place])):
        before = _value(bounds[place])
        if before <= 1:
            continue
        weights = _linear_weighting(net, program, place)
        if weights is not None:
            _use(net, bounds, weights)
            if set(weights.values()) == {1}:
                _use(net, bounds, dict.fromkeys(sorted(grown(net, weights, producers)), 1))
        fruitless = 0 if _value(bounds[place]) < before else fruitless + 1
        if fruitless == MOST_FRUITLESS:
            return


def _value(bound: Bound | None) -> int:
    return 0 if bound is None else bound.value


def _bound_by_programs(
    net: CompiledNet,
    unknown: list[int],
    bounds: list[Bound | None],
    weightings: dict[tuple[tuple[int, int], ...], dict[int, int]],
    producers: Sequence[Sequence[int]],
) -> None:
    """Bound places by linear programs; each weighting found is used for all places that it bounds."""
    program, sought = LinearProgram(net.delta, len(net.places)), 0

    def seek(place: int) -> None:
        weights = _linear_weighting(net, program, place)
        if weights is not None:
            _use(net, bounds, weights)
            weightings[tuple(weights.items())] = weights
            if set(weights.values()) == {1}:
                # Tokens that can replace these have the same bound, and need no linear program.
                more = dict.fromkeys(sorted(grown(net, weights, producers)), 1)
                if len(more) > len(weights):
                    _use(net, bounds, more)

    for place in unknown:
        if bounds[place] is None:
            sought += 1
            seek(place)
    # The weighting of another place may give a weaker bound than the best one. So as many places are tried
    # once more, or a few: those with the largest bounds, and all places to which no token comes.
    values = {place: bound.value for place in unknown if (bound := bounds[place]) is not None}
    largest = sorted((place for place in values if values[place] > 0), key=lambda place: -values[place])
    again = [place for place in largest[:sought] if values[place] > 1] + largest[:LEAST_OWN]
    never = [place for place in unmarked_siphon(net) if values.get(place, 0) > 0]
    for place in dict.fromkeys([*again, *never]):
        seek(place)


FlowsAndBounds: TypeAlias = tuple[Sequence[PlaceInvariant] | None, Sequence[Bound | None]]
"""Semiflows of a net (None: too many), and a bound for each place, or None."""


def flows_and_bounds(net: CompiledNet) -> FlowsAndBounds:
    """Return the minimal semiflows (None: too many), and the bounds of places that they and others prove.

    All engines start with these: call it by `CompiledNet.once`.
    """
    flows = semiflows(net)
    return flows, _bounds_by(net, flows) if flows else place_bounds(net)


def renumbered(facts: FlowsAndBounds, number: Mapping[int, int]) -> FlowsAndBounds:
    """Return the same semiflows and bounds for a net whose places have other numbers.

    Parameters
    ----------
    number
        For each place, its number in the other net.
    """

    def own(weights: Mapping[int, int]) -> dict[int, int]:
        return dict(sorted((number[p], weight) for p, weight in weights.items()))

    flows, bounds = facts
    made: list[Bound | None] = [None] * len(bounds)
    for place, bound in enumerate(bounds):
        made[number[place]] = None if bound is None else Bound(bound.value, own(bound.weights))
    if flows is None:
        return None, made
    return in_order(PlaceInvariant(own(flow.weights), flow.constant) for flow in flows), made


def of_part(facts: FlowsAndBounds, part: CompiledNet, number: Mapping[int, int]) -> FlowsAndBounds:
    """Return the semiflows and bounds of a part of a net, from those of the whole net.

    Each transition of the whole net changes only places of the part, or only others. So minimal semiflows
    have no places on both sides, and a weighting without the other places proves a bound, too.

    Parameters
    ----------
    number
        For each place of the part, by its number in the whole net, its number in the part.
    """
    flows, bounds = facts
    made: list[Bound | None] = [None] * len(part.places)
    own: dict[int, dict[int, int]] = {}  # most places share their weighting with others
    for place, bound in enumerate(bounds):
        if place in number and bound is not None:
            if id(bound.weights) not in own:
                kept = ((number[p], weight) for p, weight in bound.weights.items() if p in number)
                own[id(bound.weights)] = dict(kept)
            weights = own[id(bound.weights)]
            there = number[place]
            made[there] = Bound(weighted_sum(part, weights) // weights[there], weights)
    if flows is None:
        return None, made
    within = (flow for flow in flows if flow.weights.keys() <= number.keys())
    return in_order(
        PlaceInvariant({number[p]: weight for p, weight in flow.weights.items()}, flow.constant)
        for flow in within
    ), made


def bounds_like(net: CompiledNet, bounds: Iterable[Bound | None]) -> list[int | None]:
    """Bounds of another net of the same structure with the same weightings, each checked again."""
    answers: list[int | None] = []
    valid: dict[int, bool] = {}  # most places share their weighting with other places
    for place, bound in enumerate(bounds):
        if bound is not None and id(bound.weights) not in valid:
            valid[id(bound.weights)] = not grows(net, bound.weights)
        if bound is None or not valid[id(bound.weights)]:
            answers.append(None)
        else:
            answers.append(weighted_sum(net, bound.weights) // bound.weights[place])
    return answers


def _use(net: CompiledNet, bounds: list[Bound | None], weights: dict[int, int]) -> None:
    total = weighted_sum(net, weights)
    for place, weight in weights.items():
        known = bounds[place]
        if known is None or total // weight < known.value:
            bounds[place] = Bound(total // weight, weights)


def integer_weights(proposed: Sequence[float]) -> dict[int, int]:
    """Weights in proportion to those a linear program proposes, by place, without zeros."""
    whole, _ = in_whole_numbers(proposed)
    return {p: weight for p, weight in enumerate(whole) if weight > 0}


def weighted_sum(net: CompiledNet, weights: dict[int, int]) -> int:
    """Weighted sum of tokens in the initial marking."""
    return sum(int(net.initial[p]) * weight for p, weight in weights.items())


def grows(net: CompiledNet, weights: dict[int, int]) -> bool:
    """Whether some firing increases the weighted sum."""
    changing = {t for p in weights for t in net.changing[p]}
    return any(sum(weights.get(p, 0) * tokens for p, tokens in net.delta[t].items()) > 0 for t in changing)


def producers_of(net: CompiledNet) -> list[list[int]]:
    """Return, by place, the transitions that put more tokens there than they take."""
    producers: list[list[int]] = [[] for _ in net.places]
    for transition, change in enumerate(net.delta):
        for place, tokens in change.items():
            if tokens > 0:
                producers[place].append(transition)
    return producers


def grown(net: CompiledNet, places: Iterable[int], producers: Sequence[Sequence[int]]) -> set[int]:
    """Add unmarked places to a set whose tokens never become more, as long as they never become more.

    Examples
    --------
    >>> net = CompiledNet.build({"a": 1, "b": 0, "c": 0},
    ...     [("t", {"a": 1}, {"b": 1}), ("u", {"a": 1}, {"c": 1}), ("v", {"b": 1}, {})])
    >>> grown(net, [0], producers_of(net))
    {0, 1, 2}
    """
    group: set[int] = set()
    loss: defaultdict[int, int] = defaultdict(int)  # by transition: tokens that it takes from the set
    near: list[int] = []

    def add(place: int) -> None:
        group.add(place)
        for transition in net.changing[place]:
            change = net.delta[transition]
            loss[transition] -= change[place]
            if change[place] < 0:
                near.extend(other for other, tokens in change.items() if tokens > 0)

    for place in places:
        add(place)
    while near:
        place = near.pop()
        if place in group or net.initial[place]:
            continue
        if all(loss[transition] >= net.delta[transition][place] for transition in producers[place]):
            add(place)
    return group


def _use_parts(
    net: CompiledNet,
    bounds: list[Bound | None],
    producers: Sequence[Sequence[int]],
    weights: dict[int, int],
) -> None:
    """Improve the bounds of places by the parts of a weighting from which tokens can flow to them.

    Each transition takes from such a part what it produces into the part; removing its other outputs only
    decreases the sum, so the part is also a valid weighting. Its sum depends on the marked places in it
    alone. So places to which tokens flow from the same marked places share one part.
    """
    sources = {
        place: {p for t in producers[place] for p, n in net.delta[t].items() if n < 0 and p in weights}
        for place in weights
    }
    marked = {place: 1 << i for i, place in enumerate(p for p in weights if net.initial[p])}
    above: dict[int, int] = {}  # by place: the marked places from which tokens can flow to it, as bits
    sharing: defaultdict[int, list[int]] = defaultdict(list)
    for component in strongly_connected_parts(sources):
        members, bits = set(component), 0
        for place in component:
            bits |= marked.get(place, 0)
            for source in sources[place] - members:
                bits |= above[source]
        for place in component:
            above[place] = bits
        sharing[bits] += component
    for bits, places in sharing.items():
        total = sum(int(net.initial[p]) * weights[p] for p, bit in marked.items() if bits & bit)
        better = [p for p in places if total // weights[p] < _value(bounds[p])]
        if better:
            part = _flowing_to(sources, weights, better)
            for place in better:
                bounds[place] = Bound(total // weights[place], part)


def _flowing_to(
    sources: Mapping[int, Iterable[int]], weights: Mapping[int, int], places: Iterable[int]
) -> dict[int, int]:
    """Return the part of a weighting from which tokens can flow to some places, these included."""
    part = set(places)
    open_places = list(part)
    while open_places:
        for source in sources[open_places.pop()]:
            if source not in part:
                part.add(source)
                open_places.append(source)
    return {p: weights[p] for p in sorted(part)}


def _linear_weighting(net: CompiledNet, program: LinearProgram, place: int) -> dict[int, int] | None:
    low = np.zeros(len(net.places))
    low[place] = 1.0
    proposed = program.solve(
        net.initial.astype(float), np.zeros(len(net.transitions)), low, np.full(len(net.places), np.inf)
    )
    if proposed is None:
        return None
    weights = integer_weights(proposed)
    return None if grows(net, weights) else weights
