"""Bounds of places under a guard, proved from the state equation.

For place weights y >= 0 on the other places with y . C <= r (C the incidence matrix, r one number per
transition), and a guard g, every reachable marking m >= g has ``sum over firings of r >= y . (m - m0) >= y .
(g - m0)``. With r the row of a place p this bounds m(p) from below, with r its negation from above, and with
r = 0 a positive value of y . (g - m0) proves that the guard never holds. Linear programming proposes y in
floating point; it is used only after an exact check in rational numbers.

References
----------
G. Berthelot, *Transformations and decompositions of nets*, Advances in Petri Nets 1986, LNCS 254, 1987
(redundant places). M. Silva, E. Teruel, J. M. Colom, *Linear algebraic and linear programming techniques for
the analysis of place/transition net systems*, Lectures on Petri Nets I, LNCS 1491, 1998.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from math import lcm
from typing import Literal

import numpy as np

from dineros.analysis.nets.linear_programs import LinearProgram
from dineros.analysis.reductions.net import MutableNet

#: Weights found by floating point are rounded to fractions with at most this denominator.
LARGEST_DENOMINATOR = 1_000
#: Upper limit of a weight, so that no program is unbounded.
LARGEST_WEIGHT = 1_000.0


class GuardedBounds:
    """Bounds of the current net by the state equation; create a new object after transitions were added.

    After places or transitions were removed, the object can still be used: every proof is checked on the
    current net, and removed places get no weight.
    """

    def __init__(self, net: MutableNet) -> None:
        self._net = net
        self._places = list(net.places)
        self._index = {place: p for p, place in enumerate(self._places)}
        self._deltas = {t: arcs.delta for t, arcs in net.transitions.items()}
        self._rows = {t: row for row, t in enumerate(self._deltas)}
        rows = [
            dict(sorted((self._index[place], gain) for place, gain in delta.items() if gain))
            for delta in self._deltas.values()
        ]
        self._program = LinearProgram(rows, len(self._places))

    def least(self, place: str, guard: Mapping[str, int]) -> Fraction | None:
        """Return a lower bound of a place in reachable markings with at least the guard on other places."""
        value = self._value(guard, place, 1)
        return None if value is None else self._net.places[place] + value

    def largest(self, place: str, guard: Mapping[str, int]) -> Fraction | None:
        """Return an upper bound of a place in reachable markings with at least the guard on other places."""
        value = self._value(guard, place, -1)
        return None if value is None else self._net.places[place] - value

    def excludes(self, guard: Mapping[str, int]) -> bool:
        """Whether it is proved that no reachable marking has at least the guard."""
        value = self._value(guard, None, 0)
        return value is not None and value > 0

    def _value(self, guard: Mapping[str, int], place: str | None, sign: Literal[-1, 0, 1]) -> Fraction | None:
        limits = np.zeros(len(self._rows))
        if place is not None:
            for t in self._net.neighbours(place):
                limits[self._rows[t]] = sign * self._deltas[t].get(place, 0)
        gain = np.zeros(len(self._places))
        upper = np.zeros(len(self._places))
        for p, name in enumerate(self._places):
            if name in self._net.places and name != place:
                gain[p] = guard.get(name, 0) - self._net.places[name]
                upper[p] = LARGEST_WEIGHT
        values = self._program.solve(-gain, limits, np.zeros(len(self._places)), upper)
        if values is None:
            return None
        weights = {
            self._places[p]: Fraction(value).limit_denominator(LARGEST_DENOMINATOR)
            for p, value in enumerate(values)
            if value > 1e-9
        }
        return self._checked(weights, guard, place, sign)

    def _checked(
        self, weights: Mapping[str, Fraction], guard: Mapping[str, int], place: str | None, sign: int
    ) -> Fraction | None:
        """Return the value that the weights prove; None: they are not a certificate."""
        scale = lcm(*(weight.denominator for weight in weights.values()))
        whole = {name: int(weight * scale) for name, weight in weights.items()}
        touched = {t for name in weights for t in self._net.neighbours(name)}
        if place is not None:
            touched.update(self._net.neighbours(place))
        for t in touched:
            delta = self._net.transitions[t].delta
            limit = sign * scale * delta.get(place, 0) if place is not None else 0
            if sum(whole.get(name, 0) * tokens for name, tokens in delta.items()) > limit:
                return None
        gain = sum(weight * (guard.get(name, 0) - self._net.places[name]) for name, weight in whole.items())
        return Fraction(gain, scale)
