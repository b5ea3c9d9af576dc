"""Symbolic engine: complete state spaces as decision diagrams, any size, counted exactly."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from dineros.analysis.compiled import CompiledNet
from dineros.analysis.counting import DiagramCounts, subtract_boxes
from dineros.analysis.coverability import coverability
from dineros.analysis.level_order import OrderSearch
from dineros.analysis.levels import Encoding, UnknownBoundError, encode
from dineros.analysis.saturation import Diagram, Progress

DEFAULT_MEMORY = 2 << 30
#: Rounds of (seconds of order search, seconds of saturation): easy nets pay for little search, hard ones
#: get more.
ROUNDS = ((0.2, 0.4), (0.6, 0.8), (2.0, 1.5), (4.0, 3.0), (6.0, 5.0), (8.0, 12.0), (20.0, None))
FIRST_CAP = 4
LARGEST_CAP = 1 << 12


@dataclass
class SymbolicStateSpace:
    """The reachable markings of a net as a decision diagram.

    Attributes
    ----------
    net : CompiledNet
    complete : bool
        False when memory ended the run; then only `reason`, `order` and the figures of the run mean anything.
    reason : str
        Why it is incomplete.
    markings : int
        Number of reachable markings, exact.
    order : tuple of tuple of str
        Groups of places by level, bottom first.
    nodes, peak_nodes : int
        Nodes of the final diagram; most nodes held at any time.
    memory : int
        Bytes touched by node store, hash table and cache.
    search_seconds, saturation_seconds : float
        Time of the order search and of the successful saturation run.
    """

    net: CompiledNet
    complete: bool
    reason: str
    encoding: Encoding
    diagram: Diagram
    search_seconds: float
    saturation_seconds: float
    markings: int = 0
    nodes: int = 0
    _counts: DiagramCounts | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        self.peak_nodes = self.diagram.peak_nodes
        self.memory = self.diagram.bytes
        places, levels = self.net.places, self.encoding.levels
        self.order = tuple(tuple(places[p] for p in levels[k].places) for k in self.diagram.order)
        if self.complete:
            self._counts = DiagramCounts(self.diagram)
            self.markings = self._counts.vectors()
            self.nodes = self._counts.nodes

    @property
    def counts(self) -> DiagramCounts:
        """The diagram, ready for counting.

        Raises
        ------
        ValueError
            If the state space is incomplete.
        """
        if self._counts is None:
            raise ValueError(f"the state space is incomplete: {self.reason}")
        return self._counts

    def arcs(self) -> int:
        """Number of arcs: pairs of a reachable marking and a transition enabled in it."""
        return self.counts.in_boxes(self._event_masks())

    def enabled(self, transition: str) -> int:
        """Number of reachable markings that enable a transition (by name)."""
        number = self.net.transitions.index(transition)
        return self.counts.in_boxes(self._event_masks(number))

    def deadlocks(self) -> int | None:
        """Number of reachable markings that enable nothing; None when memory runs out."""
        counts = self.counts
        dead = subtract_boxes(self.diagram, self._event_masks())
        if not dead:
            return dead
        return counts.vectors() if dead == self.diagram.root else DiagramCounts(self.diagram, dead).vectors()

    def satisfying(self, bounds: Mapping[str, tuple[int, int | None]]) -> int:
        """Number of reachable markings whose named places hold between (fewest, most) tokens."""
        guard = {}
        for name, (low, high) in bounds.items():
            place = self.net.places.index(name)
            most = self.encoding.boxes.bounds[place]
            guard[place] = (low, most if high is None else min(high, most))
            if low > guard[place][1]:
                return 0
        return self.counts.in_boxes(self.encoding.masks(guard))

    def largest_place(self) -> tuple[int, ...]:
        """Largest number of tokens of each place, in the order of the net's places."""
        seen = self.counts.seen()
        levels, home = self.encoding.levels, self.encoding.level_of()
        answer = [0] * len(self.net.places)
        for k, level in enumerate(levels):
            for at, place in enumerate(level.places):
                answer[place] = max(level.states[i][at] for i in seen[k])
        for place, rule in self.encoding.boxes.determined.items():
            touched = {home[p] for p in rule.factors}
            weights = self._weights(rule.factors)
            if len(touched) == 1:
                (k,) = touched
                answer[place] = rule.constant + max(weights[k][i] for i in seen[k])
            else:
                answer[place] = rule.constant + self.counts.largest(weights)
        return tuple(answer)

    def largest_total(self) -> int:
        """Largest number of tokens of a reachable marking."""
        factors = dict.fromkeys(self.encoding.boxes.kept, 1)
        constant = 0
        for rule in self.encoding.boxes.determined.values():
            constant += rule.constant
            for place, factor in rule.factors.items():
                factors[place] += factor
        return constant + self.counts.largest(self._weights(factors))

    def _weights(self, factors: Mapping[int, int]) -> list[list[int]]:
        return [
            [
                sum(factors.get(p, 0) * n for p, n in zip(level.places, state, strict=True))
                for state in level.states
            ]
            for level in self.encoding.levels
        ]

    def _event_masks(self, transition: int | None = None) -> list[dict[int, Sequence[bool]]]:
        return [
            {k: [j >= 0 for j in table] for k, table in event.tables.items() if min(table) < 0}
            for event in self.encoding.events
            if transition is None or event.transition == transition
        ]


