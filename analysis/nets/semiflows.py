"""Minimal semiflows of a net, if there are few.

There can be exponentially many: k clients that use m services of k instances each have more semiflows than
markings. So their enumeration has a work limit, which is checked before rows are combined. If the limit is
reached, the caller continues without semiflows: with invariants of two places and a basis (`structure`), and
with linear programs for one place (`bounds`) or a group of places (`state_machines`). Their cost does not
grow with the number of semiflows.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from heapq import heappop, heappush
from math import gcd
from typing import NamedTuple

from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.structure import PlaceInvariant

#: Maximum number of row entries examined: less than a second. The case study needs 20,000.
MOST_WORK = 1_000_000

#: The same for `is_consistent`: a few milliseconds.
LITTLE_WORK = 5_000


def semiflows(net: CompiledNet, most_work: int = MOST_WORK) -> list[PlaceInvariant] | None:
    """Return all minimal-support semiflows; None: this takes more work than allowed.

    References
    ----------
    J. M. Colom and M. Silva, *Convex geometry and semiflows in P/T nets*, Advances in Petri Nets 1990, LNCS
    483.
    """
    residuals: list[dict[int, int]] = [{} for _ in net.places]
    for number, change in enumerate(net.delta):
        for p, tokens in change.items():
            residuals[p][number] = tokens
    rows = _eliminated(residuals, most_work)
    return None if rows is None else in_order(PlaceInvariant.of(net, row.weights) for row in rows)


def is_consistent(net: CompiledNet, most_work: int = LITTLE_WORK) -> bool:
    """Return whether some firings, each transition at least once, add up to no change of the marking.

    Then every weighted sum of tokens that no firing increases is constant. False also means: this takes more
    work than allowed.

    Examples
    --------
    >>> circle = CompiledNet.build({"a": 1, "b": 0}, [("t", {"a": 1}, {"b": 1}), ("u", {"b": 1}, {"a": 1})])
    >>> is_consistent(circle)
    True
    """
    raised = {p for change in net.delta for p, tokens in change.items() if tokens > 0}
    lowered = {p for change in net.delta for p, tokens in change.items() if tokens < 0}
    if raised != lowered:
        return False
    rows = _eliminated(net.delta, most_work)
    return rows is not None and len({t for row in rows for t in row.weights}) == len(net.delta)


def _eliminated(residuals: Sequence[Mapping[int, int]], most_work: int) -> _Rows | None:
    """Return the minimal weightings of rows whose weighted sum is zero; None: too much work."""
    rows = _Rows(most_work)
    for number, residual in enumerate(residuals):
        rows.add(_Row(dict(residual), {number: 1}, 1 << number))
    while (column := rows.cheapest()) is not None:
        if not rows.eliminate(column):
            return None
    return rows


def in_order(flows: Iterable[PlaceInvariant]) -> list[PlaceInvariant]:
    """Return semiflows in the order of `semiflows`: those of few places first."""
    return sorted(flows, key=lambda y: (len(y.weights), y.constant, list(y.weights)))


class _Row(NamedTuple):
    """An intermediate weighting: the change of its sum by each transition, and its places as bits."""

    residual: dict[int, int]
    weights: dict[int, int]
    support: int

    @property
    def lowest(self) -> int:
        """Its lowest place."""
        return (self.support & -self.support).bit_length() - 1

    @property
    def entries(self) -> int:
        """The cost of combining it with another row."""
        return len(self.residual) + len(self.weights)


class _Rows:
    """The intermediate weightings, indexed by the transitions that change them and by their lowest place.

    Elimination uses few of many rows: without the indices, nets of thousands of places take minutes.
    """

    def __init__(self, work: int) -> None:
        self._work_left = work
        self._rows: dict[int, _Row] = {}
        self._made = 0
        self._raised: defaultdict[int, set[int]] = defaultdict(set)
        self._lowered: defaultdict[int, set[int]] = defaultdict(set)
        #: Supports by number.
        self._by_lowest_place: defaultdict[int, dict[int, int]] = defaultdict(dict)
        #: (number of rows that elimination adds, transition); an entry is outdated if the number has changed.
        self._costs: list[tuple[int, int]] = []
        #: Transitions whose current number is not among the costs.
        self._changed: set[int] = set()

    def __iter__(self) -> Iterator[_Row]:
        return iter(self._rows.values())

    def add(self, row: _Row) -> None:
        """Add a row."""
        number = self._made
        self._made += 1
        self._rows[number] = row
        self._by_lowest_place[row.lowest][number] = row.support
        for t, tokens in row.residual.items():
            (self._raised if tokens > 0 else self._lowered)[t].add(number)
        self._changed.update(row.residual)

    def cheapest(self) -> int | None:
        """Return the transition whose elimination adds the fewest rows; None: none is left."""
        for t in self._changed:
            heappush(self._costs, (self._cost(t), t))
        self._changed.clear()
        while self._costs:
            cost, t = heappop(self._costs)
            if (self._raised[t] or self._lowered[t]) and cost == self._cost(t):
                return t
        return None

    def eliminate(self, t: int) -> bool:
        """Replace the rows that a transition changes by combinations that it does not change.

        Return False, before any combination, if the work limit is reached.
        """
        positive = [self._take(number) for number in sorted(self._raised[t])]
        negative = [self._take(number) for number in sorted(self._lowered[t])]
        self._work_left -= len(negative) * sum(row.entries for row in positive)
        self._work_left -= len(positive) * sum(row.entries for row in negative)
        if self._work_left < 0:
            return False
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
                made[support] = _Row(residual, weights, support)
        for support in sorted(made, key=lambda bits: (bits.bit_count(), bits)):
            # Only rows of minimal support can lead to minimal semiflows.
            if not self._holds_part_of(made[support]):
                self.add(made[support])
        return True

    def _holds_part_of(self, row: _Row) -> bool:
        outside = ~row.support
        near = [self._by_lowest_place[place] for place in row.weights if place in self._by_lowest_place]
        self._work_left -= sum(map(len, near))
        # Plain loops: millions of supports are compared.
        for supports in near:
            for support in supports.values():
                if not support & outside:
                    return True
        return False

    def _take(self, number: int) -> _Row:
        row = self._rows.pop(number)
        del self._by_lowest_place[row.lowest][number]
        for t, tokens in row.residual.items():
            (self._raised if tokens > 0 else self._lowered)[t].discard(number)
        self._changed.update(row.residual)
        return row

    def _cost(self, t: int) -> int:
        lowered, raised = len(self._lowered[t]), len(self._raised[t])
        return lowered * raised - lowered - raised


def _combine(one: dict[int, int], a: int, other: dict[int, int], b: int) -> dict[int, int]:
    total = {key: a * value for key, value in one.items()}
    for key, value in other.items():
        total[key] = total.get(key, 0) + b * value
    return {key: value for key, value in total.items() if value}
