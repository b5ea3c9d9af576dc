"""How far a marking is from a goal at least, by the state equation: it leads the search for a shortest way.

A way from marking m to a goal fires transitions x with ``m + C x`` in the goal. Relaxed to fractions, the
least ``sum x`` is a linear program, and each solution of its dual bounds it from below for every m at once:
``h(m) = value - weights m``, where no firing lowers h by more than 1. What a firing falls short of that is
its *cost*; it is never negative. As the costs of a way add up to its length less what h has fallen by, a
search that takes markings in the order of their costs is A* led by h, and what lies off the way costs too
much to be seen.

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
from dineros.analysis.nets.linear_programs import LinearProgram

#: Steps that a bound must see for the search to be led: nearer goals are found at once.
LEAST_BOUND = 4
#: Common denominators of weights that are tried.
DENOMINATORS = (1, 2, 3, 4, 6, 8, 12)
#: Different costs, each of which has markings looked at once more.
MOST_COSTS = 24
#: Entries of the program's matrix that may be looked at: a second at most.
MOST_WORK = 100_000_000
NEARLY_WHOLE = 1e-6


@dataclass(frozen=True)
class Guidance:
    """A lower bound on the firings that are missing, in parts of `unit`.

    Attributes
    ----------
    goal : tuple of Comparison
        What is looked for, as one conjunction.
    weights : mapping
        Place -> weight.
    value : int
        The bound of marking m is ``value - weights m``; 0 or less in the goal.
    unit : int
        What one firing counts.
    """

    net: CompiledNet
    goal: tuple[Comparison, ...]
    weights: Mapping[int, int]
    value: int
    unit: int

    @cached_property
    def costs(self) -> tuple[int, ...]:
        """By transition: `unit` less what firing it lowers the bound by; 0 or more."""
        return tuple(self.unit - self._weighted(change) for change in self.net.delta)

    def bound(self, marking: Sequence[int]) -> int:
        """Return the parts of a firing that are missing at least."""
        return self.value - self._weighted(dict(enumerate(marking)))

    def nearer(self, excess: int) -> Goal:
        """Return the goal, cut down to markings in which the bound is less than this below 0."""
        return Goal(conjunctions=((*self.goal, Comparison(self.weights, "<", self.value + excess)),))

    def _weighted(self, tokens: Mapping[int, int]) -> int:
        return sum(self.weights.get(place, 0) * int(number) for place, number in tokens.items())


def guidance(net: CompiledNet, goal: Goal) -> Guidance | None:
    """Return the bound that sees the most firings from the initial marking.

    None where there is none in small whole numbers, or the goal is near, or no conjunction, or excluded.
    """
    conjunction = _conjunction(net, goal)
    constraints = normalized(Goal(conjunctions=(conjunction,))) if conjunction else []
    if len(constraints) != 1:
        return None
    found = _dual(net, constraints[0])
    for unit in DENOMINATORS if found is not None else ():
        exact = np.array(found) * unit
        whole = np.rint(exact)
        if np.abs(exact - whole).max() < NEARLY_WHOLE:
            break
    else:
        return None
    factors = [int(factor) for factor in whole]
    weights = {place: factor for place, factor in enumerate(factors[len(constraints[0]) :]) if factor}
    value = 0
    for factor, (terms, least) in zip(factors, constraints[0], strict=False):
        value += factor * least
        for place, weight in terms:
            weights[place] = weights.get(place, 0) + factor * weight
    made = Guidance(
        net, conjunction, {place: weight for place, weight in weights.items() if weight}, value, unit
    )
    # The program was solved in floating point: here is what the search rests on.
    is_bound = min(factors) >= 0 and min(made.costs) >= 0
    is_useful = made.bound(net.initial.tolist()) >= LEAST_BOUND * unit and len(set(made.costs)) <= MOST_COSTS
    return made if is_bound and is_useful else None


def _conjunction(net: CompiledNet, goal: Goal) -> tuple[Comparison, ...]:
    """Return a goal as one conjunction; an empty one where it is none."""
    if len(goal.conjunctions) == 1:
        return goal.conjunctions[0]
    if len(goal.transitions) != 1:
        return ()
    (transition,) = goal.transitions
    return (
        *(Comparison({place: 1}, ">=", weight) for place, weight in net.pre.row(transition)),
        *(Comparison({place: 1}, "<", weight) for place, weight in net.inhibitor.row(transition)),
    )


def _dual(net: CompiledNet, constraints: Sequence[Constraint]) -> list[float] | None:
    """Return factors of the constraints and of the places, none negative, whose bound is the largest.

    No firing lowers the bound by more than 1. None where the bound has no end, as the state equation excludes
    the goal.
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
