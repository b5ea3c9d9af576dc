"""Symbolic engine: complete state spaces as decision diagrams, of any size, counted exactly."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import prod

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.nets.bounds import FlowsAndBounds, flows_and_bounds, renumbered
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.coverability import coverability
from dineros.analysis.symbolic.canonical import arranged
from dineros.analysis.symbolic.counting import DiagramCounts
from dineros.analysis.symbolic.level_order import OrderSearch
from dineros.analysis.symbolic.levels import Encoding, LocalEvent, UnknownBoundError, encode
from dineros.analysis.symbolic.merging import masks_of, masks_of_tests
from dineros.analysis.symbolic.order_cache import OrderCache
from dineros.analysis.symbolic.saturation import Diagram, DiagramMemoryError
from dineros.analysis.symbolic.solutions.solved import Effort, solved
from dineros.analysis.symbolic.stages.staged import MOST_WORK, staged
from dineros.analysis.symbolic.vector_sets import VectorSets

#: Rounds of (work of the order search, work of saturation), in cache misses: easy nets need little search,
#: hard ones get more. A million takes about a third of a second. No clock is used, so that runs are
#: reproducible. The first round improves the best of the orders made from the structure by a few moves
#: (milliseconds). The second round tries more, because a long run under a bad order costs more than this
#: search.
ROUNDS = (
    (5_000, 100_000),
    (50_000, 400_000),
    (300_000, 800_000),
    (2_000_000, 2_500_000),
    (6_000_000, 4_000_000),
    (12_000_000, 6_000_000),
    (12_000_000, 8_000_000),
    (12_000_000, 15_000_000),
    (24_000_000, 40_000_000),
    (60_000_000, None),
)
#: Round before which the orders with the shortest spans are run, and work of saturation for each of them. The
#: small instance that compares orders may be wrong about them.
SHORTEST_ROUND, SHORTEST_WORK = 3, 500_000
#: Rounds before which the order with wide levels at the top is run, and work of saturation for it: little
#: before the orders of short searches have failed. The race may end before this order pays.
WIDE_ROUNDS = {1: 100_000, 3: 2_000_000}
#: Rounds before which the state space is tried in stages, if the levels fall into components that share some,
#: and the work allowed: if they share few levels, and if they share more. Then, orders are often cheaper.
STAGED_ROUNDS = {1: (MOST_WORK, 16_000_000), 4: (0, MOST_WORK)}
#: Rounds before which the state space is sought among the solutions of the invariants, and what it may cost.
SOLVED_ROUNDS = {
    1: Effort(4_000_000, 10_000),
    4: Effort(40_000_000, 50_000),
    6: Effort(40_000_000, 300_000),
}
#: Part of the memory for both: the diagram of the orders tried so far stays.
STAGED_MEMORY = 3 / 4
#: An order that a search did not improve gets the work of this many rounds later.
UNCHANGED_ROUNDS = 1
#: While no order of the search has finished, a round searches for this part of its work only.
BLIND_PART = 4
#: First round in which an order that costs too much on a smaller instance is not run.
FIRST_DOUBT = 2
#: Work allowed to an order known from an earlier run, before a search for another one starts.
KNOWN_ORDER_WORK = 30_000_000
#: Least work of a search whose order is kept in a file.
WORTH_KEEPING = sum(work for work, _ in ROUNDS[:4])
#: Number of orders that may run out of memory before the engine gives up.
MEMORY_TRIES = 2
FIRST_CAP = 4
LARGEST_CAP = 1 << 12

Between = Callable[[int], None]


@dataclass
class SymbolicStateSpace:
    """The reachable markings of a net as a decision diagram.

    Attributes
    ----------
    net : CompiledNet
    complete : bool
        False if memory ended the run; then only `reason`, `order` and the statistics of the run are valid.
    markings : int
        Number of reachable markings, exact.
    order : tuple of tuple of str
        Groups of places by level, bottom first.
    peak_nodes : int
        Largest number of nodes at any time.
    search_work : int
        Cost of the order search, in cache misses of saturation.
    """

    net: CompiledNet
    complete: bool
    reason: str
    encoding: Encoding
    diagram: Diagram
    search_work: int
    markings: int = 0
    _counts: DiagramCounts | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        self.peak_nodes = self.diagram.peak_nodes
        places, levels = self.net.places, self.encoding.levels
        self.order = tuple(tuple(places[p] for p in levels[k].places) for k in self.diagram.order)
        if self.complete:
            try:
                self._counts = DiagramCounts(self.diagram)
            except DiagramMemoryError:
                self.complete, self.reason = False, "memory"
                return
            self.markings = self._counts.vectors()

    @property
    def counts(self) -> DiagramCounts:
        """The diagram, prepared for counting.

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
        return self.counts.in_boxes(self.event_masks())

    def enabled(self, transition: str) -> int:
        """Number of reachable markings that enable a transition (by name)."""
        number = self.net.transitions.index(transition)
        return self.counts.in_boxes(self.event_masks(number))

    def deadlocks(self) -> int | None:
        """Number of reachable markings that enable no transition; None if memory runs out."""
        counts = self.counts
        try:
            dead = self.sets.without_boxes(self.diagram.root, self.event_masks())
            if dead in (0, self.diagram.root):
                return counts.vectors() if dead else 0
            return DiagramCounts(self.diagram, dead).vectors()
        except DiagramMemoryError:
            return None

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
        answer = [0] * len(self.net.places)
        for k, level in enumerate(self.encoding.levels):
            for at, place in enumerate(level.places):
                answer[place] = max(level.states[i][at] for i in seen[k])
        for place, rule in self.encoding.boxes.determined.items():
            weights, _ = self.encoding.weights_of(rule.factors)
            if len(weights) == 1:
                ((k, row),) = weights.items()
                answer[place] = rule.constant + max(row[i] for i in seen[k])
            else:
                answer[place] = rule.constant + self.counts.largest(weights)
        return tuple(answer)

    def is_stable(self, place: int) -> bool:
        """Return whether a place (by number) holds the same number of tokens in all markings."""
        most: list[int] = []
        for sign in (1, -1):
            weights, constant = self.encoding.weights_of({place: sign})
            most.append(constant + self.counts.largest(weights))
        return most[0] == -most[1]

    def largest_total(self) -> int:
        """Largest number of tokens of a reachable marking."""
        weights, constant = self.encoding.weights_of(dict.fromkeys(range(len(self.net.places)), 1))
        return constant + self.counts.largest(weights)

    def weighted(self, weights: Mapping[str, Callable[[int], int]]) -> int:
        """Sum over the reachable markings of the product of weights, each of the tokens in a named place.

        Raises
        ------
        ValueError
            If such a place belongs to no level.
        """
        by_place = {self.net.places.index(name): weight for name, weight in weights.items()}
        if not self.encoding.boxes.determined.keys().isdisjoint(by_place):
            raise ValueError("places with weights must be kept")
        return self.counts.weighted(
            [
                [
                    prod(by_place[p](n) for p, n in zip(level.places, state, strict=True) if p in by_place)
                    for state in level.states
                ]
                for level in self.encoding.levels
            ]
        )

    def marking_of(self, vector: Sequence[int]) -> list[int]:
        """Tokens of every place, from local states in the order of the encoding's levels."""
        tokens: dict[int, int] = {}
        for level, state in zip(self.encoding.levels, vector, strict=True):
            tokens.update(zip(level.places, level.states[state], strict=True))
        return self.encoding.boxes.full_marking(tokens)

    @cached_property
    def sets(self) -> VectorSets:
        """Operations on sets of markings."""
        return VectorSets(self.diagram)

    def event_masks(self, transition: int | None = None) -> list[dict[int, Sequence[bool]]]:
        """Markings that enable a transition, or any transition, as disjoint products (level -> flags)."""
        if transition is None:
            return self._masks_of_all
        return masks_of(event.tables for event in self._events_of.get(transition, ()))

    @cached_property
    def _masks_of_all(self) -> list[dict[int, Sequence[bool]]]:
        return masks_of_tests(event.tables for event in self.encoding.events)

    @cached_property
    def _events_of(self) -> dict[int, list[LocalEvent]]:
        """Events by transition number of the net."""
        found: defaultdict[int, list[LocalEvent]] = defaultdict(list)
        for event in self.encoding.events:
            found[event.transition].append(event)
        return found


