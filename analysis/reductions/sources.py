"""The rule for places that a transition without conditions can fill at any time."""

from __future__ import annotations

from collections.abc import Iterator

from dineros.analysis.reductions.net import MutableNet
from dineros.analysis.reductions.rule import LANGUAGE_PROPERTIES, Lift, Question, Rule, Step


class InexhaustiblePlace(Rule):
    """Remove a place that can be filled at any time.

    A transition without inputs and inhibitor arcs, and with no other effect, fills it. The transition stays,
    without arcs; the place may have no inhibitor arcs and neither may be observed.

    *Proof.* Before each step that takes or reads tokens from the place, enough can be put there; nothing else
    changes. The net is never in a deadlock, before and after, and the transition is live. The net is
    unbounded before, which is lost.
    """

    preserves = LANGUAGE_PROPERTIES

    def steps(self, net: MutableNet, question: Question) -> Iterator[Step]:
        """Offer every inexhaustible place."""
        for t in list(net.transitions):
            arcs = net.transitions[t]
            if arcs.inputs or arcs.inhibitors or len(arcs.outputs) != 1 or t in question.observed_transitions:
                continue
            (place,) = arcs.outputs
            if place not in question.observed_places and not net.inhibited[place]:
                yield self.step((place,), (t,), net.removing_places([place]), lift=_filling(place, t))


def _filling(place: str, source: str) -> Lift:
    def lift(before: MutableNet, trace: list[str], _settle: bool) -> list[str]:
        tokens = before.places[place]
        gain = before.transitions[source].outputs[place]
        result: list[str] = []
        for t in trace:
            arcs = before.transitions[t]
            while tokens < arcs.inputs.get(place, 0):
                result.append(source)
                tokens += gain
            tokens += arcs.delta.get(place, 0)
            result.append(t)
        return result

    return lift
