"""Parser of guards and assignments: text to tree (grammar: ``guard.lark``)."""

from __future__ import annotations

from functools import cache, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dineros.metamodel.clauses.expressions import unquoted
from dineros.metamodel.errors import GuardError
from dineros.metamodel.grammars import parser_of
from dineros.metamodel.guards.conditions import (
    And,
    Assignment,
    Comparison,
    Condition,
    Constant,
    FieldName,
    Not,
    Or,
)

if TYPE_CHECKING:
    from lark import Lark, Token

MAX_LENGTH = 16_384
"""Longest text, in characters."""

MAX_DEPTH = 50
"""Deepest nesting of operators."""


@lru_cache(maxsize=1024)
def parse_guard(text: str) -> Condition:
    """Read a condition over fields of tokens.

    Operators, weakest first: ``or``, ``and``, ``not``, then ``=``, ``<>``, ``<``, ``<=``, ``>``, ``>=``,
    ``between ... and ...``. A field is ``Place.field`` or ``field``, a constant a number, ``true``, ``false``
    or a named value in single quotes.

    Raises
    ------
    GuardError
        The text is not such a condition, is too long, or is nested too deeply.
    """
    condition: Condition = _parsed(text, "condition")
    depth, level = 0, [condition]
    while level:
        depth += 1
        level = [operand for part in level for operand in part.operands]
    if depth > MAX_DEPTH:
        raise GuardError(f"it nests {depth} operators, more than {MAX_DEPTH}", hint="write it flatter")
    return condition


@lru_cache(maxsize=1024)
def parse_assignments(text: str) -> tuple[Assignment, ...]:
    """Read assignments to fields of tokens that a transition puts.

    They are written ``Answer.success := true, Log.mode := Entry.mode``.

    Raises
    ------
    GuardError
        The text does not have this form.
    """
    assignments: tuple[Assignment, ...] = _parsed(text, "assignments")
    return assignments


def _parsed(text: str, start: str) -> Any:
    from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

    if len(text) > MAX_LENGTH:
        raise GuardError(f"it has {len(text)} characters, more than {MAX_LENGTH}")
    try:
        return _parser().parse(text, start=start)
    except UnexpectedInput as error:
        found = ""
        if isinstance(error, UnexpectedToken):
            found = str(error.token)
        elif isinstance(error, UnexpectedCharacters):
            found = error.char
        where = f"column {error.column} has {found!r:.40}" if found else "it ends too early"
        example = "success = false and level between 1 and 3"
        hint = f"write it like {example if start == 'condition' else 'Answer.success := true'}"
        raise GuardError(f"{where}, which is not allowed there" if found else where, hint=hint) from None


@cache
def _parser() -> Lark:
    starts = ["condition", "assignments"]
    return parser_of(Path(__file__).with_name("guard.lark"), start=starts, transformer=_GuardBuilder())


class _GuardBuilder:
    """Builds the tree while the text is parsed; its methods have the names of the grammar's rules."""

    def plain(self, children: list[Token]) -> str:
        return str(children[0])

    def quoted(self, children: list[Token]) -> str:
        return unquoted(children[0])

    def field(self, children: list[str]) -> FieldName:
        return FieldName(children[0] if len(children) == 2 else None, children[-1])

    def number(self, children: list[Token]) -> Constant:
        return int(children[0])

    def true(self, _: list[Token]) -> Constant:
        return True

    def false(self, _: list[Token]) -> Constant:
        return False

    def named(self, children: list[Token]) -> Constant:
        return str(children[0])[1:-1]

    def comparison(self, children: list[Any]) -> Condition:
        field, sign, value = children
        return Comparison(field, str(sign), value)

    def between(self, children: list[Any]) -> Condition:
        field, low, high = children
        return And((Comparison(field, ">=", low), Comparison(field, "<=", high)))

    def not_between(self, children: list[Any]) -> Condition:
        return Not(self.between(children))

    def not_(self, children: list[Condition]) -> Condition:
        return Not(*children)

    def and_(self, children: list[Condition]) -> Condition:
        return And(tuple(children))

    def or_(self, children: list[Condition]) -> Condition:
        return Or(tuple(children))

    def assignment(self, children: list[Any]) -> Assignment:
        return Assignment(*children)

    def assignments(self, children: list[Assignment]) -> tuple[Assignment, ...]:
        return tuple(children)
