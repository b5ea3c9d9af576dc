"""A lower bound of the distance to a goal by the state equation; it guides the search for a shortest trace.

A way from marking m to a goal fires transitions x with ``m + C x`` in the goal. Relaxed to fractions, the
least ``sum x`` is a linear program, and each solution of its dual bounds it from below for every m at once:
``h(m) = value - weights m``, where no firing lowers h by more than 1. The *cost* of a firing is 1 minus the
decrease of h; it is never negative. As the costs of a way add up to its length less the decrease of h, a
search that takes markings in the order of their costs is A* led by h, and what lies
off the way costs too much to be seen.

`dineros.analysis.covering.distance` bounds the same way for nets without bounds: there many programs are
solved for one target, from marking to marking; here one, for any conjunction, whose weights must be whole.

References
----------
P. E. Hart, N. J. Nilsson, B. Raphael, *A formal basis for the heuristic determination of minimum cost paths*,
IEEE Transactions on Systems Science and Cybernetics 4(2), 1968. M. Blondin, C. Haase, P. Offtermatt,
*Directed reachability for infinite-state systems*, TACAS 2021, LNCS 12652 (the state equation as the bound).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from dineros.analysis.explicit.goals import Comparison, Constraint, Goal, normalized
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.linear_programs import LinearProgram, in_whole_numbers

#: Least bound in the initial marking for a guided search: nearer goals are found at once.
LEAST_BOUND = 4
#: Maximum number of different costs: for each, markings are examined once more.
MOST_COSTS = 24
#: Maximum number of entries of the program's matrix examined: a second at most.
MOST_WORK = 100_000_000


@dataclass(frozen=True)
class Guidance:
    """A lower bound of the number of missing firings, in fractions `unit` of a firing.

    Attributes
    ----------
    goal : tuple of Comparison
        The goal, as one conjunction.
    weights : mapping
        Place -> weight.
    value : int
        The bound of marking m is ``value - weights m``; at most 0 in the goal.
    unit : int
        The value of one firing.
    """

    net: CompiledNet
    goal: tuple[Comparison, ...]
    weights: Mapping[int, int]
    value: int
    unit: int

    @cached_property
    def costs(self) -> tuple[int, ...]:
        """For each transition, `unit` minus the decrease of the bound by its firing; at least 0."""
        return tuple(self.unit - self._weighted(change) for change in self.net.delta)

    def bound(self, marking: Sequence[int]) -> int:
        """Return a lower bound of the missing firings, in fractions of a firing."""
        return self.value - self._weighted(dict(enumerate(marking)))

    def nearer(self, excess: int) -> Goal:
        """Return the goal restricted to markings whose bound is less than `excess` below 0."""
        return Goal(conjunctions=((*self.goal, Comparison(self.weights, "<", self.value + excess)),))

    def _weighted(self, tokens: Mapping[int, int]) -> int:
        return sum(self.weights.get(place, 0) * int(number) for place, number in tokens.items())


def guidance(net: CompiledNet, goal: Goal) -> Guidance | None:
    """Return the bound with the highest value in the initial marking.

    None if there is none in integers, the goal is near, is no conjunction, or is excluded.
    """
    alternatives = goal.alternatives(net)
    constraints = normalized(Goal(conjunctions=tuple(alternatives)))
    if len(alternatives) != 1 or len(constraints) != 1:
        return None
    (conjunction,), (terms,) = alternatives, constraints
    found = _dual(net, terms)
    if found is None:
        return None
    factors, unit = in_whole_numbers(found)
    weights = dict(enumerate(factors[len(terms) :]))
    value = 0
    for factor, (term, least) in zip(factors, terms, strict=False):
        value += factor * least
        for place, weight in term:
            weights[place] += factor * weight
    made = Guidance(net, conjunction, {place: w for place, w in weights.items() if w}, value, unit)
    # The program was solved in floating point; the search relies on these exact conditions.
    is_bound = all(number >= 0 for number in (*factors, *made.costs))
    is_useful = made.bound(net.initial.tolist()) >= LEAST_BOUND * unit and len(set(made.costs)) <= MOST_COSTS
    return made if is_bound and is_useful else None


def _dual(net: CompiledNet, constraints: Sequence[Constraint]) -> list[float] | None:
    """Return non-negative factors of the constraints and of the places with the largest bound.

    No firing decreases the bound by more than 1. None if the bound is infinite, as the state equation
    excludes the goal.
    """
    first = len(constraints)
    rows = []
    for change in net.delta:
        row = {first + place: float(tokens) for place, tokens in change.items()}
        for i, (terms, _) in enumerate(constraints):
            raised = sum(weight * change.get(place, 0) for place, weight in terms)
            if raised:
                row[i] = float(raised)
        rows.append(row)
    marking = net.initial.tolist()
    missing = [
        least - sum(weight * marking[place] for place, weight in terms) for terms, least in constraints
    ]
    costs = np.array([*(-number for number in missing), *marking], dtype=np.float64)
    size = len(costs)
    program = LinearProgram(rows, size, MOST_WORK)
    return program.solve(costs, np.ones(len(rows)), np.zeros(size), np.full(size, np.inf))
