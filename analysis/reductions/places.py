"""Rules that remove places which never disable a transition alone.

If a place is never the only one to disable a transition, removing it does not change the firing sequences. If
an equation determines its tokens from those of other places, the number of reachable markings does not
change, either.

References
----------
G. Berthelot, *Transformations and decompositions of nets*, Advances in Petri Nets 1986, LNCS 254, 1987. T.
Murata, *Petri nets: properties, analysis and applications*, Proc. IEEE 77(4), 1989, section V. B. Berthomieu,
D. Le Botlan, S. Dal Zilio, *Petri net reductions for counting markings*, SPIN 2018, LNCS 10869.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from math import ceil, gcd

from dineros.analysis.nets.structure import place_invariants
from dineros.analysis.reductions.certificates import GuardedBounds
from dineros.analysis.reductions.net import Marking, MutableNet
from dineros.analysis.reductions.rule import (
    ALL_PROPERTIES,
    LANGUAGE_PROPERTIES,
    PlaceEquation,
    Question,
    Rule,
    Step,
)
from dineros.analysis.reductions.sampling import sampled

#: Linear programming is not used for nets with more places or transitions.
LARGEST_PROGRAM = 600


class ConstantPlace(Rule):
    """Remove a place whose tokens never change and that disables nothing.

    *Proof.* No firing changes the place, so every arc with it holds in all markings or in none; the rule asks
    that all hold initially. Removing it changes neither enabling nor any other place; its tokens are its
    initial ones.
    """

    preserves = ALL_PROPERTIES

    def steps(self, net: MutableNet, question: Question) -> Iterator[Step]:
        """Offer each constant place."""
        for place, tokens in list(net.places.items()):
            if place in question.observed_places:
                continue
            around = [net.transitions[t] for t in net.neighbours(place)]
            if all(
                arcs.inputs.get(place, 0) == arcs.outputs.get(place, 0) <= tokens
                and tokens < arcs.inhibitors.get(place, tokens + 1)
                for arcs in around
            ):
                equation = PlaceEquation(place, {}, Fraction(tokens))
                yield self.step((place,), (), net.removing_places([place]), equation=equation)


class ParallelPlace(Rule):
    """Remove a place that changes in proportion to another one, with arcs that the other's arcs imply.

    The simplest case are two places with the same arcs and tokens.

    *Proof.* With ``delta(p) = k * delta(q)``, k > 0, m(p) = k m(q) + c in every reachable marking m. A
    transition t with m(q) >= pre(q, t) has m(p) >= k pre(q, t) + c; if this, rounded up, is at least
    pre(p, t), p never disables t alone.
    """

    preserves = ALL_PROPERTIES

    def steps(self, net: MutableNet, question: Question) -> Iterator[Step]:
        """Offer each place that has an earlier or later proportional partner."""
        for family in proportional_places(net):
            for place in family:
                if place in question.observed_places or place not in net.places or net.inhibited[place]:
                    continue
                for other in family:
                    if other == place or other not in net.places:
                        continue
                    factor, constant = affine_relation(net, family, place, other)
                    if factor > 0 and _implies(net, place, other, factor, constant):
                        equation = PlaceEquation(place, {other: factor}, constant)
                        yield self.step((place, other), (), net.removing_places([place]), equation=equation)
                        if place not in net.places:
                            break


class ImpliedPlace(Rule):
    """Remove a place that the state equation proves never to disable a transition alone.

    *Proof.* `GuardedBounds.least` bounds m(p) in all markings where the other places enable t; rounded up
    (tokens are integers) the bound is at least pre(p, t), for every t. So the net without p has the same
    firing sequences. The bound needs no arc of p to hold, so it is not a circular argument. If an invariant
    has a weight for p, m(p) follows from the other places, so that markings with and without p are in
    bijection, and p is bounded if they are. Otherwise only the properties of firing sequences are claimed.
    """

    preserves = ALL_PROPERTIES
    is_costly = True

    def steps(self, net: MutableNet, question: Question) -> Iterator[Step]:
        """Offer each implied place."""
        if max(len(net.places), len(net.transitions)) > LARGEST_PROGRAM:
            return
        equation = GuardedBounds(net)
        relations = _Relations(net)
        sample = sampled(net)
        for place in list(net.places):
            if place in question.observed_places or net.inhibited[place] or place in sample.deciding_places:
                continue
            if not _can_be_implied(net, place):
                continue
            relation = relations.equation(place)
            preserved = LANGUAGE_PROPERTIES if relation is None else self.preserves
            if question.preserve <= preserved and _is_implied(net, place, equation):
                yield self.step((place,), (), net.removing_places([place]), preserved, equation=relation)
                if place not in net.places:
                    relations.drop(place)


class _Relations:
    """Place invariants, updated while places are removed."""

    def __init__(self, net: MutableNet) -> None:
        names = list(net.places)
        self._initial = dict(net.places)
        self._basis = [
            {names[p]: weight for p, weight in invariant.weights.items()}
            for invariant in place_invariants(net.compile())
        ]

    def _with(self, place: str) -> dict[str, int] | None:
        return min((y for y in self._basis if place in y), key=len, default=None)

    def equation(self, place: str) -> PlaceEquation | None:
        weights = self._with(place)
        if weights is None:
            return None
        constant, scale = sum(weight * self._initial[p] for p, weight in weights.items()), weights[place]
        factors = {name: Fraction(-weight, scale) for name, weight in weights.items() if name != place}
        return PlaceEquation(place, factors, Fraction(constant, scale))

    def drop(self, place: str) -> None:
        pivot = self._with(place)
        if pivot is None:
            return
        others = (weights for weights in self._basis if weights is not pivot)
        self._basis = [_without(place, weights, pivot) if place in weights else weights for weights in others]


def _without(place: str, weights: dict[str, int], pivot: dict[str, int]) -> dict[str, int]:
    """Combine two invariants to one without a weight for a place."""
    own, other = pivot[place], weights[place]
    combined = {p: own * weights.get(p, 0) - other * pivot.get(p, 0) for p in {**weights, **pivot}}
    shared = gcd(*combined.values()) or 1
    return {p: weight // shared for p, weight in combined.items() if weight}


def _can_be_implied(net: MutableNet, place: str) -> bool:
    """Whether no transition takes tokens from this place only, which is necessary for an implied place."""
    for t in net.consumers[place]:
        delta = net.transitions[t].delta
        if delta.get(place, 0) < 0 and not any(tokens < 0 for name, tokens in delta.items() if name != place):
            return False
    return True


def _is_implied(net: MutableNet, place: str, equation: GuardedBounds) -> bool:
    for t in net.consumers[place]:
        inputs = net.transitions[t].inputs
        least = equation.least(place, {name: weight for name, weight in inputs.items() if name != place})
        if least is None or ceil(least) < inputs[place]:
            return False
    return True


def _implies(net: MutableNet, place: str, other: str, factor: Fraction, constant: Fraction) -> bool:
    for t in net.consumers[place]:
        inputs = net.transitions[t].inputs
        if ceil(factor * inputs.get(other, 0) + constant) < inputs[place]:
            return False
    return True


def proportional_places(net: MutableNet) -> list[dict[str, int]]:
    """Group the places whose rows of the incidence matrix are multiples, also negative, of the same one."""
    rows: dict[str, Marking] = {place: {} for place in net.places}
    for t, arcs in net.transitions.items():
        for place, tokens in arcs.delta.items():
            rows[place][t] = tokens
    groups: dict[tuple[tuple[str, int], ...], dict[str, int]] = {}
    for place, row in rows.items():
        if row:
            scale = gcd(*row.values()) * (1 if next(iter(row.values())) > 0 else -1)
            groups.setdefault(tuple((t, tokens // scale) for t, tokens in row.items()), {})[place] = scale
    return [family for family in groups.values() if len(family) > 1]


def affine_relation(
    net: MutableNet, family: Mapping[str, int], place: str, other: str
) -> tuple[Fraction, Fraction]:
    """Return the factor and the constant by which a place's tokens follow from another one of its family."""
    factor = Fraction(family[place], family[other])
    return factor, net.places[place] - factor * net.places[other]
