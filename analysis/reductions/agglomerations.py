"""Agglomerations: two transitions with a place between them become one that fires both.

They remove the markings in which the place is marked. So they preserve neither the number of markings nor all
markings of the other places, but observable runs, deadlocks and liveness.

References
----------
G. Berthelot, *Transformations and decompositions of nets*, Advances in Petri Nets 1986, LNCS 254, 1987. D.
Poitrenaud, J.-F. Pradat-Peyre, *Pre- and post-agglomerations for LTL model checking*, ICATPN 2000, LNCS 1825.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from dineros.analysis.reductions.net import Arcs, Change, MutableNet
from dineros.analysis.reductions.rule import Lift, Property, Question, Rule, Step

AGGLOMERATION_PRESERVES = frozenset(
    {Property.DEADLOCKS, Property.LTL_WITHOUT_NEXT, Property.LIVENESS, Property.BOUNDEDNESS}
)


class PostAgglomeration(Rule):
    """Fire the consumers of a place at once, together with what marks it.

    Conditions for the place p, its producers H and its consumers F, neither set empty, disjoint and not
    observed: p is empty initially, not observed, and without inhibitor arcs; each f in F takes one token from
    p, tests and takes nothing else, puts at least one token somewhere, is invisible, and puts no token on a
    place with inhibitor arcs; if F has several elements, each h in H puts just one token on p.

    *Proof.* In a run of N, each f can be moved forward to right after the h that made its token: f needs
    nothing else, is invisible, and its tokens, coming earlier, disable nothing. If a run leaves p marked,
    f can be added. An endless run has endlessly many firings outside F, since F takes tokens from p that only
    H puts there. A marking with p marked is not a deadlock; with p empty N and N' enable the same. H and F
    are live together iff their compositions are. Every f puts tokens somewhere, so tokens that pile up on p
    pile up there in N'.
    """

    preserves = AGGLOMERATION_PRESERVES

    def steps(self, net: MutableNet, question: Question) -> Iterator[Step]:
        """Offer every place between producers and eager consumers."""
        for place, tokens in list(net.places.items()):
            if (
                tokens
                or net.inhibited.get(place)
                or place not in net.places
                or place in question.observed_places
            ):
                continue
            first, second = list(net.producers[place]), list(net.consumers[place])
            if not _may_fuse(first, second, question):
                continue
            if len(second) > 1 and any(net.transitions[h].outputs[place] > 1 for h in first):
                continue
            if all(self._is_eager(net, place, f, question) for f in second):
                yield _fuse(net, place, first, second, self.name, self.preserves, post_lift)

    @staticmethod
    def _is_eager(net: MutableNet, place: str, f: str, question: Question) -> bool:
        arcs = net.transitions[f]
        return (
            arcs.inputs == {place: 1}
            and not arcs.inhibitors
            and bool(arcs.outputs)
            and question.is_invisible(f, arcs)
            and not any(net.inhibited[p] for p in arcs.outputs)
        )


class PreAgglomeration(Rule):
    """Fire the producers of a place only when a consumer takes the token.

    Conditions for the place p, its producers H and its consumers F, neither set empty, disjoint and not
    observed: p is empty initially, not observed, and without inhibitor arcs; each f in F takes one token from
    p; each h in H has input places, which only h takes from or tests and which have no inhibitor arcs, has no
    inhibitor arcs itself, puts one token on p and nothing elsewhere, and is invisible.

    *Proof.* In a run of N, each h can be moved back to right before the f that takes its token: nothing else
    needs or tests the tokens h takes, h is invisible, and nothing but F needs p. An h whose token is never
    taken can be left out; it cannot be endlessly many of them alone, since h takes tokens it does not make.
    If N' stops, N can still fire H until that stops, too, and then no f is enabled, or its composition
    with an h would have been. With one h or one f, H and F are live together iff their compositions are; with
    several of both, some f may never meet the token of some h, so that `LIVENESS` is not claimed. p piles up
    tokens only if the inputs of H do in N'.
    """

    preserves = AGGLOMERATION_PRESERVES

    def steps(self, net: MutableNet, question: Question) -> Iterator[Step]:
        """Offer every place between delayable producers and consumers."""
        for place, tokens in list(net.places.items()):
            if tokens or place not in net.places or net.inhibited[place] or place in question.observed_places:
                continue
            first, second = list(net.producers[place]), list(net.consumers[place])
            if not _may_fuse(first, second, question):
                continue
            if any(net.transitions[f].inputs[place] > 1 for f in second):
                continue
            if all(self._can_wait(net, place, h, question) for h in first):
                are_many = len(first) > 1 and len(second) > 1
                kept = self.preserves - {Property.LIVENESS} if are_many else self.preserves
                yield _fuse(net, place, first, second, self.name, kept, pre_lift)

    @staticmethod
    def _can_wait(net: MutableNet, place: str, h: str, question: Question) -> bool:
        arcs = net.transitions[h]
        return (
            arcs.outputs == {place: 1}
            and not arcs.inhibitors
            and bool(arcs.inputs)
            and question.is_invisible(h, arcs)
            and all(len(net.consumers[p]) == 1 and not net.inhibited[p] for p in arcs.inputs)
        )


def _may_fuse(first: list[str], second: list[str], question: Question) -> bool:
    return (
        bool(first)
        and bool(second)
        and set(first).isdisjoint(second)
        and question.observed_transitions.isdisjoint([*first, *second])
        # The net must not grow.
        and len(first) * len(second) <= len(first) + len(second)
    )


#: Names of the fused transitions: new name -> (first, second, times the second fires).
Fusions = Mapping[str, tuple[str, str, int]]


def _fuse(
    net: MutableNet,
    place: str,
    first: list[str],
    second: list[str],
    rule: str,
    preserves: frozenset[Property],
    make_lift: Callable[[Fusions, tuple[str, ...]], Lift],
) -> Step:
    added: dict[str, Arcs] = {}
    fusions: dict[str, tuple[str, str, int]] = {}
    for h in first:
        for f in second:
            name = net.fresh_transition(f"{h}.{f}", added)
            one, other = net.transitions[h], net.transitions[f]
            times = one.outputs[place] // other.inputs[place]
            inputs, outputs = dict(one.inputs), dict(one.outputs)
            del outputs[place]
            for p, weight in other.inputs.items():
                if p != place:
                    inputs[p] = inputs.get(p, 0) + times * weight
            for p, weight in other.outputs.items():
                outputs[p] = outputs.get(p, 0) + times * weight
            added[name] = Arcs(inputs, outputs, {**one.inhibitors, **other.inhibitors})
            fusions[name] = (h, f, times)
    change = Change(
        removed_places={place: 0},
        removed_transitions={t: net.transitions[t] for t in (*first, *second)},
        added_transitions=added,
    )
    return Step(rule, (place,), (*first, *second), preserves, change, make_lift(fusions, tuple(first)))


def _unfused(fusions: Fusions, trace: list[str]) -> list[str]:
    result: list[str] = []
    for t in trace:
        if t in fusions:
            h, f, times = fusions[t]
            result += [h, *[f] * times]
        else:
            result.append(t)
    return result


def post_lift(fusions: Fusions, _first: tuple[str, ...]) -> Lift:
    """Fire both transitions of each fused one."""

    def lift(_before: MutableNet, trace: list[str], _settle: bool) -> list[str]:
        return _unfused(fusions, trace)

    return lift


def pre_lift(fusions: Fusions, first: tuple[str, ...]) -> Lift:
    """Fire both transitions of each fused one; on the way to a deadlock, then the ones that waited."""

    def lift(before: MutableNet, trace: list[str], settle: bool) -> list[str]:
        result = _unfused(fusions, trace)
        if settle:
            marking = dict(before.places)
            for t in result:
                before.fire(t, marking)
            for h in first:
                while before.is_enabled(h, marking):
                    before.fire(h, marking)
                    result.append(h)
        return result

    return lift
