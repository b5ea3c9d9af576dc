"""Runs that repeat a loop forever, found breadth first: a marking covers one on the path to it."""

from __future__ import annotations

from collections.abc import Iterator

from dineros.analysis.answers.budget import Budget
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import moves

Marking = tuple[int, ...]

Lasso = tuple[tuple[int, ...], tuple[int, ...]]
"""Transitions of the stem, and of the loop."""


def near_lassos(net: CompiledNet, most: int, budget: Budget) -> Iterator[Lasso]:
    """Yield a lasso for each set of transitions of a loop, found among the first markings.

    The loop leaves at least its initial tokens. Inhibitor arcs at growing places are ignored.

    Parameters
    ----------
    budget : Budget
        Its time also ends the search.
    """
    first: Marking = tuple(net.initial.tolist())
    came: dict[Marking, tuple[Marking, int] | None] = {first: None}
    known: set[tuple[frozenset[int], frozenset[int]]] = set()
    todo = [first]
    for marking in todo:
        if len(todo) > most or budget.is_over:
            return
        way, fired = _way(came, marking)
        for t, after in moves(net, marking):
            for position in range(len(way) - 1, -1, -1):
                before = way[position]
                if all(new >= old for new, old in zip(after, before, strict=True)):
                    grown = frozenset(p for p, tokens in enumerate(after) if tokens > before[p])
                    loop = (*fired[position:], t)
                    if (kind := (frozenset(loop), grown)) not in known:
                        known.add(kind)
                        yield tuple(fired[:position]), loop
            if after not in came:
                came[after] = (marking, t)
                todo.append(after)


def _way(
    came: dict[Marking, tuple[Marking, int] | None], marking: Marking
) -> tuple[list[Marking], list[int]]:
    """Return the markings on the path to a marking, including it, and the transitions fired in between."""
    way, fired = [marking], []
    while (last := came[way[-1]]) is not None:
        way.append(last[0])
        fired.append(last[1])
    return way[::-1], fired[::-1]
