"""Runs that repeat a loop forever, met breadth first: a marking covers one on the way to it."""

from __future__ import annotations

from collections.abc import Iterator

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.verdicts.verdict import Marking, moves
from dineros.analysis.nets.compiled import CompiledNet

Lasso = tuple[tuple[int, ...], tuple[int, ...]]
"""Transitions of the stem, and of the loop."""


def near_lassos(net: CompiledNet, most: int, budget: Budget) -> Iterator[Lasso]:
    """Yield a lasso for each set of transitions that a loop fires, of those met among the first markings.

    The loop leaves at least the tokens that it finds. Inhibitor arcs at places that grow are not looked at.

    Parameters
    ----------
    most : int
        Markings looked at.
    budget : Budget
        Whose time ends the search, too.
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
    """Return the markings on the way to one, itself included, and the transitions fired in between."""
    way, fired = [marking], []
    while (last := came[way[-1]]) is not None:
        way.append(last[0])
        fired.append(last[1])
    return way[::-1], fired[::-1]