def symbolic_state_space(
    net: CompiledNet,
    budget: Budget = UNLIMITED,
    seed: int = 1,
    order: Sequence[Sequence[str]] | None = None,
    orders: OrderCache | None = None,
    keep: Collection[str] = (),
    between: Between | None = None,
    facts: FlowsAndBounds | None = None,
) -> SymbolicStateSpace:
    """Compute the complete state space of a net with decision diagrams.

    Parameters
    ----------
    net
        The net; its places must be bounded.
    budget
        If its memory, which also limits the diagram, runs out, the result has ``complete=False``.
    order
        A known order (`SymbolicStateSpace.order` of an earlier run on a net of the same structure), tried
        first.
    orders
        Cache of orders: an order for a net of the same structure is tried first, and an order that took long
        to find is kept.
    keep
        Places that must belong to a level even if others determine them: those with weights in `weighted`.
    between
        Called before the first run of saturation and after each unfinished run, with the cost so far of all
        runs and of the order search, in cache misses. An exception raised in it ends the work.
    facts
        Semiflows of the net and bounds of its places, if they are known; they are not checked.

    Raises
    ------
    UnknownBoundError
        If the net is unbounded, or some place still grows at the largest cap tried; it names the places.
    LevelSizeError
        The local states of places that may hold many tokens exceed the memory.
    BudgetExceededError
        If time runs out.

    Examples
    --------
    >>> net = CompiledNet.build({"a": 2, "b": 0}, [("t", {"a": 1}, {"b": 1})])
    >>> space = symbolic_state_space(net)
    >>> space.markings, space.arcs(), space.deadlocks(), space.largest_place()
    (3, 2, 1, (2, 2))
    """
    if order is None and orders is not None:
        order = orders.order(net)
    arrangement = arranged(net)
    if facts is not None:
        number = {place: number for number, place in enumerate(arrangement.places)}
        arrangement.net.know(flows_and_bounds, renumbered(facts, number))
    kept = [arrangement.net.places.index(name) for name in keep]
    space = _with_bounds(arrangement.net, budget.begun(), seed, order, kept, between)
    space.encoding = space.diagram.encoding = space.encoding.renumbered(
        net, arrangement.places, arrangement.transitions
    )
    space.net = net
    if orders is not None and space.complete and space.search_work > WORTH_KEEPING:
        orders.keep(net, space.order)
    return space


