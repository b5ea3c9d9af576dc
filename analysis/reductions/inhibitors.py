"""Rules that remove inhibitor arcs, so that rules without support for them apply.

They change neither the places nor the enabled transitions of reachable markings, so they preserve everything.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations
from math import floor

from dineros.analysis.reductions.certificates import GuardedBounds
from dineros.analysis.reductions.net import Arcs, Change, MutableNet
from dineros.analysis.reductions.places import LARGEST_PROGRAM, affine_relation, proportional_places
from dineros.analysis.reductions.rule import ALL_PROPERTIES, Question, Rule, Step
from dineros.analysis.reductions.sampling import sampled


class ComplementaryInhibitor(Rule):
    """Replace an inhibitor arc with a place by a read arc with its complement.

    *Proof.* With ``delta(p) = -k * delta(q)``, k > 0, m(p) = c - k m(q) in every reachable marking, so that
    m(p) < w iff m(q) > (c - w) / k iff m(q) >= floor((c - w) / k) + 1.
    """

    preserves = ALL_PROPERTIES

    def steps(self, net: MutableNet, question: Question) -> Iterator[Step]:
        """Offer every inhibitor arc with a place that has a complement."""
        for family in proportional_places(net):
            for place, other in permutations(family, 2):
                if not net.inhibited[place] or family[place] * family[other] > 0:
                    continue
                factor, constant = affine_relation(net, family, place, other)
                for t in list(net.inhibited[place]):
                    arcs = net.transitions[t]
                    least = floor((constant - arcs.inhibitors[place]) / -factor) + 1
                    reading = _reading(arcs.without_inhibitor(place), other, least)
                    yield self.step((place, other), (t,), _replace(net, t, reading))


class ImpliedInhibitor(Rule):
    """Remove an inhibitor arc that the state equation proves never to disable its transition alone.

    *Proof.* `GuardedBounds.largest` bounds the place in all markings that hold the transition's input tokens;
    rounded down it is below the weight of the arc.
    """

    preserves = ALL_PROPERTIES
    is_costly = True

    def steps(self, net: MutableNet, question: Question) -> Iterator[Step]:
        """Offer every implied inhibitor arc."""
        if max(len(net.places), len(net.transitions)) > LARGEST_PROGRAM:
            return
        if not any(net.inhibited.values()):
            return
        equation = GuardedBounds(net)
        sample = sampled(net)
        for t in list(net.transitions):
            for place, weight in net.transitions[t].inhibitors.items():
                if (place, t) in sample.deciding_inhibitors:
                    continue
                arcs = net.transitions[t]
                largest = equation.largest(place, {p: w for p, w in arcs.inputs.items() if p != place})
                if largest is not None and floor(largest) < weight:
                    yield self.step((place,), (t,), _replace(net, t, arcs.without_inhibitor(place)))


def _reading(arcs: Arcs, place: str, least: int) -> Arcs:
    """The same effect, but enabled only while a place holds at least some tokens."""
    more = least - arcs.inputs.get(place, 0)
    if more <= 0:
        return arcs
    inputs = {**arcs.inputs, place: least}
    outputs = {**arcs.outputs, place: arcs.outputs.get(place, 0) + more}
    return Arcs(inputs, outputs, arcs.inhibitors)


def _replace(net: MutableNet, transition: str, arcs: Arcs) -> Change:
    return Change(
        removed_transitions={transition: net.transitions[transition]}, added_transitions={transition: arcs}
    )
