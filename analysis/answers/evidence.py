"""Why a goal is proved unreachable without a state space: what anybody can check again, in integers.

All indices are those of the net that was asked about.

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
        By condition, more than 0.
    """

    rows: tuple[Row, ...]
    weights: Mapping[int, Fraction]
    factors: tuple[Fraction, ...]

    @classmethod
    def of_bound(cls, place: int, bound: int, weights: Mapping[int, int]) -> Weighting:
        """Return why a place never holds more tokens than its bound."""
        exact = {p: Fraction(weight) for p, weight in weights.items()}
        return cls((({place: 1}, bound + 1),), exact, (exact[place],))


@dataclass(frozen=True)
class Excluded:
    """A goal that the state equation excludes: each of its alternatives fulfils the conditions of one case.

    Attributes
    ----------
    cases : tuple of Weighting
        Of a disjunctive normal form of the goal, every conjunction implies all rows of one of these, but for
        the rows of traps.
    traps : tuple of tuple of int
        Traps that the initial marking marks, which no firing empties: a row of each asks for a token there.
    """

    cases: tuple[Weighting, ...]
    traps: tuple[tuple[int, ...], ...] = ()

    def __str__(self) -> str:
        count, traps = len(self.cases), len(self.traps)
        also = f" and {traps} marked trap{'s' * (traps > 1)}" if traps else ""
        if not count:
            return "it contradicts itself"
        return f"{count} weighting{'s' * (count > 1)} of the places{also} exclude{'s' * (count == 1)} it"


@dataclass(frozen=True)
class Inductive:
    """A number of steps that keep a goal away, with bounds of places and other facts of all markings.

    The goal is met in no marking that the net reaches in fewer steps, and the clauses hold in all of these.
    In as many steps through markings within the bounds, the sums and the clauses, none of which meets the
    goal, no marking is reached that meets it, or violates a clause. A step fires transitions that do not
    need each other.

    Attributes
    ----------
    depth : int
        k of k-induction; 0 where bounds and sums alone exclude the goal.
    bounds : tuple of int
        By place: most tokens in a reachable marking.
    proofs : tuple of mapping
        By place: weights of places, of which that of this place times its bound and one more is more than the
        initial sum, which no firing raises.
    weightings : tuple of mapping
        Place -> weight: sums that no firing changes.
    clauses : tuple of tuple of Row
        Of each, one condition holds in every reachable marking.
    """

    depth: int
    bounds: tuple[int, ...]
    proofs: tuple[Mapping[int, int], ...] = ()
    weightings: tuple[Mapping[int, int], ...] = ()
    clauses: tuple[tuple[Row, ...], ...] = ()

    def __str__(self) -> str:
        if self.clauses:
            count = len(self.clauses)
            clauses = "1 clause excludes" if count == 1 else f"{count} clauses exclude"
            return f"{clauses} it, and every step keeps them"
        return f"no {self.depth} steps lead to it for the first time, from wherever the invariants hold"


@dataclass(frozen=True)
class Together:
    """Why each of some goals is unreachable."""

    parts: tuple[Excluded | Inductive, ...]

    def __str__(self) -> str:
        return "; ".join(dict.fromkeys(map(str, self.parts)))


Evidence = Excluded | Inductive | Together
"""What an `Outcome` rests on that looked at no state space."""


def together(found: Iterable[Evidence | None]) -> Evidence | None:
    """Return why none of some goals is reachable; None where that is not known of one."""
    parts: list[Excluded | Inductive] = []
    for one in found:
        if one is None:
            return None
        for part in one.parts if isinstance(one, Together) else (one,):
            if part not in parts:
                parts.append(part)
    return parts[0] if len(parts) == 1 else Together(tuple(parts))
