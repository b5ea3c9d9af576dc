"""The meaning of LTL on ultimately periodic words, evaluated directly: it verifies every verdict.

It is independent of the automata: subformulas are evaluated bottom-up on the finitely many suffixes of the
word, least fixpoints from false and greatest ones from true.

References
----------
N. Markey, Ph. Schnoebelen, *Model checking a path*, CONCUR 2003, LNCS 2761.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from dineros.analysis.logic.language.syntax import (
    And,
    Atom,
    Constant,
    Equivalent,
    Finally,
    Formula,
    Globally,
    Implies,
    Next,
    Not,
    Or,
    Release,
    Until,
    WeakUntil,
)

Letter = TypeVar("Letter")


def holds_on_lasso(
    formula: Formula, stem: Sequence[Letter], loop: Sequence[Letter], is_true: Callable[[Atom, Letter], bool]
) -> bool:
    """Return whether the word ``stem loop loop ...`` satisfies an LTL formula.

    Parameters
    ----------
    stem, loop : sequence of letters
        The word; the loop has at least one letter.
    is_true : callable
        Whether an atom (not a constant) is true at a letter.
    """
    return values_on_lasso(formula, stem, loop, is_true)[formula][0]


def values_on_lasso(
    formula: Formula, stem: Sequence[Letter], loop: Sequence[Letter], is_true: Callable[[Atom, Letter], bool]
) -> dict[Formula, list[bool]]:
    """Return the value of each part of an LTL formula at each letter; see `holds_on_lasso`."""
    letters = [*stem, *loop]
    size, back = len(letters), len(stem)
    values: dict[Formula, list[bool]] = {}

    def fixpoint(start: bool, here: Sequence[bool], stay: Sequence[bool]) -> list[bool]:
        # At each position: here, or stay and the value at the next position. Two rounds of the loop are
        # sufficient.
        row, later = [start] * size, start
        for _ in range(2):
            for i in reversed(range(size)):
                later = row[i] = here[i] or (stay[i] and (later if i + 1 < size else row[back]))
        return row

    for part in formula.subformulas():
        rows = [values[operand] for operand in part.operands]
        match part:
            case Constant(value):
                row = [value] * size
            case Atom():
                row = [is_true(part, letter) for letter in letters]
            case Not():
                row = [not value for value in rows[0]]
            case And():
                row = [all(column) for column in zip(*rows, strict=True)]
            case Or():
                row = [any(column) for column in zip(*rows, strict=True)]
            case Implies():
                row = [not left or right for left, right in zip(*rows, strict=True)]
            case Equivalent():
                row = [left == right for left, right in zip(*rows, strict=True)]
            case Next():
                row = [rows[0][i + 1 if i + 1 < size else back] for i in range(size)]
            case Finally():
                row = fixpoint(False, rows[0], [True] * size)
            case Globally():
                row = fixpoint(True, [False] * size, rows[0])
            case Until():
                row = fixpoint(False, rows[1], rows[0])
            case WeakUntil():
                row = fixpoint(True, rows[1], rows[0])
            case Release():
                both = [left and right for left, right in zip(*rows, strict=True)]
                row = fixpoint(True, both, rows[1])
            case _:
                raise TypeError(f"no LTL formula: {part}")
        values[part] = row
    return values
