"""Linear state classes of one firing sequence, in plain exact numbers, apart from the kernels.

A class is a marking and, for each enabled transition, in how much time it may fire, as bounds of differences
(Berthomieu and Diaz, 1991). Index 0 of a matrix is the present; transition ``enabled[i]`` has index i + 1.
This module shares nothing with the search but the net, so it checks what the search finds.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from dineros.analysis.timed.nets import TimedNet

Bound: TypeAlias = tuple[Fraction, bool] | None
"""A difference is at most so much, or less where the flag is set; None: there is no bound."""
Matrix: TypeAlias = tuple[tuple[Bound, ...], ...]

AT_MOST_0: Bound = (Fraction(0), False)


def tighter(one: Bound, other: Bound) -> Bound:
    """Return the tighter one of two bounds."""
    if one is None or other is None:
        return other if one is None else one
    return one if (one[0], not one[1]) <= (other[0], not other[1]) else other


def added(one: Bound, other: Bound) -> Bound:
    """Return the bound of a sum."""
    if one is None or other is None:
        return None
    return one[0] + other[0], one[1] or other[1]


@dataclass(frozen=True)
class PlainClass:
    """A state class.

    Attributes
    ----------
    enabled : tuple of int
        The transitions that have their tokens, ascending.
    matrix : Matrix
        Of differences of their firing times, in normal form.
    """

    marking: tuple[int, ...]
    enabled: tuple[int, ...]
    matrix: Matrix

    @classmethod
    def initial(cls, net: TimedNet) -> PlainClass:
        """Return the class in which a net begins."""
        marking = tuple(net.untimed.initial.tolist())
        enabled = enabled_in(net, marking)
        return cls(marking, enabled, _joined(net, enabled, {}, None))

    def is_within(self, other: PlainClass) -> bool:
        """Whether all states of this class are states of the other."""
        if (self.marking, self.enabled) != (other.marking, other.enabled):
            return False
        size = range(len(self.matrix))
        return all(
            tighter(self.matrix[i][j], other.matrix[i][j]) == self.matrix[i][j] for i in size for j in size
        )

    def after(self, net: TimedNet, fired: int) -> PlainClass | None:
        """Return the class after a firing; None if the transition cannot fire next.

        The net has no priorities: linear classes do not know them.
        """
        if fired not in self.enabled:
            return None
        first = self.enabled.index(fired) + 1
        rows = [list(row) for row in self.matrix]
        for other in range(1, len(rows)):
            rows[first][other] = tighter(rows[first][other], AT_MOST_0)  # it fires before all others
        closed = normal_form(rows)
        if closed is None:
            return None
        between = list(self.marking)
        for place, weight in net.take.row(fired):
            between[place] -= weight
        marking = list(between)
        for place, weight in net.put.row(fired):
            marking[place] += weight
        kept = {
            t: index
            for index, t in enumerate(self.enabled, 1)
            if t != fired and net.untimed.is_enabled(t, between) and net.untimed.is_enabled(t, marking)
        }
        enabled = enabled_in(net, marking)
        return PlainClass(tuple(marking), enabled, _joined(net, enabled, kept, (closed, first)))


def enabled_in(net: TimedNet, marking: Sequence[int]) -> tuple[int, ...]:
    """Return the transitions that have their tokens."""
    return tuple(t for t in range(len(net.untimed.transitions)) if net.untimed.is_enabled(t, marking))


def classes_along(net: TimedNet, trace: Sequence[int]) -> Iterator[PlainClass]:
    """Yield the class before each firing of a sequence, and the last one; end where one cannot fire."""
    here: PlainClass | None = PlainClass.initial(net)
    assert here is not None
    yield here
    for fired in trace:
        here = here.after(net, fired)
        if here is None:
            return
        yield here


def _joined(
    net: TimedNet,
    enabled: Sequence[int],
    kept: dict[int, int],
    before: tuple[list[list[Bound]], int] | None,
) -> Matrix:
    """Return the matrix of transitions that keep their times, counted from the firing, and of others."""
    size = len(enabled) + 1
    rows: list[list[Bound]] = [[AT_MOST_0 if i == j else None for j in range(size)] for i in range(size)]
    for i, t in enumerate(enabled, 1):
        if before is not None and t in kept:
            matrix, first = before
            rows[i][0], rows[0][i] = matrix[kept[t]][first], matrix[first][kept[t]]
            for j, u in enumerate(enabled, 1):
                if u in kept:
                    rows[i][j] = matrix[kept[t]][kept[u]]
        else:
            interval = net.intervals[t]
            rows[i][0] = None if interval.latest is None else (interval.latest, interval.is_open_above)
            rows[0][i] = (-interval.earliest, interval.is_open_below)
    closed = normal_form(rows)
    assert closed is not None, "what is enabled has an interval that is not empty"
    return tuple(tuple(row) for row in closed)


def normal_form(rows: list[list[Bound]]) -> list[list[Bound]] | None:
    """Return the normal form (Floyd and Warshall); None if nothing fulfils the bounds."""
    size = range(len(rows))
    for k in size:
        for i in size:
            through = rows[i][k]
            if through is not None:
                for j in size:
                    rows[i][j] = tighter(rows[i][j], added(through, rows[k][j]))
    for i in size:
        own = rows[i][i]
        assert own is not None
        if own[0] < 0 or (own[0] == 0 and own[1]):
            return None
        rows[i][i] = AT_MOST_0
    return rows
