"""Structure of nets: place invariants and semiflows as exact integers, and what follows from them.

A *place invariant* is an integer weighting y of the places with y . C = 0 (C the incidence matrix): y . m
is the same in every reachable marking m. A *semiflow* is a non-negative one. A weighting with y . C <= 0
only bounds: y . m never grows; it is called a *bounding weighting* here.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from heapq import heappop, heappush
from math import gcd
from typing import NamedTuple

from dineros.analysis.nets.compiled import CompiledNet


@dataclass(frozen=True)
class PlaceInvariant:
    """Weights of places whose weighted sum of tokens is constant, or never grows.

    Attributes
    ----------
    weights : dict
        Place index -> weight, without zeros.
    constant : int
        Weighted sum in the initial marking.
    exact : bool
        True when the sum is constant; False when firing can only lower it.
    """

    weights: dict[int, int]
    constant: int
    exact: bool = True

    @property
    def is_semiflow(self) -> bool:
        """Whether no weight is negative."""
        return min(self.weights.values()) > 0


def place_invariants(net: CompiledNet) -> list[PlaceInvariant]:
    """A generating set of all integer place invariants of a net.

    Every integer invariant is an integer combination of the returned ones: the rows that become zero when the
    incidence matrix is brought to echelon form by unimodular row operations.

    References
    ----------
    H. Cohen, *A Course in Computational Algebraic Number Theory*, Springer 1993, section 2.4 (kernel over Z).
    """
    columns = {t: change for t, change in enumerate(net.delta) if change}
    rows: list[dict[int, int]] = [{} for _ in net.places]
    for t, change in columns.items():
        for p, tokens in change.items():
            rows[p][t] = tokens
    weights: list[dict[int, int]] = [{p: 1} for p in range(len(net.places))]
    alive = set(range(len(net.places)))
    for t in sorted(columns, key=lambda t: len(columns[t])):
        holders = [r for r in alive if t in rows[r]]
        # Euclid's algorithm on the column keeps every step unimodular, so the kernel is generated over the
        # integers.
        while len(holders) > 1:
            pivot = min(holders, key=lambda r: (abs(rows[r][t]), len(rows[r]), len(weights[r])))
            for r in holders:
                if r != pivot:
                    factor = rows[r][t] // rows[pivot][t]
                    _subtract(rows[r], rows[pivot], factor)
                    _subtract(weights[r], weights[pivot], factor)
            holders = [r for r in holders if t in rows[r]]
        alive.difference_update(holders)
    return [_invariant(net, weights[r]) for r in sorted(alive)]


def semiflows(
    net: CompiledNet,
    largest_constant: int | None = None,
    bounding: bool = False,
    limit: int = 4_000,
) -> list[PlaceInvariant]:
    """Minimal-support semiflows, as far as they are affordable.

    Parameters
    ----------
    net
        The net.
    largest_constant
        Keep only semiflows whose constant is at most this. Since every term of the constant is
        non-negative, this also prunes the intermediate rows, which makes the small ones affordable on large
        nets.
    bounding
        Leave out transitions that only consume: what they would change can only shrink the sum, so that the
        results still bound the places (``exact`` says which of them are invariants all the same).
    limit
        Intermediate rows beyond the number of places at which rows with the largest supports are given up;
        the result is then a part of all.

    References
    ----------
    J. M. Colom and M. Silva, *Convex geometry and semiflows in P/T nets*, Advances in Petri Nets 1990, LNCS
    483.
    """
    changes = [
        {} if bounding and all(tokens < 0 for tokens in change.values()) else change for change in net.delta
    ]
    residuals: list[dict[int, int]] = [{} for _ in net.places]
    for number, change in enumerate(changes):
        for p, tokens in change.items():
            residuals[p][number] = tokens
    rows = _Rows(net.initial.tolist(), largest_constant, len(net.places) + limit)
    for p, residual in enumerate(residuals):
        rows.add(_Row(residual, {p: 1}, 1 << p))
    while (t := rows.cheapest()) is not None:
        rows.eliminate(t)
    dropped = [change for change, kept in zip(net.delta, changes, strict=True) if not kept]
    found = [_invariant(net, row.weights, dropped) for row in rows]
    return sorted(found, key=lambda y: (len(y.weights), y.constant, sorted(y.weights)))


class _Row(NamedTuple):
    """A weighting under way: what firing each transition adds to its sum, and its places as bits."""

    residual: dict[int, int]
    weights: dict[int, int]
    support: int


class _Rows:
    """The weightings under way, found by the transitions that change them and by their lowest place.

    Elimination looks at few rows of many: without the indices, nets of thousands of places take minutes.
    """

    def __init__(self, initial: list[int], largest_constant: int | None, limit: int) -> None:
        self._initial = initial
        self._largest_constant = largest_constant
        self._limit = limit
        self._rows: dict[int, _Row] = {}
        self._made = 0
        self._raised: defaultdict[int, set[int]] = defaultdict(set)
        self._lowered: defaultdict[int, set[int]] = defaultdict(set)
        self._by_lowest_place: defaultdict[int, set[int]] = defaultdict(set)
        #: (rows that elimination adds, transition); an entry is stale when the number is another one by now.
        self._costs: list[tuple[int, int]] = []

    def __iter__(self) -> Iterator[_Row]:
        return iter(self._rows.values())

    def add(self, row: _Row) -> None:
        """Put a row in, unless its constant is too large."""
        if not self._is_affordable(row.weights):
            return
        number = self._made
        self._made += 1
        self._rows[number] = row
        self._by_lowest_place[min(row.weights)].add(number)
        for t, tokens in row.residual.items():
            (self._raised if tokens > 0 else self._lowered)[t].add(number)
            heappush(self._costs, (self._cost(t), t))

    def cheapest(self) -> int | None:
        """Return the transition whose elimination adds the fewest rows; None when none is left."""
        while self._costs:
            cost, t = heappop(self._costs)
            if (self._raised[t] or self._lowered[t]) and cost == self._cost(t):
                return t
        return None

    def eliminate(self, t: int) -> None:
        """Replace the rows that a transition changes by the combinations that it does not change."""
        positive = [self._take(number) for number in sorted(self._raised[t])]
        negative = [self._take(number) for number in sorted(self._lowered[t])]
        made: dict[int, _Row] = {}
        for one in positive:
            for other in negative:
                support = one.support | other.support
                if support in made:
                    continue
                a, b = -other.residual[t], one.residual[t]
                residual = _combine(one.residual, a, other.residual, b)
                weights = _combine(one.weights, a, other.weights, b)
                common = gcd(*residual.values(), *weights.values())
                if common > 1:
                    residual = {key: value // common for key, value in residual.items()}
                    weights = {key: value // common for key, value in weights.items()}
                if self._is_affordable(weights):
                    made[support] = _Row(residual, weights, support)
        for support in sorted(made, key=lambda bits: (bits.bit_count(), bits)):
            if len(self._rows) >= self._limit:
                break
            # Only rows of minimal support can lead to minimal semiflows.
            if not self._holds_part_of(made[support]):
                self.add(made[support])

    def _holds_part_of(self, row: _Row) -> bool:
        return any(
            self._rows[number].support & row.support == self._rows[number].support
            for place in row.weights
            for number in self._by_lowest_place[place]
        )

    def _is_affordable(self, weights: dict[int, int]) -> bool:
        return self._largest_constant is None or (
            sum(self._initial[p] * weight for p, weight in weights.items()) <= self._largest_constant
        )

    def _take(self, number: int) -> _Row:
        row = self._rows.pop(number)
        self._by_lowest_place[min(row.weights)].discard(number)
        for t, tokens in row.residual.items():
            (self._raised if tokens > 0 else self._lowered)[t].discard(number)
            heappush(self._costs, (self._cost(t), t))
        return row

    def _cost(self, t: int) -> int:
        lowered, raised = len(self._lowered[t]), len(self._raised[t])
        return lowered * raised - lowered - raised


def _combine(one: dict[int, int], a: int, other: dict[int, int], b: int) -> dict[int, int]:
    total = {key: a * value for key, value in one.items()}
    for key, value in other.items():
        total[key] = total.get(key, 0) + b * value
    return {key: value for key, value in total.items() if value}


def _subtract(row: dict[int, int], other: dict[int, int], factor: int) -> None:
    for key, value in other.items():
        result = row.get(key, 0) - factor * value
        if result:
            row[key] = result
        else:
            row.pop(key, None)


def _invariant(
    net: CompiledNet, weights: dict[int, int], unbalanced: Iterable[dict[int, int]] = ()
) -> PlaceInvariant:
    """A weighting that every transition balances but those whose changes are given, if these do."""
    constant = sum(int(net.initial[p]) * weight for p, weight in weights.items())
    exact = all(sum(weights.get(p, 0) * tokens for p, tokens in change.items()) == 0 for change in unbalanced)
    return PlaceInvariant(dict(sorted(weights.items())), constant, exact)
