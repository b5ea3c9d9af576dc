"""Structure of nets: place invariants and semiflows as exact integers, and what follows from them.

A *place invariant* is an integer weighting y of the places with y . C = 0 (C the incidence matrix): y . m
is the same in every reachable marking m. A *semiflow* is a non-negative one. A weighting with y . C <= 0
only bounds: y . m never grows; it is called a *bounding weighting* here.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import gcd
from typing import NamedTuple

from dineros.analysis.compiled import CompiledNet


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
        Intermediate rows at which rows with the largest supports are given up; the result is then a part of
        all.

    References
    ----------
    J. M. Colom and M. Silva, *Convex geometry and semiflows in P/T nets*, Advances in Petri Nets 1990, LNCS
    483.
    """
    changes = [
        {} if bounding and all(tokens < 0 for tokens in change.values()) else change for change in net.delta
    ]
    initial = net.initial.tolist()
    rows: list[_Row] = []
    for p in range(len(net.places)):
        if largest_constant is None or initial[p] <= largest_constant:
            rows.append(
                _Row({t: change[p] for t, change in enumerate(changes) if p in change}, {p: 1}, initial[p])
            )
    open_transitions = {t for t, change in enumerate(changes) if change}
    while open_transitions:
        tally = {t: [0, 0] for t in open_transitions}
        for row in rows:
            for t, tokens in row.residual.items():
                tally[t][tokens > 0] += 1
        t = min(open_transitions, key=lambda t: (tally[t][0] * tally[t][1] - sum(tally[t]), t))
        open_transitions.discard(t)
        rows = _eliminate(rows, t, initial, largest_constant, limit)
    found = [_invariant(net, row.weights) for row in rows]
    return sorted(found, key=lambda y: (len(y.weights), y.constant, sorted(y.weights)))


class _Row(NamedTuple):
    residual: dict[int, int]
    weights: dict[int, int]
    constant: int


def _eliminate(
    rows: list[_Row], t: int, initial: list[int], largest_constant: int | None, limit: int
) -> list[_Row]:
    keep = [row for row in rows if t not in row.residual]
    positive = [row for row in rows if row.residual.get(t, 0) > 0]
    negative = [row for row in rows if row.residual.get(t, 0) < 0]
    made: dict[int, _Row] = {}
    for one in positive:
        for other in negative:
            a, b = -other.residual[t], one.residual[t]
            residual = _combine(one.residual, a, other.residual, b)
            weights = _combine(one.weights, a, other.weights, b)
            common = gcd(*residual.values(), *weights.values())
            if common > 1:
                residual = {key: value // common for key, value in residual.items()}
                weights = {key: value // common for key, value in weights.items()}
            constant = sum(initial[p] * weight for p, weight in weights.items())
            if largest_constant is None or constant <= largest_constant:
                made.setdefault(sum(1 << p for p in weights), _Row(residual, weights, constant))
    result = list(keep)
    supports = [sum(1 << p for p in row.weights) for row in keep]
    for support in sorted(made, key=lambda bits: (bits.bit_count(), bits)):
        if len(result) >= limit:
            break
        # Only rows of minimal support can lead to minimal semiflows.
        if not any(other & support == other for other in supports):
            supports.append(support)
            result.append(made[support])
    return result


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


def _invariant(net: CompiledNet, weights: dict[int, int]) -> PlaceInvariant:
    constant = sum(int(net.initial[p]) * weight for p, weight in weights.items())
    exact = all(not any(p in weights for p in change) or not _gain(weights, change) for change in net.delta)
    return PlaceInvariant(dict(sorted(weights.items())), constant, exact)


def _gain(weights: dict[int, int], change: dict[int, int]) -> int:
    return sum(weights.get(p, 0) * tokens for p, tokens in change.items())
