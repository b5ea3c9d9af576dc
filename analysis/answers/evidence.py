"""Why a goal is proved unreachable without a state space: what anybody can check again, in integers.

All indices are those of the net that was asked about.

References
----------
M. Silva, E. Teruel, J. M. Colom, *Linear algebraic and linear programming techniques for the analysis of
place/transition net systems*, Lectures on Petri Nets I, LNCS 1491, 1998. M. Sheeran, S. Singh, G. Stalmarck,
*Checking safety properties using induction and a SAT-solver*, FMCAD 2000, LNCS 1954.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

#: Weighted sum of tokens (place -> factor) that has to be at least a number.
Row = tuple[Mapping[int, int], int]


@dataclass(frozen=True)
class Weighting:
    """Some conditions that no reachable marking fulfils together, and a weighting of places that shows it.

    No firing raises the weighted sum of tokens, so it never exceeds that of the initial marking. A marking
    that fulfils all conditions has at least the sum of `factors` times their numbers, which is more.

    Attributes
    ----------
    rows : tuple of Row
        The conditions: each weighted sum of tokens is at least its number.
    weights : mapping
        Place -> weight, at least the sum of `factors` times what `rows` ask of it; others have weight 0.
    factors : tuple of Fraction
        By condition, at least 0.
    traps : tuple of tuple of int
        Traps that the initial marking marks: the last rows ask for a token in each, which no firing takes.
    """

    rows: tuple[Row, ...]
    weights: Mapping[int, Fraction]
    factors: tuple[Fraction, ...]
    traps: tuple[tuple[int, ...], ...] = ()


@dataclass(frozen=True)
class Excluded:
    """A goal that the state equation excludes: each of its alternatives fulfils the conditions of one case.

    Attributes
    ----------
    cases : tuple of Weighting
        Of a disjunctive normal form of the goal, every conjunction implies all rows of one of these, but for
        the rows of traps.
    """

    cases: tuple[Weighting, ...]

    def __str__(self) -> str:
        count = len(self.cases)
        traps = len({trap for case in self.cases for trap in case.traps})
        also = f" and {traps} marked trap{'s' * (traps > 1)}" if traps else ""
        return f"{count} weighting{'s' * (count > 1)} of the places{also} exclude{'s' * (count == 1)} it"


@dataclass(frozen=True)
class Inductive:
    """Bounds of places under which no firing sequence of a length leads to a goal for the first time.

    The goal is met in no marking that the net reaches within `depth` steps, and in none at the end of `depth`
    + 1 steps through markings within the bounds and the invariants none of which meets it. A step fires
    transitions that do not need each other.

    Attributes
    ----------
    depth : int
        k of k-induction.
    bounds : tuple of int
        By place: most tokens in a reachable marking.
    weightings : tuple of mapping
        By place: weights of sums that no firing changes.
    """

    depth: int
    bounds: tuple[int, ...]
    weightings: tuple[Mapping[int, int], ...] = ()

    def __str__(self) -> str:
        return f"no {self.depth} steps lead to it for the first time, from wherever the invariants hold"


Evidence = Excluded | Inductive
"""What an `Outcome` rests on that looked at no state space."""
