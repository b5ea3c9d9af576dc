"""What reductions claim, checked on whole reachability graphs in plain Python."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import networkx as nx

from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.coverability import coverability
from dineros.analysis.reductions import MutableNet, Property, Reduction, replay
from dineros.analysis.reductions.net import Marking
from dineros.analysis.reductions.rule import Step

Tokens = tuple[int, ...]
#: A step that somebody who looks at observed elements sees: the transition, if observed, and the observed
#: tokens after it.
Visible = tuple[str | None, Tokens]

LIMIT = 300
LARGEST_LANGUAGE = 2_000


@dataclass
class Graph:
    """A reachability graph, or the part of it that was seen first."""

    net: CompiledNet
    successors: dict[Tokens, dict[str, Tokens]]
    is_complete: bool

    @classmethod
    def of(cls, net: CompiledNet, limit: int = LIMIT) -> Graph:
        start = tuple(net.initial.tolist())
        successors: dict[Tokens, dict[str, Tokens]] = {}
        todo = deque([start])
        seen = {start}
        while todo and len(seen) <= limit:
            marking = todo.popleft()
            row = {
                name: tuple(net.fire(t, marking))
                for t, name in enumerate(net.transitions)
                if net.is_enabled(t, marking)
            }
            successors[marking] = row
            for target in row.values():
                if target not in seen:
                    seen.add(target)
                    todo.append(target)
        return cls(net, successors, not todo)

    @property
    def initial(self) -> Tokens:
        return tuple(self.net.initial.tolist())

    def projected(self, places: Iterable[str]) -> set[Tokens]:
        positions = [self.net.places.index(place) for place in places]
        return {tuple(marking[p] for p in positions) for marking in self.successors}

    def deadlocks(self) -> list[Tokens]:
        return [marking for marking, row in self.successors.items() if not row]

    def trace_to(self, goal: Tokens) -> list[str]:
        origin: dict[Tokens, tuple[Tokens, str] | None] = {self.initial: None}
        todo = deque([self.initial])
        while goal not in origin:
            marking = todo.popleft()
            for t, target in self.successors.get(marking, {}).items():
                if target not in origin:
                    origin[target] = (marking, t)
                    todo.append(target)
        trace: list[str] = []
        while (step := origin[goal]) is not None:
            goal = step[0]
            trace.append(step[1])
        return trace[::-1]

    def is_live(self) -> bool:
        graph: nx.DiGraph[Tokens] = nx.DiGraph()
        graph.add_nodes_from(self.successors)
        graph.add_edges_from((m, target) for m, row in self.successors.items() for target in row.values())
        return all(
            {t for marking in end for t in self.successors[marking]} == set(self.net.transitions)
            for end in nx.attracting_components(graph)
        )


class Language:
    """Runs as an observer sees them, by the subset construction.

    Two finite graphs have the same maximal runs up to stuttering iff the same visible steps are possible
    after the same visible steps, and the same of those can be the last ones (the run stops, or continues
    unseen forever): a run with endlessly many visible steps exists as soon as all its prefixes do, since the
    graphs are finite.
    """

    def __init__(self, graph: Graph, places: Iterable[str], transitions: Iterable[str]) -> None:
        self._graph = graph
        self._positions = [graph.net.places.index(place) for place in places]
        self._observed = frozenset(transitions)

    def _step(self, marking: Tokens, t: str, target: Tokens) -> Visible | None:
        before, after = (tuple(m[p] for p in self._positions) for m in (marking, target))
        if t in self._observed:
            return t, after
        return (None, after) if before != after else None

    def start(self) -> frozenset[Tokens]:
        return self._closed({self._graph.initial})

    def first_label(self) -> Tokens:
        return tuple(self._graph.initial[p] for p in self._positions)

    def _closed(self, markings: set[Tokens]) -> frozenset[Tokens]:
        seen, todo = set(markings), list(markings)
        while todo:
            marking = todo.pop()
            for t, target in self._graph.successors[marking].items():
                if target not in seen and self._step(marking, t, target) is None:
                    seen.add(target)
                    todo.append(target)
        return frozenset(seen)

    def can_end(self, markings: frozenset[Tokens]) -> bool:
        if any(not self._graph.successors[marking] for marking in markings):
            return True
        silent: nx.DiGraph[Tokens] = nx.DiGraph()
        for marking in markings:
            for t, target in self._graph.successors[marking].items():
                if self._step(marking, t, target) is None:
                    silent.add_edge(marking, target)
        return not nx.is_directed_acyclic_graph(silent)

    def moves(self, markings: frozenset[Tokens]) -> dict[Visible, frozenset[Tokens]]:
        targets: dict[Visible, set[Tokens]] = {}
        for marking in markings:
            for t, target in self._graph.successors[marking].items():
                step = self._step(marking, t, target)
                if step is not None:
                    targets.setdefault(step, set()).add(target)
        return {step: self._closed(after) for step, after in targets.items()}


def same_language(one: Language, other: Language) -> bool | None:
    """Whether two languages are equal; None when that takes too long."""
    if one.first_label() != other.first_label():
        return False
    first = (one.start(), other.start())
    seen, todo = {first}, [first]
    while todo:
        if len(seen) > LARGEST_LANGUAGE:
            return None
        left, right = todo.pop()
        moves, others = one.moves(left), other.moves(right)
        if moves.keys() != others.keys() or one.can_end(left) != other.can_end(right):
            return False
        for step, target in moves.items():
            pair = (target, others[step])
            if pair not in seen:
                seen.add(pair)
                todo.append(pair)
    return True


def check(reduction: Reduction) -> None:
    """Assert everything that a reduction says it preserves."""
    before, after = Graph.of(reduction.original), Graph.of(reduction.net)
    preserved = reduction.preserves
    assert reduction.question.preserve <= preserved
    if Property.STATE_SPACE_SIZE in preserved:
        assert all(
            reduction.weight(dict(zip(reduction.net.places, marking, strict=True))) == reduction.count_factor
            for marking in after.successors
        )
    if Property.MARKINGS in preserved:
        _check_counting(reduction, before, after)
    if Property.KEPT_PLACES in preserved:
        kept = reduction.kept_places
        if after.is_complete:
            assert before.projected(kept) <= after.projected(kept)
        if before.is_complete:
            assert after.projected(kept) <= before.projected(kept)
    if Property.BOUNDEDNESS in preserved and before.is_complete and not before.net.inhibitor.place.size:
        assert Graph.of(reduction.net, 20 * LIMIT).is_complete
    if Property.BOUNDEDNESS in preserved and after.is_complete:
        assert coverability(reduction.original, limit=LIMIT).is_bounded is not False
    if before.is_complete and after.is_complete:
        if Property.DEADLOCKS in preserved:
            assert bool(before.deadlocks()) == bool(after.deadlocks())
        if Property.LIVENESS in preserved:
            assert before.is_live() == after.is_live()
        if Property.LTL_WITHOUT_NEXT in preserved:
            question = reduction.question
            observed = sorted(question.observed_places), sorted(question.observed_transitions)
            assert same_language(Language(before, *observed), Language(after, *observed)) is not False
    _check_expansion(reduction, after)


def _check_counting(reduction: Reduction, before: Graph, after: Graph) -> None:
    if not after.is_complete:
        return
    markings = [dict(zip(reduction.net.places, marking, strict=True)) for marking in after.successors]
    count = sum(map(reduction.weight, markings))
    if count > LIMIT:
        before = Graph.of(reduction.original, count)
    assert before.is_complete and len(before.successors) == count
    recovered = {
        tuple(original.values()) for marking in markings for original in markings_of(reduction, marking)
    }
    assert recovered == set(before.successors)
    if Property.DEADLOCKS in reduction.preserves:
        assert len(before.deadlocks()) == len(after.deadlocks()) * reduction.deadlock_factor


def _check_expansion(reduction: Reduction, after: Graph) -> None:
    original = MutableNet.of(reduction.original)
    deadlocks = after.deadlocks()
    for goal in [*islice(reversed(after.successors), 8), *deadlocks[:4]]:
        trace = after.trace_to(goal)
        until_deadlock = goal in deadlocks and Property.DEADLOCKS in reduction.preserves
        marking = replay(original, reduction.expand(trace))
        if Property.KEPT_PLACES in reduction.preserves:
            end = dict(zip(reduction.net.places, goal, strict=True))
            assert all(marking[place] == end[place] for place in reduction.kept_places)
        if until_deadlock:
            final = replay(original, reduction.expand(trace, until_deadlock=True))
            assert not any(original.is_enabled(t, final) for t in original.transitions)


def markings_of(reduction: Reduction, marking: Marking) -> Iterator[Marking]:
    """Yield the original markings that a reachable marking of the reduced net represents."""
    for before in _before(reduction.steps, dict(marking)):
        yield {place: before[place] for place in reduction.original.places}


def _before(steps: Sequence[Step], marking: Marking) -> Iterator[Marking]:
    if not steps:
        yield marking
        return
    for before in _before_one(steps[-1], marking):
        yield from _before(steps[:-1], before)


def _before_one(step: Step, marking: Marking) -> Iterator[Marking]:
    if step.equation is not None:
        yield {**marking, step.equation.place: step.equation.value(marking)}
    elif step.is_split:
        (merged,) = step.change.added_places
        for tokens in _splits(marking[merged], len(step.places)):
            yield {**marking, **dict(zip(step.places, tokens, strict=True))}
    else:
        for part in step.component or ({},):
            yield {**marking, **part}


def _splits(tokens: int, places: int) -> Iterator[tuple[int, ...]]:
    """Yield all ways to distribute tokens among places."""
    if places == 1:
        yield (tokens,)
        return
    for first in range(tokens + 1):
        for rest in _splits(tokens - first, places - 1):
            yield first, *rest
