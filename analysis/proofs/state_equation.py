"""Proofs by the state equation: weightings of the places, each checked in integers.

A linear program proposes weights z of the places and factors of the conditions A . m >= b with z >= factors
. A and z . C <= 0 (C the incidence matrix). No firing raises z . m, so factors . A . m <= z . m <= z . m0 in
every reachable marking m; if that is less than factors . b, no reachable marking fulfils the conditions. With
one row, no b and the smallest z . m0, the same is an upper bound of A . m.

References
----------
M. Silva, E. Teruel, J. M. Colom, *Linear algebraic and linear programming techniques for the analysis of
place/transition net systems*, Lectures on Petri Nets I, LNCS 1491, 1998.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import floor, lcm

import numpy as np

from dineros.analysis.answers.evidence import Row, Weighting
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.linear_programs import LinearProgram

LARGEST_DENOMINATOR = 10_000
#: Entries that one program may look at: about a second.
MOST_WORK = 100_000_000


class StateEquation:
    """The linear relaxation of the reachable markings of a net."""

    def __init__(self, net: CompiledNet) -> None:
        self.net = net
        self._changes = {tuple(change.items()): change for change in net.delta if change}

    def excludes(self, rows: Sequence[Row]) -> Weighting | None:
        """Return what proves that no reachable marking fulfils all of some conditions, if anything."""
        for row in rows:
            if not row[0] and row[1] > 0:
                return Weighting((row,), {}, (Fraction(1),))
        rows = [row for row in rows if row[0]]
        found = self._solved(rows, np.ones(len(rows)))
        if found is None:
            return None
        weights, factors = found
        least = sum(factor * bound for factor, (_, bound) in zip(factors, rows, strict=True))
        if self._initially(weights) >= least:
            return None
        used = [(row, factor) for row, factor in zip(rows, factors, strict=True) if factor]
        return Weighting(tuple(row for row, _ in used), weights, tuple(factor for _, factor in used))

    def largest(self, factors: Mapping[int, int]) -> int | None:
        """Return a proved upper bound of a weighted sum of tokens; None if none is found."""
        found = self._solved([(factors, 0)], None)
        if found is None or found[1][0] <= 0:
            return None
        weights, scales = found
        return floor(self._initially(weights) / scales[0])

    def _initially(self, weights: Mapping[int, Fraction]) -> Fraction:
        return sum((weight * int(self.net.initial[p]) for p, weight in weights.items()), Fraction(0))

    def _solved(
        self, rows: Sequence[Row], most: np.ndarray[tuple[int], np.dtype[np.float64]] | None
    ) -> tuple[dict[int, Fraction], list[Fraction]] | None:
        """Return weights of places and factors of rows, checked; None if the proposed weighting is invalid.

        `most` limits the factors; without it, the only factor is 1.
        """
        places, count = len(self.net.places), len(rows)
        program = [dict(change) for change in self._changes.values()]
        touched: dict[int, dict[int, float]] = {}
        for number, (terms, _) in enumerate(rows):
            for place, times in terms.items():
                touched.setdefault(place, {place: -1.0})[places + number] = float(times)
        program += touched.values()  # type: ignore[arg-type]
        costs = np.concatenate([self.net.initial.astype(float), [-float(bound) for _, bound in rows]])
        # If no condition names a place, its weight is at least 0.
        low = np.zeros(places + count)
        low[list(touched)] = -np.inf
        high = np.full(places + count, np.inf)
        high[places:] = 1.0 if most is None else most
        if most is None:
            low[places:] = 1.0
        found = LinearProgram(program, places + count, MOST_WORK).solve(
            costs, np.zeros(len(program)), low, high
        )
        if found is None or (most is not None and float(costs @ np.array(found)) > -1e-7):
            return None
        factors = [_near(value) for value in found[places:]]
        asked: dict[int, Fraction] = {}
        for factor, (terms, _) in zip(factors, rows, strict=True):
            for place, times in terms.items():
                asked[place] = asked.get(place, Fraction(0)) + factor * times
        zero = Fraction(0)
        weights = {
            place: weight
            for place, value in enumerate(found[:places])
            if (weight := max(_near(value, least=None), asked.get(place, zero)))
        }
        return (weights, factors) if self._never_grows(weights) else None

    def _never_grows(self, weights: Mapping[int, Fraction]) -> bool:
        scale = lcm(*(weight.denominator for weight in weights.values())) if weights else 1
        whole = {place: int(weight * scale) for place, weight in weights.items()}
        return all(
            sum(whole.get(place, 0) * tokens for place, tokens in change) <= 0 for change in self._changes
        )


def _near(value: float, least: Fraction | None = Fraction(0)) -> Fraction:
    """A fraction near a proposed number; no less than the least one."""
    near = Fraction(value).limit_denominator(LARGEST_DENOMINATOR)
    return near if least is None else max(least, near)