def _with_bounds(
    net: CompiledNet,
    budget: Budget,
    seed: int,
    order: Sequence[Sequence[str]] | None,
    keep: Collection[int],
    between: Between | None,
) -> SymbolicStateSpace:
    """Compute the state space; places without known bounds get caps, raised until no marking reaches them."""
    gain = max((tokens for change in net.delta for tokens in change.values()), default=0)
    caps: list[int] | None = None
    while True:
        budget.stage("bounds of places")
        budget.check_time()
        try:
            encoding = encode(net, caps, budget.memory, keep)
        except UnknownBoundError:
            budget.stage("coverability")
            covered = coverability(net, budget=budget, only_boundedness=True)
            if covered.pumping is not None:
                raise UnknownBoundError([net.places[p] for p in covered.pumping.places]) from None
            caps = [FIRST_CAP + int(tokens) for tokens in net.initial]
            if covered.bounds is not None:
                caps = [int(bound) + gain for bound in covered.bounds]
            continue
        space = _with_encoding(net, encoding, budget, seed, order, between)
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
    budget: Budget,
    seed: int,
    known: Sequence[Sequence[str]] | None,
    between: Between | None,
) -> SymbolicStateSpace:
    budget.stage("the order of levels")
    budget.check_time()
    diagram = Diagram(encoding, range(len(encoding.levels)), budget.memory)
    search = OrderSearch(encoding, diagram.events, seed, budget.memory // 8, budget.report)
    failures = work = 0
    if between is not None:
        between(work)
    for order, limit in _attempts(search, _known_order(net, encoding, known), known is not None):
        if isinstance(order, Effort):
            if any(bound is None for bound in encoding.bounds):
                continue
            budget.stage("solutions of the invariants")
            of_invariants, cost = solved(net, encoding, budget.share(memory=STAGED_MEMORY), order)
            search.work += cost
            if of_invariants is not None:
                diagram = of_invariants
                break
            continue
        if not isinstance(order, list):
            budget.stage("saturation in stages")
            in_stages, cost = staged(encoding, int(budget.memory * STAGED_MEMORY), budget.report, order)
            search.work += cost
            if in_stages is not None:
                diagram, encoding = in_stages, in_stages.encoding
                break
            continue
        if tuple(order) != diagram.order or diagram.out_of_memory:
            diagram.restart(order)
        before = diagram.effort
        budget.stage("saturation")
        is_complete = diagram.run(budget.report, limit)
        budget.stage("the order of levels")
        failures += diagram.out_of_memory
        if is_complete or failures == MEMORY_TRIES:
            break
        work += diagram.effort - before
        if between is not None:
            between(search.work + work)
    reason = "" if diagram.complete else "memory"
    budget.stage("counting markings")
    return SymbolicStateSpace(net, diagram.complete, reason, encoding, diagram, search.work)


def _attempts(
    search: OrderSearch, known: list[int] | None, is_known: bool
) -> Iterator[tuple[list[int] | tuple[int, int] | Effort, int | None]]:
    """Yield orders to run, each with its allowed work: the known order, then results of longer searches.

    A pair instead of an order: the state space in stages, with this allowed work. An effort: the solutions of
    the invariants. An order that is known but
    not of these levels is one of joined levels.
    """
    if known is not None:
        yield known, KNOWN_ORDER_WORK
    elif is_known:
        yield (MOST_WORK, MOST_WORK), None
    if search.good_effort is not None:
        yield search.order, search.good_effort
    search.race()
    last = None
    for number, (search_work, _) in enumerate(ROUNDS):
        if number in SOLVED_ROUNDS:
            yield SOLVED_ROUNDS[number], None
        if number in STAGED_ROUNDS and not (is_known and known is None):
            yield STAGED_ROUNDS[number], None
        if number in WIDE_ROUNDS and (order_by_width := search.wide_on_top) is not None:
            yield order_by_width, WIDE_ROUNDS[number]
        for order in search.shortest if number == SHORTEST_ROUND else ():
            yield order, SHORTEST_WORK
        search.improve(search_work // BLIND_PART if search.is_blind else search_work)
        order = search.order
        ahead = UNCHANGED_ROUNDS if order == last else 0
        limit = ROUNDS[min(number + ahead, len(ROUNDS) - 1)][1]
        if number < FIRST_DOUBT or limit is None or search.is_promising(limit):
            last = order
            yield order, limit


def _known_order(
    net: CompiledNet, encoding: Encoding, known: Sequence[Sequence[str]] | None
) -> list[int] | None:
    if known is None:
        return None
    by_places = {tuple(net.places[p] for p in level.places): k for k, level in enumerate(encoding.levels)}
    order = [by_places.get(tuple(group), -1) for group in known]
    return order if sorted(order) == list(range(len(encoding.levels))) else None