def symbolic_state_space(
    net: CompiledNet,
    memory: int = DEFAULT_MEMORY,
    progress: Callable[[Progress], None] | None = None,
    seed: int = 1,
    order: Sequence[Sequence[str]] | None = None,
) -> SymbolicStateSpace:
    """Compute the complete state space of a net with decision diagrams.

    Parameters
    ----------
    net
        The net; its places must be bounded.
    memory
        Bytes that the diagram may take. Running into it gives a result with ``complete=False``.
    progress
        Called now and then; an exception raised in it ends the run.
    seed
        Of the order search.
    order
        A known order (`SymbolicStateSpace.order` of an earlier run on a net of the same structure), tried
        first.

    Raises
    ------
    UnknownBoundError
        If the net is unbounded, or some place still grows at the largest cap tried; it names the places.

    Examples
    --------
    >>> net = CompiledNet.build({"a": 2, "b": 0}, [("t", {"a": 1}, {"b": 1})])
    >>> space = symbolic_state_space(net)
    >>> space.markings, space.arcs(), space.deadlocks(), space.largest_place()
    (3, 2, 1, (2, 2))
    """
    gain = max((tokens for change in net.delta for tokens in change.values()), default=0)
    caps: list[int] | None = None
    while True:
        try:
            encoding = encode(net, caps)
        except UnknownBoundError:
            covered = coverability(net)
            if covered.pumping is not None:
                raise UnknownBoundError([net.places[p] for p in covered.pumping.places]) from None
            caps = [FIRST_CAP + int(tokens) for tokens in net.initial]
            if covered.bounds is not None:
                caps = [int(bound) + gain for bound in covered.bounds]
            continue
        space = _with_encoding(net, encoding, memory, progress, seed, order)
        if caps is None or not space.complete:
            return space
        largest = space.largest_place()
        capped = [
            p for p, bound in enumerate(encoding.bounds) if bound is None and largest[p] + gain > caps[p]
        ]
        if not capped:
            return space
        if max(caps[p] for p in capped) >= LARGEST_CAP:
            raise UnknownBoundError([net.places[p] for p in capped])
        for p in capped:
            caps[p] = 2 * caps[p] + gain


def _with_encoding(
    net: CompiledNet,
    encoding: Encoding,
    memory: int,
    progress: Callable[[Progress], None] | None,
    seed: int,
    known: Sequence[Sequence[str]] | None,
) -> SymbolicStateSpace:
    began = time.perf_counter()
    search = OrderSearch(encoding, seed)
    order = _known_order(net, encoding, known) if known is not None else None
    diagram: Diagram | None = None
    searched = time.perf_counter() - began
    for search_seconds, run_seconds in ROUNDS:
        began = time.perf_counter()
        if order is None:
            search.improve(search_seconds)
            order = search.order
        searched += time.perf_counter() - began
        began = time.perf_counter()
        if diagram is None:
            diagram = Diagram(encoding, order, memory)
        else:
            diagram.restart(order)
        deadline = None if run_seconds is None else began + run_seconds
        if diagram.run(progress, deadline=deadline):
            break
        order = None
    assert diagram is not None
    seconds = time.perf_counter() - began
    return SymbolicStateSpace(
        net, diagram.complete, "" if diagram.complete else "memory", encoding, diagram, searched, seconds
    )


def _known_order(net: CompiledNet, encoding: Encoding, known: Sequence[Sequence[str]]) -> list[int] | None:
    by_places = {tuple(net.places[p] for p in level.places): k for k, level in enumerate(encoding.levels)}
    order = [by_places.get(tuple(group), -1) for group in known]
    return order if sorted(order) == list(range(len(encoding.levels))) else None
