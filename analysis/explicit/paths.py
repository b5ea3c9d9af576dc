"""Traces from the initial marking to a stored marking, and proofs of unboundedness from them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from dineros.analysis.explicit.layout import Layout
from dineros.analysis.explicit.tables import Markings
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.coverability import Pumping

#: Number of markings at the end of a trace that are compared with all earlier ones.
LAST_MARKINGS = 64


def path(layout: Layout, markings: Markings, row: int) -> list[list[int]]:
    """Markings from the initial one to a row."""
    way = [layout.unpack(markings.store[row])]
    while (row := int(markings.parents[row])) >= 0:
        way.append(layout.unpack(markings.store[row]))
    return way[::-1]


def steps(net: CompiledNet, markings: Sequence[list[int]]) -> tuple[int, ...]:
    """Return a transition for each step of a path; they are not stored, but follow from the markings."""
    return tuple(
        next(
            t
            for t in range(len(net.transitions))
            if net.is_enabled(t, before) and net.fire(t, before) == after
        )
        for before, after in pairwise(markings)
    )


def pumping(net: CompiledNet, markings: Sequence[list[int]]) -> Pumping | None:
    """A proof of unboundedness on a path: a later marking strictly covers an earlier one.

    The transitions fired between the two can be repeated forever unless a place that gained tokens inhibits
    them (Karp and Miller, *Parallel program schemata*, JCSS 3(2), 1969).
    """
    rows, trace = np.array(markings, dtype=np.int64), steps(net, markings)
    inhibitors = [{p for p, _ in net.inhibitor.row(t)} for t in trace]
    for last in range(len(rows) - 1, max(0, len(rows) - 1 - LAST_MARKINGS), -1):
        covered = (rows[last] >= rows[:last]).all(axis=1)
        inhibiting: set[int] = set()
        for first in range(last - 1, -1, -1):
            inhibiting |= inhibitors[first]
            if covered[first]:
                gained = tuple(np.flatnonzero(rows[last] > rows[first]).tolist())
                if gained and inhibiting.isdisjoint(gained):
                    return Pumping(trace[:first], trace[first:last], gained)
    return None
