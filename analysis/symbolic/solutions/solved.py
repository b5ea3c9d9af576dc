"""State spaces without a search: all solutions of the place invariants, if each of them can be reached.

Every reachable marking solves the place invariants. The set S of all solutions with no negative number of
tokens is often small as a diagram where saturation meets large sets on its way, because the events of the net
touch many levels and the invariants few. S is the state space if each marking of S but the initial one has a
predecessor in S, by transitions that increase one weighted sum of tokens: then every chain of predecessors
ends, and it can only end in the initial marking.

A marking m of S has the predecessor m - change(t) in S if it holds at least the tokens that t puts: the
predecessor solves the invariants as m does, enables t, and has no negative number. Inhibitor arcs, and bounds
of places that no invariant implies, ask for some tokens at most. So the proof is a question about markings
that lie in none of some boxes, as the one for deadlocks is, and comes before S is made.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from dineros.analysis.answers.budget import Budget
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.structure import PlaceInvariant
from dineros.analysis.symbolic.boxes import Box
from dineros.analysis.symbolic.kernels import diagrams as store
from dineros.analysis.symbolic.level_starts import orders_of_spans
from dineros.analysis.symbolic.levels import Encoding, Weights, exact_invariants
from dineros.analysis.symbolic.open_boxes import Masks
from dineros.analysis.symbolic.saturation import BUCKET_SHARE, CACHE_SHARE, Diagram, DiagramMemoryError
from dineros.analysis.symbolic.solutions.distances import firing_distances, rising
from dineros.analysis.symbolic.vector_sets import Scope, VectorSets

#: Steps of preparing the box of a transition, besides one for each place that others determine.
STEPS_OF_A_BOX = 8


@dataclass(frozen=True)
class Effort:
    """What an attempt may cost.

    Attributes
    ----------
    words : int
        Words of memory for the nodes, eight or more for each.
    steps : int
        Steps in Python that prepare the constraints and the boxes.
    """

    words: int
    steps: int


@dataclass(frozen=True)
class Constraint:
    """A weighted sum of local states, ``weights[level][state]``, between two numbers (both inclusive)."""

    weights: Weights
    low: int
    high: int

    @property
    def least(self) -> int:
        """Smallest sum of any local states."""
        return sum(min(row) for row in self.weights.values())

    @property
    def most(self) -> int:
        """Largest sum of any local states."""
        return sum(max(row) for row in self.weights.values())


def solved(
    net: CompiledNet, encoding: Encoding, budget: Budget, effort: Effort
) -> tuple[Diagram | None, int]:
    """Compute the diagram of the reachable markings as the solutions of the invariants.

    Parameters
    ----------
    net
        The net of the encoding; the bounds of its places are proved.
    budget
        Its memory limits the diagram.

    Returns
    -------
    Diagram or None
        None if some solutions may not be reachable, or it costs too much.
    int
        Work, in cache misses.
    """
    flows = net.once(exact_invariants)
    if len(encoding.levels) * (len(encoding.boxes.determined) + len(flows)) > effort.steps:
        return None, 0
    limits = _implied_limits(net, flows)
    if not _implies_groups(encoding, flows):
        return None, 0
    steps = effort.steps - len(net.transitions) * (STEPS_OF_A_BOX + len(encoding.boxes.determined))
    constraints = _constraints(encoding, flows, steps) if steps >= 0 else None
    if constraints is None:
        return None, 0
    boxes = _with_predecessor(net, encoding, limits)
    spans = sorted({tuple(sorted(c.weights)) for c in constraints if len(c.weights) > 1})
    work = 0
    for order in orders_of_spans(len(encoding.levels), spans):
        attempt = _Attempt(encoding, order, budget, effort, constraints)
        try:
            if not attempt.proves(boxes):
                return None, work + attempt.diagram.effort
            attempt.make()
        except DiagramMemoryError:
            work += attempt.diagram.effort
            continue
        return attempt.diagram, work + attempt.diagram.effort
    return None, work


def _implied_limits(net: CompiledNet, flows: Sequence[PlaceInvariant]) -> dict[int, int]:
    """Return by place the most tokens in any solution without negative numbers, if it is known."""
    limits: dict[int, int] = {}
    for flow in flows:
        if min(flow.weights.values()) > 0:
            for place, weight in flow.weights.items():
                most = flow.constant // weight
                limits[place] = min(limits.get(place, most), most)
    return limits


def _implies_groups(encoding: Encoding, flows: Sequence[PlaceInvariant]) -> bool:
    """Return whether in all solutions, at most one place of each level with several places has a token."""
    ones = [flow.weights.keys() for flow in flows if flow.constant == 1 and min(flow.weights.values()) > 0]
    groups = (set(level.places) for level in encoding.levels if len(level.places) > 1)
    bounds = encoding.boxes.bounds
    return all(all(bounds[p] for p in group) and any(group <= places for places in ones) for group in groups)


def _constraints(encoding: Encoding, flows: Sequence[PlaceInvariant], steps: int) -> list[Constraint] | None:
    """Return what separates the solutions from all combinations of local states.

    The result is None if the sets of the constraints would take more than `steps` steps. A step is one sum at
    one level.
    """
    ranges = [(flow.weights, flow.constant, flow.constant) for flow in flows]
    ranges += [({place: 1}, 0, encoding.boxes.bounds[place]) for place in encoding.boxes.determined]
    found: dict[object, Constraint] = {}
    for factors, low, high in ranges:
        weights, constant = encoding.weights_of(factors)
        constraint = Constraint(weights, low - constant, high - constant)
        if constraint.least >= constraint.low and constraint.most <= constraint.high:
            continue
        rows = tuple(sorted((level, tuple(row)) for level, row in weights.items()))
        key = rows, constraint.low, constraint.high
        if key not in found:
            found[key] = constraint
            steps -= len(encoding.levels) * (1 + constraint.most - constraint.least)
        if steps < 0:
            return None
    return list(found.values())


def _with_predecessor(net: CompiledNet, encoding: Encoding, limits: Mapping[int, int]) -> list[Masks]:
    """Return products of local states whose solutions have a predecessor with a smaller weighted sum."""
    bounds = encoding.boxes.bounds
    boxes: list[Masks] = []
    for transition in rising(net, firing_distances(net)):
        change, put = net.delta[transition], dict(net.post.row(transition))
        most = {p: weight - 1 for p, weight in net.inhibitor.row(transition)}
        guard: Box = {}
        for place in {*change, *put, *most}:
            before = bounds[place]
            if limits.get(place, before + 1) <= before:
                before += max(0, -change.get(place, 0))  # no solution holds more than the bound
            high = min(bounds[place], min(before, most.get(place, before)) + change.get(place, 0))
            guard[place] = (put.get(place, 0), high)
        if any(low > high for low, high in guard.values()):
            continue
        asked = {p: interval for p, interval in guard.items() if interval != (0, bounds[p])}
        try:
            products = encoding.masks(asked)
        except ValueError:  # fewer boxes prove less
            continue
        for masks in products:
            if all(any(mask) for mask in masks.values()):
                boxes.append({level: mask for level, mask in masks.items() if not all(mask)})
    return boxes


class _Attempt:
    """The diagram of one order of the levels, with the constraints as sets.

    Parameters
    ----------
    order
        Levels, bottom first.
    constraints
        What all solutions fulfil.
    """

    def __init__(
        self,
        encoding: Encoding,
        order: Sequence[int],
        budget: Budget,
        effort: Effort,
        constraints: Sequence[Constraint],
    ) -> None:
        entries = _power_of_two(min(effort.words // 16, int(budget.memory * CACHE_SHARE) // 16))
        buckets = _power_of_two(min(effort.words // 16, int(budget.memory * BUCKET_SHARE) // 4))
        self.diagram = diagram = Diagram(encoding, order, budget.memory, entries, buckets)
        diagram.control[store.POOL_LIMIT] = min(diagram.mem.size, effort.words)
        self._sets = VectorSets(diagram, budget)
        # Constraints whose highest level is low go first: the sets between are the smallest.
        self._constraints = sorted(
            constraints, key=lambda c: max((int(diagram.position[k]) for k in c.weights), default=0)
        )

    def proves(self, boxes: Sequence[Masks]) -> bool:
        """Return whether only the initial marking is a solution in none of some boxes."""
        first = self._sets.single([level.initial for level in self.diagram.encoding.levels])
        self.diagram.pinned.append(first)
        return self._solutions(self._sets.without_boxes(self._sets.box({}), boxes)) == first

    def make(self) -> None:
        """Complete the diagram: its markings are the solutions."""
        diagram = self.diagram
        root = self._solutions(self._sets.box({}))
        diagram.control[store.POOL_LIMIT] = diagram.mem.size
        diagram.peak_nodes = diagram.nodes
        diagram.pinned.clear()
        diagram.finish(root)

    def _solutions(self, states: int) -> int:
        """Return the markings of a set that fulfil all constraints."""
        with Scope(self.diagram) as scope:
            for constraint in self._constraints:
                if not states:
                    break
                scope.hold(states)
                allowed = self._sets.sums(constraint.weights, constraint.low, constraint.high)
                scope.hold(states, allowed)
                states = self._sets.intersection(states, allowed)
        return states


def _power_of_two(most: int) -> int:
    """Return the largest power of two up to a number, at least 1024."""
    return 1 << max(10, most.bit_length() - 1)
