"""Parses formulas (grammar: ``formula.lark``), with limits, and columns in errors.

Precedence, tightest first: ``! G F X AG AF AX EG EF EX``; ``U R W`` (group to the right); ``&``; ``|``;
``->`` (groups to the right); ``<->`` (groups to the left). So ``G a -> b`` is ``(G a) -> b`` and ``a & b U
c`` is ``a & (b U c)``. Written as well: ``and or not``, ``&& ||``, ``∧ ∨ ¬ → ↔ ≤ ≥ ≠``, ``[]`` and ``<>`` for
``G`` and ``F``, ``GF`` for ``G F``.
"""

from __future__ import annotations

import re
from functools import cache, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple, cast

from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.logic.language.syntax import (
    FALSE,
    QUANTIFIERS,
    TEMPORAL,
    TRUE,
    And,
    Comparison,
    ComparisonOperator,
    Deadlock,
    Enabled,
    Equivalent,
    Exists,
    Finally,
    Fired,
    ForAll,
    Formula,
    Globally,
    Implies,
    Name,
    Next,
    Not,
    Or,
    Release,
    SignalTrue,
    Until,
    WeakUntil,
)
from dineros.metamodel.grammars import parser_of

if TYPE_CHECKING:
    from lark import Lark, Token
    from lark.exceptions import UnexpectedInput

Logic = Literal["ltl", "ctl", "state"]

MAX_LENGTH = 65_536
"""Maximum length of a formula, in characters."""

MAX_DEPTH = 100
"""Maximum nesting of operators."""

LARGEST_FACTOR = 2**40
"""Maximum factor of a place in a comparison."""

LARGEST_BOUND = 2**60
"""Maximum number with which a sum is compared."""

_UNARY: dict[str, type[Next | Finally | Globally]] = {"X": Next, "F": Finally, "G": Globally}
_QUANTIFIERS: dict[str, type[ForAll | Exists]] = {"A": ForAll, "E": Exists}
_BINARY: dict[str, type[Until | Release | WeakUntil]] = {"U": Until, "R": Release, "W": WeakUntil}
_SPELLING: dict[str, ComparisonOperator] = {"=": "==", "≤": "<=", "≥": ">=", "≠": "!="}

_MIRRORED = {"<=": ">=", ">=": "<=", "<": ">", ">": "<", "≤": "≥", "≥": "≤"}


@lru_cache(maxsize=1024)
def parse(text: str, logic: Logic = "ltl") -> Formula:
    """Read a formula.

    Parameters
    ----------
    logic : {"ltl", "ctl", "state"}
        ``ltl`` allows ``G F X U R W`` and ``fired``; ``ctl`` allows ``AG AF AX EG EF EX A[..U..] E[..U..]``
        (``R`` and ``W`` too); ``state`` allows none of these: a condition on one marking.

    Raises
    ------
    FormulaError
        The text is not such a formula (`column` is the position), or exceeds `MAX_LENGTH` or `MAX_DEPTH`.
    """
    if len(text) > MAX_LENGTH:
        raise FormulaError(
            f"the formula has {len(text)} characters, more than {MAX_LENGTH}", column=MAX_LENGTH + 1
        )
    from lark.exceptions import UnexpectedInput

    try:
        formula = cast(Formula, _parser().parse(text))
    except UnexpectedInput as error:
        raise _syntax_error(text, error) from None
    _check_depth(formula)
    _check_logic(formula, logic)
    return formula


@cache
def _parser() -> Lark:
    grammar = Path(__file__).with_name("formula.lark")
    return parser_of(grammar, transformer=_Builder(), maybe_placeholders=False)


class _Sum(NamedTuple):
    """A weighted sum of tokens and a number, as read: names may occur several times."""

    terms: tuple[tuple[int, Name], ...] = ()
    constant: int = 0

    def times(self, factor: int) -> _Sum:
        return _Sum(tuple((factor * weight, name) for weight, name in self.terms), factor * self.constant)

    def plus(self, other: _Sum) -> _Sum:
        return _Sum(self.terms + other.terms, self.constant + other.constant)


