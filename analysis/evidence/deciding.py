"""Whether conditions on markings can be fulfilled together, decided exactly.

A SAT solver chooses among inequalities. That those chosen contradict each other is proved by Farkas' lemma: a
sum of them, by factors that are not negative, asks nothing of any place but for a positive number. Linear
programs propose the factors in floating point, and they are checked in fractions; so are markings.

References
----------
A. Schrijver, *Theory of linear and integer programming*, Wiley, 1986, section 7.3. R. Nieuwenhuis, A.
Oliveras, C. Tinelli, *Solving SAT and SAT modulo theories*, JACM 53(6), 2006.
"""

from __future__ import annotations

from bisect import bisect, insort
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from math import ceil, gcd
from typing import Any

import numpy as np

from dineros.analysis.evidence.reading import Condition, Marking, inequality
from dineros.analysis.nets.linear_programs import LinearProgram

MOST_ROUNDS = 20_000
"""Choices of the SAT solver that are looked at for one question."""

DENOMINATORS = (1_000, 100_000, 10_000_000)
"""Of the factors: the first one of which the proof stands is taken."""

Inequality = tuple[dict[str, int], int, int]
"""Weights of places, the number that the sum is at least, and the literal that says so."""


class UndecidedError(Exception):
    """Something takes more work than it may cost, or needs fractions with larger denominators."""


class Decider:
    """Decides whether conditions can be fulfilled together, by any numbers of tokens.

    Sums of one place each, of however many tokens, need the SAT solver only: each sum compared with a number
    is a variable, and a larger number implies a smaller one.

    Parameters
    ----------
    is_late : callable, optional
        Whether to give up; asked before each choice.
    """

    def __init__(self, is_late: Callable[[], bool] = lambda: False) -> None:
        from pysat.solvers import Cadical153

        self._is_late = is_late
        self._sat: Any = Cadical153()
        self._numbers: dict[tuple[tuple[str, int], ...], list[int]] = {}
        self._variables: dict[tuple[tuple[tuple[str, int], ...], int], int] = {}
        self._last = self._true = 1
        self.add([1])

    def new(self) -> int:
        """Return a new variable."""
        self._last += 1
        return self._last

    def add(self, clause: Sequence[int]) -> None:
        """Have one of some literals hold."""
        self._sat.add_clause(clause)

    def literal(self, row: Condition) -> int:
        """Return the literal of a sum that is at least a number."""
        weights, least = {p: k for p, k in row["sum"].items() if k}, row["least"]
        if least <= 0 and all(k > 0 for k in weights.values()):
            return self._true
        if least > 0 and all(k < 0 for k in weights.values()):
            return -self._true
        common = gcd(*weights.values())
        terms = tuple((p, weights[p] // common) for p in sorted(weights))
        number, sign = ceil(Fraction(least, common)), 1
        if terms[0][1] < 0:
            terms, number, sign = tuple((p, -k) for p, k in terms), 1 - number, -1
        if (terms, number) not in self._variables:
            variable = self._variables[terms, number] = self.new()
            known = self._numbers.setdefault(terms, [])
            at = bisect(known, number)
            for weaker in known[:at][-1:]:
                self.add([-variable, self._variables[terms, weaker]])
            for stronger in known[at : at + 1]:
                self.add([-self._variables[terms, stronger], variable])
            insort(known, number)
        return sign * self._variables[terms, number]

    def encode(self, condition: Condition) -> int:
        """Return a literal that implies a condition."""
        if "sum" in condition:
            return self.literal(condition)
        ((key, parts),) = condition.items()
        literals, root = [self.encode(part) for part in parts], self.new()
        for clause in [literals] if key == "any" else [[literal] for literal in literals]:
            self.add([-root, *clause])
        return root

    def marking(self, assumed: Sequence[int]) -> Marking | None:
        """Return tokens that fulfil all that was added and assumed; None where nothing does.

        Places without a token need not be named.

        Raises
        ------
        UndecidedError
            It takes too much.
        """
        for _ in range(MOST_ROUNDS):
            if self._is_late():
                break
            if not self._sat.solve(assumptions=assumed):
                return None
            found = self._realised(list(self._chosen(set(self._sat.get_model()))))
            if found is not None:
                return found
        raise UndecidedError

    def _chosen(self, model: set[int]) -> Iterator[Inequality]:
        """Yield the strongest inequalities that were chosen, each with its literal."""
        for terms, numbers in self._numbers.items():
            held = bisect(numbers, 0, key=lambda n: self._variables[terms, n] not in model)
            for number in numbers[:held][-1:]:
                yield dict(terms), number, self._variables[terms, number]
            for number in numbers[held : held + 1]:
                yield {p: -k for p, k in terms}, 1 - number, -self._variables[terms, number]

    def _realised(self, rows: list[Inequality]) -> Marking | None:
        """Return tokens; None after a clause that excludes the choice, or a number for the next choice."""
        together = {p for weights, _, _ in rows if len(weights) > 1 for p in weights}
        tokens = {p: max(0, k) for weights, k, _ in rows for p in weights if weights == {p: 1}}
        rows = [row for row in rows if together.issuperset(row[0])]
        if not rows:
            return tokens
        names = {p: number for number, p in enumerate(together)}
        least = np.array([float(number) for _, number, _ in rows])
        columns: list[dict[int, float]] = [{} for _ in names]
        for number, (weights, _, _) in enumerate(rows):
            for p, k in weights.items():
                columns[names[p]][number] = float(k)
        zeros, ones = np.zeros(len(rows)), np.ones(len(rows))
        factors = LinearProgram(columns, len(rows)).solve(-least, np.zeros(len(names)), zeros, ones)
        if factors is None:
            raise UndecidedError
        if float(least @ np.array(factors)) > 1e-7:
            self.add([-rows[number][2] for number in self._contradiction(rows, factors)])
            return None
        program = [{names[p]: -float(k) for p, k in weights.items()} for weights, _, _ in rows]
        size = len(names)
        point = LinearProgram(program, size).solve(
            np.ones(size), -least, np.zeros(size), np.full(size, np.inf)
        )
        if point is None:
            raise UndecidedError
        apart = max(names, key=lambda p: abs(point[names[p]] - round(point[names[p]])))
        if abs(point[names[apart]] - round(point[names[apart]])) > 1e-6:
            self.literal(inequality({apart: 1}, ceil(point[names[apart]])))
            return None
        tokens |= {p: round(point[number]) for p, number in names.items()}
        if any(sum(k * tokens[p] for p, k in weights.items()) < number for weights, number, _ in rows):
            raise UndecidedError
        return tokens

    @staticmethod
    def _contradiction(rows: list[Inequality], factors: Sequence[float]) -> list[int]:
        """Return rows that no tokens fulfil: their sum, by factors, asks nothing of places, but a number."""
        for denominator in DENOMINATORS:
            exact = [max(Fraction(0), Fraction(value).limit_denominator(denominator)) for value in factors]
            total: dict[str, Fraction] = {}
            for factor, (weights, _, _) in zip(exact, rows, strict=True):
                for p, k in weights.items():
                    total[p] = total.get(p, Fraction(0)) + factor * k
            least = sum(factor * number for factor, (_, number, _) in zip(exact, rows, strict=True))
            if least > 0 and all(weight <= 0 for weight in total.values()):
                return [number for number, factor in enumerate(exact) if factor]
        raise UndecidedError
