"""Evidence that a goal is unreachable, found without a state space, that can be checked in integers.

All indices are those of the net in the question.

References
----------
M. Silva, E. Teruel, J. M. Colom, *Linear algebraic and linear programming techniques for the analysis of
place/transition net systems*, Lectures on Petri Nets I, LNCS 1491, 1998. M. Sheeran, S. Singh, G. Stalmarck,
*Checking safety properties using induction and a SAT-solver*, FMCAD 2000, LNCS 1954.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction

#: Weighted sum of tokens (place -> factor), and the least value that it must have.
Row = tuple[Mapping[int, int], int]


@dataclass(frozen=True)
class Weighting:
    """Conditions that no reachable marking fulfils together, and a weighting of places that proves it.

    No firing increases the weighted sum of tokens, so the sum never exceeds its initial value. A marking that
    fulfils all conditions has at least the sum of `factors` times their numbers, which is larger.
    """

    rows: tuple[Row, ...]
    """The conditions: each weighted sum of tokens is at least its number."""
    weights: Mapping[int, Fraction]
    """Place -> weight, at least the sum of `factors` times the factors of `rows`; others have weight 0."""
    factors: tuple[Fraction, ...]
    """One positive factor for each condition."""

    @classmethod
    def of_bound(cls, place: int, bound: int, weights: Mapping[int, int]) -> Weighting:
        """Return evidence that a place never has more tokens than its bound."""
        exact = {p: Fraction(weight) for p, weight in weights.items()}
        return cls((({place: 1}, bound + 1),), exact, (exact[place],))


@dataclass(frozen=True)
class Excluded:
    """A goal excluded by the state equation: each of its alternatives fulfils the conditions of one case."""

    cases: tuple[Weighting, ...]
    """Each conjunction of a disjunctive normal form of the goal implies all rows of one of these, except the
    rows of traps.
    """
    traps: tuple[tuple[int, ...], ...] = ()
    """Traps with an initial token, which no firing empties: a row for each requires a token in it."""

    def __str__(self) -> str:
        count, traps = len(self.cases), len(self.traps)
        also = f" and {traps} marked trap{'s' * (traps > 1)}" if traps else ""
        if not count:
            return "it contradicts itself"
        return f"{count} weighting{'s' * (count > 1)} of the places{also} exclude{'s' * (count == 1)} it"


@dataclass(frozen=True)
class Inductive:
    """Proof by k-induction, with bounds of places and other facts about all reachable markings.

    No marking reachable in fewer than k steps fulfils the goal. From k steps through markings within the
    bounds and sums that do not fulfil the goal, no marking is reached that fulfils it. A step fires
    transitions that are independent of each other.
    """

    depth: int
    """The k of k-induction; 0: bounds and sums alone exclude the goal."""
    bounds: tuple[int, ...]
    """For each place, the most tokens in a reachable marking."""
    proofs: tuple[Mapping[int, int], ...] = ()
    """For each place: weights of places with a sum that no firing increases; the weight of the place times
    one more than its bound exceeds the initial sum.
    """
    weightings: tuple[Mapping[int, int], ...] = ()
    """Place -> weight: sums that no firing changes."""

    def __str__(self) -> str:
        return (
            f"no {self.depth} steps reach it for the first time from any marking in which the invariants hold"
        )


@dataclass(frozen=True)
class Together:
    """Evidence for several goals, that each of them is unreachable."""

    parts: tuple[Excluded | Inductive, ...]

    def __str__(self) -> str:
        return "; ".join(dict.fromkeys(map(str, self.parts)))


Evidence = Excluded | Inductive | Together
"""The evidence of an `Outcome` that was found without a state space."""


def together(found: Iterable[Evidence | None]) -> Evidence | None:
    """Return evidence that none of several goals is reachable; None if it is missing for one of them."""
    parts: list[Excluded | Inductive] = []
    for one in found:
        if one is None:
            return None
        for part in one.parts if isinstance(one, Together) else (one,):
            if part not in parts:
                parts.append(part)
    return parts[0] if len(parts) == 1 else Together(tuple(parts))
