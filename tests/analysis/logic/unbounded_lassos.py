"""``python -m tests.analysis.logic.unbounded_lassos 40``: LTL of unbounded models against lassos.

The search goes breadth first and compares each new marking with those on the way to it: where it covers one,
and nothing that the firings in between look at is lost or inhibited by more tokens, these can be repeated for
ever. A test does the same with a few models.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import NamedTuple

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.ltl.verification import verify_ltl
from dineros.analysis.model.subject import base_subject
from dineros.analysis.nets.compiled import CompiledNet
from dineros.metamodel import sym
from tests.support.systems.unbounded_systems import each_of

MOST_MARKINGS, SECONDS = 3_000, 30.0
Marking = tuple[int, ...]


class Lasso(NamedTuple):
    """A run that repeats a loop forever: its markings up to the first end of the loop, and what is fired."""

    markings: tuple[Marking, ...]
    start: int
    loop: tuple[int, ...]


def lassos(net: CompiledNet, most: int = MOST_MARKINGS) -> Iterator[Lasso]:
    """Yield the lassos that are met among the first markings."""
    first = tuple(net.initial.tolist())
    came: dict[Marking, tuple[Marking, int] | None] = {first: None}
    todo = [first]
    for marking in todo:
        if len(todo) > most:
            return
        way: list[Marking] = [marking]
        fired: list[int] = []
        while (before := came[way[0]]) is not None:
            way.insert(0, before[0])
            fired.insert(0, before[1])
        for t in range(len(net.transitions)):
            if not net.is_enabled(t, marking):
                continue
            after = tuple(net.fire(t, marking))
            for position in range(len(way) - 1, -1, -1):
                if all(new >= old for new, old in zip(after, way[position], strict=True)):
                    loop = (*fired[position:], t)
                    grown = {
                        p for p, (new, old) in enumerate(zip(after, way[position], strict=True)) if new > old
                    }
                    if not any(p in grown for u in loop for p, _ in net.inhibitor.row(u)):
                        yield Lasso((*way, after), position, loop)
                        break
            if after not in came:
                came[after] = (marking, t)
                todo.append(after)


def refuted(net: CompiledNet, most: int = MOST_MARKINGS) -> dict[str, Lasso]:
    """Formulas that a lasso refutes, as is read off it."""
    found: dict[str, Lasso] = {}
    for lasso in lassos(net, most):
        held = [0] * len(net.places)
        for marking in lasso.markings:
            held = [max(pair) for pair in zip(held, marking, strict=True)]
        grown = {p for p, tokens in enumerate(lasso.markings[-1]) if tokens > lasso.markings[lasso.start][p]}
        for t, name in enumerate(net.transitions):
            text = f'F G !fired("{name}")' if t in lasso.loop else f'G F fired("{name}")'
            found.setdefault(text, lasso)
        for p, name in enumerate(net.places):
            if p in grown:
                found.setdefault(f'G ("{name}" <= {held[p] + 5})', lasso)
                found.setdefault(f'G F ("{name}" <= {held[p] + 2})', lasso)
            else:
                found.setdefault(f'F ("{name}" >= {held[p] + 1})', lasso)
    return found


def compare(model: sym.SystemModel, most: int = MOST_MARKINGS, formulas: int = 12) -> list[str]:
    """Raise if a formula that a lasso refutes is not; return those asked."""
    net = base_subject(model).net
    known = sorted(refuted(net, most), key=hash_of)[:formulas]
    for formula in known:
        answer = verify_ltl(net, formula, NetNames(net), budget=Budget(1 << 29, seconds=SECONDS))
        assert answer.status == "violated", f"{formula}: {answer.status}, {answer.reason}"
    return known


def hash_of(text: str) -> int:
    """Mix formulas of all kinds, in every run alike."""
    return sum(ord(letter) * (number + 7) ** 3 for number, letter in enumerate(text)) % 1009


if __name__ == "__main__":
    number = int(sys.argv[1]) if len(sys.argv) > 1 else 40
    each_of(number, lambda model: f"{len(compare(model))} formulas refuted")
