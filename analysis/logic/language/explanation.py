"""Explains why a run violates an LTL formula: the literals, with their positions, that cause the violation.

If one of them were different, the formula would not fail in this way. Positions after the first failure of a
part are ignored. The approximation is that of the paper, on lassos instead of finite prefixes; its time is
proportional to the sizes of formula and run.

References
----------
I. Beer, S. Ben-David, H. Chockler, A. Orni, R. Trefler, *Explaining counterexamples using causality*, Formal
Methods in System Design 40(1), 2012.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from dineros.analysis.logic.language.rewriting import simplified
from dineros.analysis.logic.language.semantics import values_on_lasso
from dineros.analysis.logic.language.syntax import (
    And,
    Atom,
    Constant,
    Finally,
    Formula,
    Globally,
    Next,
    Not,
    Or,
    Release,
    Until,
)

Letter = TypeVar("Letter")

Occurrence = tuple[int, Atom, bool]
"""A position, an atom, and its value there."""


def explanation(
    formula: Formula, stem: Sequence[Letter], loop: Sequence[Letter], is_true: Callable[[Atom, Letter], bool]
) -> list[Occurrence] | None:
    """Return the causes of a violation, by position; None: the run satisfies the formula.

    Parameters
    ----------
    stem, loop : sequence of letters
        The run ``stem loop loop ...``; the loop has at least one letter.
    is_true : callable
        Whether an atom (not a constant) is true at a letter.

    Examples
    --------
    >>> from dineros.analysis.logic.language.parser import parse
    >>> run = [{"asked >= 1"}, {"asked >= 1", "done >= 1"}, {"asked >= 1"}]
    >>> found = explanation(
    ...     parse("G (asked >= 1 -> F done >= 1)"), run, [set()], lambda atom, letter: str(atom) in letter
    ... )
    >>> [(position, str(atom), value) for position, atom, value in found or []]
    [(2, 'asked >= 1', True), (2, 'done >= 1', False), (3, 'done >= 1', False)]
    """
    normal = simplified(formula)
    values = values_on_lasso(normal, stem, loop, is_true)
    return None if values[normal][0] else _Word(values, len(stem)).explain(normal)


class _Word:
    """The values of all parts of a formula in negation normal form, at all positions of a lasso."""

    def __init__(self, values: Mapping[Formula, Sequence[bool]], back: int) -> None:
        self._values, self._back = values, back

    def _after(self, part: Formula, position: int) -> tuple[Formula, int]:
        return part, position + 1 if position + 1 < len(self._values[part]) else self._back

    def explain(self, formula: Formula) -> list[Occurrence]:
        """Return the causes for a formula being false at the first position."""
        found: dict[Occurrence, None] = {}
        seen: set[tuple[Formula, int]] = set()
        todo: list[tuple[Formula, int]] = [(formula, 0)]
        while todo:
            part, position = todo.pop()
            if (part, position) in seen:
                continue
            seen.add((part, position))
            literal = part.operand if isinstance(part, Not) else part
            if isinstance(literal, Atom):
                if not isinstance(literal, Constant):
                    found[position, literal, literal is not part] = None
            else:
                todo += self._blamed(part, position)
        return sorted(found, key=lambda occurrence: (occurrence[0], str(occurrence[1])))

    def _blamed(self, part: Formula, position: int) -> list[tuple[Formula, int]]:
        """Return the parts, with positions, that make a part false."""
        operands = part.operands
        after = self._after(part, position)
        match part:
            case And() | Or():
                return [(operand, position) for operand in operands if self._is_false(operand, position)]
            case Next():
                return [self._after(operands[0], position)]
            case Finally():
                return [(operands[0], position), after]
            case Globally():
                return [(operands[0], position) if self._is_false(operands[0], position) else after]
            case Until():
                first, second = (operands[0], position), (operands[1], position)
                return [second, first if self._is_false(*first) else after]
            case Release():
                first, second = (operands[0], position), (operands[1], position)
                return [second] if self._is_false(*second) else [first, after]
        raise TypeError(f"no LTL formula in normal form: {part}")

    def _is_false(self, part: Formula, position: int) -> bool:
        return not self._values[part][position]
