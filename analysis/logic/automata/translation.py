"""Translates LTL to a generalised Buchi automaton, via a very weak alternating automaton.

Of the alternating automaton, only the transition function is used: states are temporal subformulas, a
transition is a condition on the letter and a set of formulas that must hold next. States of the result are
such sets. An *until* may stay in them forever only if it is fulfilled infinitely often, which gives one
acceptance mark per until.

References
----------
P. Gastin, D. Oddoux, *Fast LTL to Buchi automata translation*, CAV 2001, LNCS 2102.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from dineros.analysis.logic.automata.automaton import Automaton, Edge
from dineros.analysis.logic.automata.simplification import reduced
from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.logic.language.rewriting import simplified
from dineros.analysis.logic.language.syntax import (
    FALSE,
    TRUE,
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

MAX_EDGES = 200_000
"""Maximum number of edges of an automaton before its reduction."""

MAX_MOVES = 4_096
"""Maximum number of combinations of moves of one state: each is compared with every other."""


def translate(formula: Formula) -> Automaton:
    """Return an automaton that accepts exactly the words that satisfy an LTL formula.

    Raises
    ------
    FormulaError
        Its automaton has more than `MAX_EDGES` edges, or a state with more than `MAX_MOVES` moves.
    """
    return reduced(_Translation(simplified(formula)).automaton())


class _AutomatonMove(NamedTuple):
    positive: int
    negative: int
    successors: frozenset[Formula]

    def weaker_or_equal(self, other: _AutomatonMove) -> bool:
        """Whether this move is possible whenever `other` is, and requires no more afterwards."""
        return (
            self.positive & ~other.positive == 0
            and self.negative & ~other.negative == 0
            and self.successors <= other.successors
        )


_STAY = _AutomatonMove(0, 0, frozenset())


class _Translation:
    def __init__(self, formula: Formula) -> None:
        self.formula = formula
        parts = formula.subformulas()
        self.atoms = tuple(p for p in parts if isinstance(p, Atom) and not isinstance(p, Constant))
        self.bit = {atom: 1 << i for i, atom in enumerate(self.atoms)}
        self.untils = [part for part in parts if isinstance(part, Until | Finally)]
        self.known: dict[Formula, list[_AutomatonMove]] = {}

    def automaton(self) -> Automaton:
        # A formula may start in several sets: an additional initial state has the moves of all of them.
        choices = _alternatives(self.formula)
        index: dict[frozenset[Formula], int] = {}
        rows: list[list[Edge]] = [[]]
        todo: list[frozenset[Formula]] = []
        total = 0

        def state(formulas: frozenset[Formula]) -> int:
            if formulas not in index:
                index[formulas] = len(index) + 1
                todo.append(formulas)
                rows.append([])
            return index[formulas]

        for choice in choices:
            state(choice)
        while todo:
            formulas = todo.pop()
            row = [
                Edge(move.positive, move.negative, marks, state(move.successors))
                for move, marks in self.moves_of_set(formulas)
            ]
            rows[index[formulas]] = row
            total += len(row)
            if total > MAX_EDGES:
                raise _too_large()
        rows[0] = [edge for choice in choices for edge in rows[index[choice]]]
        return Automaton(self.atoms, len(self.untils), 0, tuple(map(tuple, rows)))

    def moves_of_set(self, formulas: frozenset[Formula]) -> list[tuple[_AutomatonMove, int]]:
        moves = [_STAY]
        for formula in sorted(formulas, key=str):
            moves = _both(moves, self.moves(formula))
        marked = [(move, self.marks_of(move)) for move in moves]
        kept: list[tuple[_AutomatonMove, int]] = []
        for i, (move, marks) in enumerate(marked):
            for j, (other, others_marks) in enumerate(marked):
                is_better = j != i and other.weaker_or_equal(move) and marks & ~others_marks == 0
                is_equal = move.weaker_or_equal(other) and marks == others_marks
                if is_better and (j < i or not is_equal):
                    break
            else:
                kept.append((move, marks))
        return kept

    def marks_of(self, move: _AutomatonMove) -> int:
        marks = 0
        for i, until in enumerate(self.untils):
            if until not in move.successors or any(
                until not in way.successors and way.weaker_or_equal(move) for way in self.moves(until)
            ):
                marks |= 1 << i
        return marks

    def moves(self, formula: Formula) -> list[_AutomatonMove]:
        if formula not in self.known:
            self.known[formula] = _distinct(self.new_moves(formula))
        return self.known[formula]

    def new_moves(self, formula: Formula) -> Iterable[_AutomatonMove]:
        again = [_AutomatonMove(0, 0, frozenset([formula]))]
        match formula:
            case Constant(value):
                return [_STAY] if value else []
            case Not(Atom() as atom):
                return [_AutomatonMove(0, self.bit[atom], frozenset())]
            case Atom():
                return [_AutomatonMove(self.bit[formula], 0, frozenset())]
            case And(operands):
                moves = [_STAY]
                for operand in operands:
                    moves = _both(moves, self.moves(operand))
                return moves
            case Or(operands):
                return [move for operand in operands for move in self.moves(operand)]
            case Next(operand):
                return [_AutomatonMove(0, 0, choice) for choice in _alternatives(operand)]
            case Finally(operand):
                return [*self.moves(operand), *again]
            case Globally(operand):
                return _both(self.moves(operand), again)
            case Until(left, right):
                return [*self.moves(right), *_both(self.moves(left), again)]
            case Release(left, right):
                return _both(self.moves(right), [*self.moves(left), *again])
        raise TypeError(f"not in normal form: {formula}")


def _too_large() -> FormulaError:
    return FormulaError("the automaton of the formula is too large", hint="split the formula")


def _both(left: Iterable[_AutomatonMove], right: Iterable[_AutomatonMove]) -> list[_AutomatonMove]:
    left, right = list(left), list(right)
    if len(left) * len(right) > MAX_MOVES:
        raise _too_large()
    moves = (
        _AutomatonMove(a.positive | b.positive, a.negative | b.negative, a.successors | b.successors)
        for a in left
        for b in right
    )
    return _distinct(move for move in moves if not move.positive & move.negative)


def _distinct(moves: Iterable[_AutomatonMove]) -> list[_AutomatonMove]:
    return list(dict.fromkeys(moves))


def _alternatives(formula: Formula) -> list[frozenset[Formula]]:
    """Disjunctive normal form above temporal operators: sets whose conjunctions are the alternatives."""
    if formula in (TRUE, FALSE):
        return [frozenset()] if formula == TRUE else []
    if isinstance(formula, Or):
        found = [choice for operand in formula.operands for choice in _alternatives(operand)]
    elif isinstance(formula, And):
        found = [frozenset()]
        for operand in formula.operands:
            found = [choice | more for choice in found for more in _alternatives(operand)]
    else:
        found = [frozenset([formula])]
    distinct = list(dict.fromkeys(found))
    return [choice for choice in distinct if not any(other < choice for other in distinct)]
