"""Rules that remove transitions which can never fire, or which others can replace.

References
----------
G. Berthelot, *Transformations and decompositions of nets*, Advances in Petri Nets 1986, LNCS 254, 1987. T.
Murata, *Petri nets: properties, analysis and applications*, Proc. IEEE 77(4), 1989, section V. B. Berthomieu,
D. Le Botlan, S. Dal Zilio, *Petri net reductions for counting markings*, SPIN 2018, LNCS 10869 (redundant
transitions).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import ceil

from dineros.analysis.reductions.certificates import GuardedBounds
from dineros.analysis.reductions.net import Arcs, MutableNet
from dineros.analysis.reductions.places import LARGEST_PROGRAM
from dineros.analysis.reductions.rule import ALL_PROPERTIES, Property, Question, Rule, Step
from dineros.analysis.reductions.sampling import sampled

#: A net with a dead transition is not live; without it, it may be.
DEAD_PRESERVES = ALL_PROPERTIES - {Property.LIVENESS}


class DeadTransition(Rule):
    """Remove transitions that can never fire, found without linear combinations.

    *Proof.* The transitions that may fire are found as a least fixpoint: one may fire if each of its input
    places starts with enough tokens or gains tokens from one that may fire, and each of its inhibitor places
    starts with few enough or loses tokens to one that may fire. By induction over a firing sequence, all
    others never fire.
    """

    preserves = DEAD_PRESERVES

    def steps(self, net: MutableNet, question: Question) -> Iterator[Step]:
        """Offer every dead transition."""
        may_fire: set[str] = set()
        gaining: set[str] = set()
        losing: set[str] = set()
        todo = list(net.transitions)
        while todo:
            t = todo.pop()
            arcs = net.transitions[t]
            if t in may_fire or not (
                all(net.places[p] >= w or p in gaining for p, w in arcs.inputs.items())
                and all(net.places[p] < w or p in losing for p, w in arcs.inhibitors.items())
            ):
                continue
            may_fire.add(t)
            for place, tokens in arcs.delta.items():
                if tokens > 0 and place not in gaining:
                    gaining.add(place)
                    todo.extend(net.consumers[place])
                if tokens < 0 and place not in losing:
                    losing.add(place)
                    todo.extend(net.inhibited[place])
        for t in list(net.transitions):
            if t not in may_fire and t not in question.observed_transitions:
                yield self.step((), (t,), net.removing_transitions([t]))


class ExcludedTransition(Rule):
    """Remove transitions that the state equation proves never to fire.

    *Proof.* Either weights of places exclude every marking with all the input tokens
    (`GuardedBounds.excludes`), or they prove that, with those tokens present, an inhibitor place always holds
    its weight.
    """

    preserves = DEAD_PRESERVES
    is_costly = True

    def steps(self, net: MutableNet, question: Question) -> Iterator[Step]:
        """Offer every excluded transition."""
        if max(len(net.places), len(net.transitions)) > LARGEST_PROGRAM:
            return
        equation = GuardedBounds(net)
        kept = question.observed_transitions | sampled(net).enabled
        for t, arcs in list(net.transitions.items()):
            if t not in kept and _is_excluded(arcs, equation):
                yield self.step((), (t,), net.removing_transitions([t]))


def _is_excluded(arcs: Arcs, equation: GuardedBounds) -> bool:
    # Where one token in one place is enough, only emptiness could disable, which the cheap rule sees most
    # often.
    if (len(arcs.inputs) > 1 or any(w > 1 for w in arcs.inputs.values())) and equation.excludes(arcs.inputs):
        return True
    for place, weight in arcs.inhibitors.items():
        guard = {p: w for p, w in arcs.inputs.items() if p != place}
        least = equation.least(place, guard)
        if least is not None and ceil(least) >= weight:
            return True
    return False


class DuplicateTransition(Rule):
    """Remove one of two transitions with the same effect if one is enabled whenever the other is.

    *Proof.* Let t and u change the marking alike, u with no more input tokens and no stricter inhibitors.
    Whenever t fires, u can fire instead with the same result, so t adds no marking, no run (both are
    unobserved) and no way out of a deadlock. For liveness the enabling must be the same: only then is t live
    if u is.
    """

    preserves = ALL_PROPERTIES

    def steps(self, net: MutableNet, question: Question) -> Iterator[Step]:
        """Offer every transition that another one can replace."""
        families: dict[frozenset[tuple[str, int]], list[str]] = {}
        for t, arcs in net.transitions.items():
            if t not in question.observed_transitions:
                families.setdefault(frozenset(arcs.delta.items()), []).append(t)
        for family in families.values():
            # Later ones first, so that the first of equal transitions is kept.
            for t in reversed(family):
                for u in family:
                    if (
                        u == t
                        or u not in net.transitions
                        or not _is_easier(net.transitions[u], net.transitions[t])
                    ):
                        continue
                    preserved = ALL_PROPERTIES if net.transitions[u] == net.transitions[t] else DEAD_PRESERVES
                    yield self.step((), (t, u), net.removing_transitions([t]), preserved)
                    if t not in net.transitions:
                        break


class ComposedTransition(Rule):
    """Remove a transition whose effect is that of two others, fired one after the other.

    *Proof.* Whenever t is enabled, so is the sequence u v, with the result of t. So t adds no marking, and no
    marking in which t is enabled is a deadlock without it. Runs can differ (u v passes through a marking in
    between).
    """

    preserves = ALL_PROPERTIES - {Property.LTL_WITHOUT_NEXT, Property.LIVENESS}

    def steps(self, net: MutableNet, question: Question) -> Iterator[Step]:
        """Offer every composed transition."""
        by_effect: dict[frozenset[tuple[str, int]], list[str]] = {}
        for t, arcs in net.transitions.items():
            by_effect.setdefault(frozenset(arcs.delta.items()), []).append(t)
        for t, arcs in list(net.transitions.items()):
            if t not in question.observed_transitions:
                pair = self._pair(net, t, arcs, by_effect)
                if pair is not None:
                    yield self.step((), (t, *pair), net.removing_transitions([t]))

    @staticmethod
    def _pair(
        net: MutableNet, t: str, arcs: Arcs, by_effect: Mapping[frozenset[tuple[str, int]], list[str]]
    ) -> tuple[str, str] | None:
        effect = arcs.delta
        if not effect:
            return None
        for u in dict.fromkeys(u for place in arcs.inputs for u in net.consumers[place]):
            first = net.transitions[u]
            if u == t or not _is_easier(first, arcs):
                continue
            rest = {p: effect.get(p, 0) - first.delta.get(p, 0) for p in {**effect, **first.delta}}
            for v in by_effect.get(frozenset((p, w) for p, w in rest.items() if w), ()):
                if v != t and v in net.transitions and _is_easier(_after(first, net.transitions[v]), arcs):
                    return u, v
        return None


class IdentityTransition(Rule):
    """Remove a transition that changes nothing.

    *Proof.* Its firings lead nowhere new. While it is enabled there is no deadlock, so it must stay for
    `DEADLOCKS` unless another one is enabled whenever it is; it must stay for `LTL_WITHOUT_NEXT`, since a run
    can end with it forever. It is live if another transition is that needs at least as much.
    """

    preserves = ALL_PROPERTIES - {Property.LTL_WITHOUT_NEXT}

    def steps(self, net: MutableNet, question: Question) -> Iterator[Step]:
        """Offer every transition without effect."""
        for t, arcs in list(net.transitions.items()):
            if arcs.delta or t in question.observed_transitions:
                continue
            preserved = set(self.preserves)
            others = [other for u, other in net.transitions.items() if u != t]
            if not any(_is_easier(other, arcs) for other in others):
                preserved.discard(Property.DEADLOCKS)
            if not any(_is_easier(arcs, other) for other in others):
                preserved.discard(Property.LIVENESS)
            yield self.step((), (t,), net.removing_transitions([t]), preserved)


def _is_easier(easy: Arcs, hard: Arcs) -> bool:
    """Whether the first is enabled in every marking that enables the second, according to the arcs alone."""
    return all(hard.inputs.get(p, 0) >= w for p, w in easy.inputs.items()) and all(
        hard.inhibitors.get(p, w + 1) <= w for p, w in easy.inhibitors.items()
    )


def _after(first: Arcs, second: Arcs) -> Arcs:
    """Return the condition for a marking such that the second is enabled after the first has fired."""
    delta = first.delta
    inputs = {p: w - delta.get(p, 0) for p, w in second.inputs.items()}
    # A weight below 1 is an inhibitor arc that always disables; no transition has one, so none implies it.
    inhibitors = {p: w - delta.get(p, 0) for p, w in second.inhibitors.items()}
    return Arcs({p: w for p, w in inputs.items() if w > 0}, {}, inhibitors)
