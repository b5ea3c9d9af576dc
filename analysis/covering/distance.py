"""A lower bound of the number of firings from a marking to one that covers a target, by the state equation.

The least number of firings x >= 0 with m + C x >= target (C the incidence matrix) is a linear program. Its
dual gives weights y >= 0 of the places whose sum no firing increases by more than one: for any m, at least y
. (target - m) firings are needed. So one program serves many markings, and few are solved. If the program has
no solution, there are weights whose sum no firing increases although it would have to increase: the target is
unreachable from m, which is checked in integers.

References
----------
M. Blondin, C. Haase, P. Offtermatt, *Directed reachability for infinite-state systems*, TACAS 2021, LNCS
12652. J. Esparza, S. Melzer, *Verification of safety properties using integer programming: beyond the state
equation*, Formal Methods in System Design 16, 2000.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf

import numpy as np

from dineros.analysis.nets.bounds import grows, integer_weights
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.linear_programs import FloatArray, LinearProgram

MOST_WEIGHTS = 32
"""Number of weightings kept for one target."""

MOST_PROGRAMS = 2_000
"""Maximum number of programs solved for one target: a second or two on a small net."""

LARGEST_WEIGHT = 1e6
"""Upper limit of a weight; if the target is unreachable, the program would otherwise be unbounded."""

FARTHEST = LARGEST_WEIGHT / 2
"""Number of firings from which a target is assumed to be unreachable, until that is proved."""


class CoveringPrograms:
    """The linear programs of a net, for any targets.

    Parameters
    ----------
    net : CompiledNet
        The net; its inhibitor arcs are ignored.
    """

    def __init__(self, net: CompiledNet) -> None:
        self.net = net
        self._program = LinearProgram(net.delta, len(net.places))
        self._size = len(net.places), len(net.transitions)

    def excluding(self, marking: Sequence[int], target: Mapping[int, int]) -> dict[int, int] | None:
        """Return weights by place that prove that a target is unreachable; None: there are none.

        No firing raises the weighted sum of tokens, which is smaller than that of the target.
        """
        places, transitions = self._size
        lacks = self._lacks(marking, target)
        found = self._program.solve(-lacks, np.zeros(transitions), np.zeros(places), np.ones(places))
        if found is None or float(np.dot(lacks, found)) < 1e-6:
            return None
        weights = integer_weights(found)
        if grows(self.net, weights):
            return None
        missing = sum(w * (target.get(p, 0) - marking[p]) for p, w in weights.items())
        return weights if missing > 0 else None

    def leading(self, marking: Sequence[int], target: Mapping[int, int]) -> list[float] | None:
        """Return weights whose sum no firing increases by more than one, and that are best for the target."""
        places, transitions = self._size
        lacks = self._lacks(marking, target)
        return self._program.solve(
            -lacks, np.ones(transitions), np.zeros(places), np.full(places, LARGEST_WEIGHT)
        )

    def _lacks(self, marking: Sequence[int], target: Mapping[int, int]) -> FloatArray:
        wanted = np.zeros(self._size[0])
        for place, tokens in target.items():
            wanted[place] = tokens
        return np.asarray(wanted - np.array(marking, dtype=np.float64))


class Distance:
    """Lower bounds of the number of firings to a target.

    Parameters
    ----------
    target : mapping of int to int
        Required tokens, by place.
    """

    def __init__(self, programs: CoveringPrograms, target: Mapping[int, int]) -> None:
        self._programs, self._target = programs, target
        self._leading: list[tuple[list[tuple[int, float]], float]] = []
        self._excluding: list[tuple[list[tuple[int, int]], int]] = []
        self._programs_left = MOST_PROGRAMS

    def of(self, marking: Sequence[int]) -> float:
        """Return a lower bound from the weights known so far; infinite if the target is unreachable."""
        for proof, least in self._excluding:
            if sum(w * marking[p] for p, w in proof) < least:
                return inf
        most = 0.0
        for weights, there in self._leading:
            needed = there - sum(w * marking[p] for p, w in weights)
            most = max(most, needed)
        return most

    def best(self, marking: Sequence[int]) -> float:
        """Return the best lower bound, by a program solved for this marking, if more may be solved."""
        known = self.of(marking)
        if known == inf or self._programs_left == 0:
            return known
        self._programs_left -= 1
        found = self._programs.leading(marking, self._target)
        if found is None:
            return known
        weights = [(p, w) for p, w in enumerate(found) if w > 1e-9]
        there = sum(w * self._target.get(p, 0) for p, w in weights)
        needed = there - sum(w * marking[p] for p, w in weights)
        if needed > FARTHEST:
            proof = self._programs.excluding(marking, self._target)
            if proof is not None:
                least = sum(w * self._target.get(p, 0) for p, w in proof.items())
                self._excluding.append((list(proof.items()), least))
                return inf
        elif needed > known + 1e-6 and len(self._leading) < MOST_WEIGHTS:
            self._leading.append((weights, there))
        return max(known, needed)
