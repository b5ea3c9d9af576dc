"""Rules that merge places between which tokens move independently.

Unlike agglomerations of transitions, they preserve the reachable markings of all other places.

References
----------
B. Berthomieu, D. Le Botlan, S. Dal Zilio, *Petri net reductions for counting markings*, SPIN 2018, LNCS 10869
(agglomeration of places). T. Murata, *Petri nets: properties, analysis and applications*, Proc. IEEE 77(4),
1989, section V (fusion of series places).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import pairwise

from dineros.analysis.nets.graph_parts import shortest_path, strongly_connected_parts
from dineros.analysis.reductions.net import Arcs, Change, Marking, MutableNet
from dineros.analysis.reductions.rule import ALL_PROPERTIES, Lift, Property, Question, Rule, Step

MERGE_PRESERVES = ALL_PROPERTIES - {Property.STATE_SPACE_SIZE}
"""Suffix of a merge whose tokens can be distributed among the places in every way."""


def move_of(arcs: Arcs) -> tuple[str, str] | None:
    """Source and target of a transition that only moves one token from one place to another, else None."""
    if arcs.inhibitors or len(arcs.inputs) != 1 or len(arcs.outputs) != 1:
        return None
    (source, taken), (target, put) = *arcs.inputs.items(), *arcs.outputs.items()
    return (source, target) if taken == put == 1 and source != target else None


class ChainOfPlaces(Rule):
    """Merge two places when the only consumer of the one moves its tokens to the other.

    ``p -> t -> q`` becomes ``p+q``.

    Conditions: t moves one token and is p's only consumer, neither place has inhibitor arcs or is observed.

    *Proof.* A run of the net N becomes one of N' by leaving t out: p + q holds at least what q does, and all
    else that takes or reads takes from q. A run of N' becomes one of N by firing t as soon as p is marked, so
    that all tokens of p + q are in q. Both have the same markings outside {p, q}. t cannot fire forever
    alone, so endless runs stay endless; N stops only with p empty, where N' stops, too. t is live if a
    producer of p is; without one `LIVENESS` is not claimed. If nothing but t puts tokens on q, which is empty
    initially, a run of N' also becomes one of N by firing t only when a token of q is to be taken (nothing
    reads q, or it would put tokens there). Then all tokens of p + q are in p until t moves some of them:
    every way to share them can be reached (`MARKINGS`), one of which, with p empty, can be a deadlock.
    """

    preserves = MERGE_PRESERVES

    def steps(self, net: MutableNet, question: Question) -> Iterator[Step]:
        """Offer every chain."""
        for t in list(net.transitions):
            move = move_of(net.transitions[t])
            if move is None or t in question.observed_transitions:
                continue
            source, target = move
            if len(net.consumers[source]) > 1 or net.inhibited[source] or net.inhibited[target]:
                continue
            if not question.observed_places.isdisjoint(move):
                continue
            preserved = self.preserves if net.producers[source] else self.preserves - {Property.LIVENESS}
            is_split = len(net.producers[target]) == 1 and not net.places[target]
            if not is_split:
                preserved -= {Property.MARKINGS}
            change, _ = merging(net, move, (t,))
            lift = _moving_eagerly(source, t)
            yield self.step(move, (t,), change, preserved, lift=lift, is_split=is_split)


class LoopOfPlaces(Rule):
    """Merge places between which invisible transitions move single tokens back and forth unconditionally.

    Conditions: the moves make the places strongly connected; the places have no inhibitor arcs and are not
    observed.

    *Proof.* A run of N becomes one of N' by leaving the moves out. Conversely, before each step of a run of
    N', the tokens can be moved to where the step takes or reads them. Both have the same markings of all
    other places, and in N the tokens of the merged place can be moved anywhere (`MARKINGS`). While it is
    marked, N can continue moving tokens forever, and N' can fire *idle*, which reads it. A move is live iff
    the merged place can always be marked again, iff *idle* is live.
    """

    preserves = MERGE_PRESERVES

    def steps(self, net: MutableNet, question: Question) -> Iterator[Step]:
        """Offer every loop."""
        moves: dict[tuple[str, str], list[str]] = {}
        for t, arcs in net.transitions.items():
            move = move_of(arcs)
            if move is None or t in question.observed_transitions:
                continue
            if any(net.inhibited[place] or place in question.observed_places for place in move):
                continue
            moves.setdefault(move, []).append(t)
        if not moves:
            return
        graph = _graph(moves)
        order = {place: position for position, place in enumerate(net.places)}
        loops = [sorted(loop, key=order.__getitem__) for loop in strongly_connected_parts(graph)]
        for loop in sorted(loops, key=lambda loop: order[loop[0]]):
            if len(loop) > 1:
                inside = [t for move, ts in moves.items() if move[0] in loop and move[1] in loop for t in ts]
                yield self._step(net, tuple(loop), tuple(inside), moves)

    def _step(
        self,
        net: MutableNet,
        loop: tuple[str, ...],
        inside: tuple[str, ...],
        moves: Mapping[tuple[str, str], list[str]],
    ) -> Step:
        change, merged = merging(net, loop, inside)
        idle = net.fresh_transition(f"idle({inside[0]})")
        looping = {idle: Arcs({merged: 1}, {merged: 1}, {})}
        change = replace(change, added_transitions={**change.added_transitions, **looping})
        first = {move: ts[0] for move, ts in moves.items() if move[0] in loop and move[1] in loop}
        lift = _moving_on_demand(loop, _graph(first), first, idle)
        return self.step(loop, inside, change, lift=lift, is_split=True)


def _graph(moves: Iterable[tuple[str, str]]) -> dict[str, list[str]]:
    graph: dict[str, list[str]] = {place: [] for move in moves for place in move}
    for source, target in moves:
        graph[source].append(target)
    return graph


def merging(net: MutableNet, places: tuple[str, ...], dropped: tuple[str, ...]) -> tuple[Change, str]:
    """Return the change that merges places and removes transitions, and the name of the new place."""
    merged = net.fresh_place("+".join(places))
    touched = dict.fromkeys(t for place in places for t in net.neighbours(place))
    removed = {t: net.transitions[t] for t in touched}
    names = dict.fromkeys(places, merged)
    change = Change(
        removed_places={place: net.places[place] for place in places},
        added_places={merged: sum(net.places[place] for place in places)},
        removed_transitions=removed,
        added_transitions={t: arcs.renamed(names) for t, arcs in removed.items() if t not in dropped},
    )
    return change, merged


def _moving_eagerly(source: str, mover: str) -> Lift:
    def lift(before: MutableNet, trace: list[str], _settle: bool) -> list[str]:
        result = [mover] * before.places[source]
        for t in trace:
            result += [t, *[mover] * before.transitions[t].outputs.get(source, 0)]
        return result

    return lift


def _moving_on_demand(
    loop: tuple[str, ...], graph: Mapping[str, list[str]], movers: Mapping[tuple[str, str], str], idle: str
) -> Lift:
    def lift(before: MutableNet, trace: list[str], _settle: bool) -> list[str]:
        tokens: Marking = {place: before.places[place] for place in loop}
        result: list[str] = []

        def move(path: list[str]) -> None:
            for step in pairwise(path):
                result.append(movers[step])
            tokens[path[0]] -= 1
            tokens[path[-1]] += 1

        for t in trace:
            if t == idle:
                source = next(place for place in loop if tokens[place])
                move([source, graph[source][0]])
                continue
            arcs = before.transitions[t]
            needed = {place: arcs.inputs.get(place, 0) for place in loop}
            for place in loop:
                while tokens[place] < needed[place]:
                    donor = next(other for other in loop if tokens[other] > needed[other])
                    move(shortest_path(graph, donor, place))
            for place in loop:
                tokens[place] += arcs.outputs.get(place, 0) - needed[place]
            result.append(t)
        return result

    return lift