class _Builder:
    """Builds the tree during parsing: bottom-up, so that no nesting can exhaust the stack.

    Its methods are called by the names of the grammar's rules.
    """

    def equivalent(self, children: list[Formula]) -> Formula:
        return Equivalent(children[0], children[-1])

    def implies(self, children: list[Formula]) -> Formula:
        return Implies(children[0], children[-1])

    def or_(self, children: list[Formula | Token]) -> Formula:
        return Or(tuple(child for child in children if isinstance(child, Formula)))

    def and_(self, children: list[Formula | Token]) -> Formula:
        return And(tuple(child for child in children if isinstance(child, Formula)))

    def not_(self, children: list[Formula]) -> Formula:
        return Not(children[-1])

    def binary_temporal(self, children: tuple[Formula, Token, Formula]) -> Formula:
        left, token, right = children
        return _BINARY[token](left, right, column=_column(token))

    def temporal(self, children: tuple[Token, Formula]) -> Formula:
        token, formula = children
        letters = {"<": "F", "[": "G"}.get(token[0], str(token))
        for offset, letter in reversed(list(enumerate(letters))):
            formula = _UNARY[letter](formula, column=_column(token) + offset)
        return formula

    def quantified(self, children: tuple[Token, Formula]) -> Formula:
        token, formula = children
        path = _UNARY[token[1]](formula, column=_column(token))
        return _QUANTIFIERS[token[0]](path, column=_column(token))

    def quantified_path(self, children: tuple[Token, Formula]) -> Formula:
        token, path = children
        return _QUANTIFIERS[token](path, column=_column(token))

    def true(self, _: list[Token]) -> Formula:
        return TRUE

    def false(self, _: list[Token]) -> Formula:
        return FALSE

    def deadlock(self, _: list[Token]) -> Formula:
        return Deadlock()

    def enabled(self, children: list[Name]) -> Formula:
        return Enabled(children[-1])

    def fired(self, children: list[Name]) -> Formula:
        return Fired(children[-1])

    def signal(self, children: list[Name]) -> Formula:
        return SignalTrue(children[-1])

    def comparison(self, children: list[_Sum | Token]) -> Formula:
        """Read ``a <= b <= c`` as the conjunction of its neighbours."""
        sums = [child for child in children if isinstance(child, _Sum)]
        operators = [str(child) for child in children if not isinstance(child, _Sum)]
        parts = tuple(
            _compare(left, operator, right)
            for left, operator, right in zip(sums, operators, sums[1:], strict=False)
        )
        return parts[0] if len(parts) == 1 else And(parts)

    def sum(self, children: list[_Sum | Token]) -> _Sum:
        total, sign = _Sum(), 1
        for child in children:
            if isinstance(child, _Sum):
                total = total.plus(child.times(sign))
            else:
                sign = -1 if child == "-" else 1
        return total

    def scaled(self, children: tuple[Token, _Sum]) -> _Sum:
        return children[-1].times(int(children[0]))

    def number(self, children: list[Token]) -> _Sum:
        return _Sum((), int(children[0]))

    def named(self, children: list[Name]) -> _Sum:
        return _Sum(((1, children[0]),))

    def name(self, children: list[Token]) -> Name:
        token = children[0]
        text = str(token)
        if token.type != "NAME":
            text = re.sub(r"\\(.)", r"\1", text[1:-1])
        return Name(text, _column(token))


def _compare(left: _Sum, operator: str, right: _Sum) -> Formula:
    difference = left.plus(right.times(-1))
    weights: dict[Name, int] = {}
    for weight, name in difference.terms:
        weights[name] = weights.get(name, 0) + weight
    terms = tuple((weight, name) for name, weight in weights.items() if weight)
    if any(abs(weight) > LARGEST_FACTOR for weight, _ in terms) or abs(difference.constant) > LARGEST_BOUND:
        raise FormulaError("the numbers of a comparison are too large", column=_first_column(difference))
    if terms and terms[0][0] < 0:
        # `1 <= A` reads better as `A >= 1`.
        terms = tuple((-weight, name) for weight, name in terms)
        operator, difference = _MIRRORED.get(operator, operator), difference.times(-1)
    spelled = _SPELLING.get(operator, cast(ComparisonOperator, operator))
    return Comparison(terms, spelled, -difference.constant)


def _first_column(terms: _Sum) -> int | None:
    return min((name.column for _, name in terms.terms), default=None)


def _column(token: Token) -> int:
    return token.column or 0


def _check_depth(formula: Formula) -> None:
    level = [formula]
    for _ in range(MAX_DEPTH):
        level = [operand for part in level for operand in part.operands]
        if not level:
            return
    raise FormulaError(f"the formula nests more than {MAX_DEPTH} operators", column=1)


def _check_logic(formula: Formula, logic: Logic) -> None:
    # Every occurrence is checked: equal parts may be allowed here and not there.
    todo = [(formula, False)]
    while todo:
        part, is_quantified = todo.pop()
        todo.extend((operand, isinstance(part, QUANTIFIERS)) for operand in reversed(part.operands))
        if isinstance(part, Fired) and logic != "ltl":
            raise FormulaError(
                f"{part} is about a step, so it belongs to LTL", column=part.name.column, hint="use --ltl"
            )
        if isinstance(part, QUANTIFIERS) and logic != "ctl":
            hint = "use --ctl" if logic == "ltl" else "a condition on one marking has no temporal operators"
            raise FormulaError(f"the quantifier {part.symbol} belongs to CTL", column=part.column, hint=hint)
        if isinstance(part, QUANTIFIERS) and not isinstance(part.operand, TEMPORAL):
            raise FormulaError(
                f"{part.symbol} needs a temporal operator right after it",
                column=part.column,
                hint=f"write {part.symbol}G, {part.symbol}F, {part.symbol}X or {part.symbol}[a U b]",
            )
        is_misplaced = logic == "state" or (logic == "ctl" and not is_quantified)
        if isinstance(part, TEMPORAL) and is_misplaced:
            hint = "write A or E before it" if logic == "ctl" else "a condition on one marking has none"
            raise FormulaError(
                f"the temporal operator {part.symbol} is not allowed here", column=part.column, hint=hint
            )


def _syntax_error(text: str, error: UnexpectedInput) -> FormulaError:
    from lark.exceptions import UnexpectedCharacters, UnexpectedToken

    column: int | None = len(text) + 1
    what = "the formula ends too early" if text.strip() else "the formula is empty"
    expected: set[str] = set()
    if isinstance(error, UnexpectedCharacters):
        position: int = getattr(error, "pos_in_stream", None) or 0
        column, what = error.column, f"{text[position]!r} is not allowed here"
        expected = set(error.allowed or ())
    elif isinstance(error, UnexpectedToken):
        expected = set(error.accepts or error.expected)
        if error.token.type != "$END":
            column, what = error.column, f"{str(error.token)!r} is not allowed here"
    hint = None
    if "COMPARISON" in expected:
        hint = "a name alone is not a formula: write NAME >= 1, enabled(NAME) or signal(NAME)"
    elif expected == {"NAME", "QUOTED", "BRACED"}:
        hint = 'a name is expected; put an unusual one in quotes, "..."'
    elif "INTEGER" in expected:
        hint = "a formula such as NAME >= 1 is expected"
    return FormulaError(what, column=column, hint=hint)
