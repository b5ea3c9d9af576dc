"""Goals of a search: transitions enabled, deadlocks, boolean combinations of comparisons of tokens."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from dineros.analysis.explicit.layout import Layout
from dineros.analysis.explicit.tables import Goals
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.coverability import Coverability, OmegaMarking

Relation = Literal["<", "<=", "=", "!=", ">=", ">"]

_RELATIONS = {
    "<": operator.lt,
    "<=": operator.le,
    "=": operator.eq,
    "!=": operator.ne,
    ">=": operator.ge,
    ">": operator.gt,
}


class Comparison(NamedTuple):
    """A weighted sum of tokens compared with a number.

    Attributes
    ----------
    weights : mapping
        Place index -> factor; factors may be negative.
    """

    weights: Mapping[int, int]
    relation: Relation
    value: int

    def holds(self, marking: Sequence[int]) -> bool:
        """Whether a marking fulfils it."""
        total = sum(factor * marking[place] for place, factor in self.weights.items())
        return bool(_RELATIONS[self.relation](total, self.value))


@dataclass(frozen=True)
class Goal:
    """The goal of a search; create it with `enabled`, `deadlock` or `where`.

    Attributes
    ----------
    transitions : tuple of int
        Any of these enabled.
    is_deadlock : bool
        Nothing enabled.
    conjunctions : tuple of tuple of Comparison
        Any of these conjunctions true (disjunctive normal form).
    """

    transitions: tuple[int, ...] = ()
    is_deadlock: bool = False
    conjunctions: tuple[tuple[Comparison, ...], ...] = ()

    def __post_init__(self) -> None:
        if bool(self.transitions) + self.is_deadlock + bool(self.conjunctions) > 1:
            raise ValueError("a goal is transitions, a deadlock or comparisons, not several of them")

    @classmethod
    def enabled(cls, net: CompiledNet, *transitions: str | int) -> Goal:
        """Any of these transitions (by name or index) enabled."""
        return cls(tuple(t if isinstance(t, int) else net.transitions.index(t) for t in transitions))

    @classmethod
    def deadlock(cls) -> Goal:
        """No transition enabled."""
        return cls(is_deadlock=True)

    @classmethod
    def where(
        cls, net: CompiledNet, *conjunctions: Iterable[tuple[Mapping[str, int], Relation, int]]
    ) -> Goal:
        """Any of these conjunctions of comparisons true; places by name.

        Examples
        --------
        >>> net = CompiledNet.build({"a": 1, "b": 0}, [])
        >>> Goal.where(net, [({"a": 1, "b": -1}, ">=", 2)]).conjunctions
        ((Comparison(weights={0: 1, 1: -1}, relation='>=', value=2),),)
        """
        index = {name: place for place, name in enumerate(net.places)}
        return cls(
            conjunctions=tuple(
                tuple(
                    Comparison({index[name]: factor for name, factor in weights.items()}, relation, value)
                    for weights, relation, value in conjunction
                )
                for conjunction in conjunctions
            )
        )

    def alternatives(self, net: CompiledNet) -> list[tuple[Comparison, ...]]:
        """Conjunctions any of which suffices: the given ones, or the conditions that enable a transition."""
        enabling = [
            (
                *(Comparison({place: 1}, ">=", weight) for place, weight in net.pre.row(t)),
                *(Comparison({place: 1}, "<", weight) for place, weight in net.inhibitor.row(t)),
            )
            for t in self.transitions
        ]
        return [*enabling, *self.conjunctions]

    def holds(self, net: CompiledNet, marking: Sequence[int]) -> bool:
        """Whether a marking fulfils the goal."""
        if self.is_deadlock:
            return not any(net.is_enabled(t, marking) for t in range(len(net.transitions)))
        return any(net.is_enabled(t, marking) for t in self.transitions) or any(
            all(comparison.holds(marking) for comparison in conjunction) for conjunction in self.conjunctions
        )


def excludes(net: CompiledNet, known: Coverability, goal: Goal) -> bool:
    """Whether the maximal markings prove that a goal is unreachable; False if this is unknown.

    Every reachable marking is below one of the coverability set. So a comparison that holds nowhere below a
    marking of the set excludes its conjunction there.
    """
    if known.maximal is None or goal.is_deadlock:
        return False
    return all(
        any(not _can_hold(comparison, largest) for comparison in conjunction)
        for conjunction in goal.alternatives(net)
        for largest in known.maximal
    )


def _can_hold(comparison: Comparison, largest: OmegaMarking) -> bool:
    """Whether a comparison holds for some numbers of tokens up to the largest ones, place by place."""
    products = [factor * largest[place] for place, factor in comparison.weights.items() if factor]
    high, low = sum(value for value in products if value > 0), sum(value for value in products if value < 0)
    match comparison.relation:
        case ">=" | ">":
            return bool(_RELATIONS[comparison.relation](high, comparison.value))
        case "<=" | "<":
            return bool(_RELATIONS[comparison.relation](low, comparison.value))
        case "=":
            return bool(low <= comparison.value <= high)
    return not low == high == comparison.value


#: A constraint: the weighted sum (place -> factor, in order) is at least a number.
Constraint = tuple[tuple[tuple[int, int], ...], int]


def normalized(goal: Goal) -> list[list[Constraint]]:
    """The conjunctions of a goal with lower bounds only; an inequality ``!=`` splits a conjunction in two."""
    result: list[list[Constraint]] = []
    for conjunction in goal.conjunctions:
        products: list[list[Constraint]] = [[]]
        for weights, relation, value in conjunction:
            plus = tuple(sorted(weights.items()))
            minus = tuple((place, -factor) for place, factor in plus)
            at_least = {"=": value, ">=": value, ">": value + 1, "!=": value + 1}.get(relation)
            at_most = {"=": value, "<=": value, "<": value - 1, "!=": value - 1}.get(relation)
            choices: list[list[Constraint]] = [[]]
            if at_least is not None:
                choices[0].append((plus, at_least))
            if at_most is not None:
                if relation == "!=":
                    choices.append([])
                choices[-1].append((minus, -at_most))
            products = [[*product, *choice] for product in products for choice in choices]
        result += products
    return result


def goal_tables(layout: Layout, conjunctions: Sequence[Sequence[Constraint]]) -> Goals:
    """Return conjunctions as tables over the cells of a layout, all open."""
    home = {place: (k, i) for k, cell in enumerate(layout.cells) for i, place in enumerate(cell.places)}
    starts, term_starts, least = [0], [0], []
    cells: list[int] = []
    offsets: list[int] = []
    factors: list[int] = []
    table: list[int] = []
    for conjunction in conjunctions:
        for weights, bound in conjunction:
            by_cell: dict[int, list[tuple[int, int]]] = {}
            for place, factor in weights:
                by_cell.setdefault(home[place][0], []).append((home[place][1], factor))
            for k, members in by_cell.items():
                values = layout.cells[k].values
                cells.append(k)
                factors.append(members[0][1])
                offsets.append(-1 if values is None else len(table))
                if values is not None:
                    places, by_place = zip(*members, strict=True)
                    table += (values[:, list(places)] @ np.array(by_place)).tolist()
            least.append(bound)
            term_starts.append(len(cells))
        starts.append(len(least))
    columns = (starts, term_starts, least, cells, offsets, factors, table, [1] * len(conjunctions))
    return Goals._make(np.array(column, dtype=np.int64) for column in columns)
