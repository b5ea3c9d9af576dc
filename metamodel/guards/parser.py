"""Parser of guards and assignments: text to tree (grammar: ``guard.lark``)."""

from __future__ import annotations

import re
from functools import cache, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dineros.metamodel.clauses.expressions import And, Not, Or, unquoted
from dineros.metamodel.errors import GuardError
from dineros.metamodel.grammars import parser_of
from dineros.metamodel.guards.conditions import (
    TURNED,
    Assignment,
    Comparison,
    Condition,
    Constant,
    FieldName,
)

if TYPE_CHECKING:
    from lark import Lark, Token

_WORD = re.compile(r"""[\w.+-]+|==|&&|\|\||'[^']{0,40}'?|"[^"]{0,40}"?|\S""")
"""What a message about a place in a text shows."""

_HINTS = {
    r"==": "write = for equal",
    r"&&?": "write and",
    r"\|\|?": "write or",
    r"!": "write not, or <> between two values",
    r"in|like|match": "compare with =, and join comparisons by or",
    r"[+-]?[0-9]*\.[0-9].*": "fields are compared with whole numbers",
    r"\..*": "fields of nested messages cannot be used",
    r"[+-]?[0-9]+": "numbers have at most 20 digits",
    r"[A-Z_0-9]+|\"[A-Z_0-9]+\"": "write names of values in single quotes: state = 'BUSY'",
}
"""What to write instead of words that programmers may expect to be allowed."""

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
    depth = condition.depth + 1
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
    from lark.exceptions import UnexpectedInput, UnexpectedToken

    if len(text) > MAX_LENGTH:
        raise GuardError(f"it has {len(text)} characters, more than {MAX_LENGTH}")
    try:
        return _parser().parse(text, start=start)
    except UnexpectedInput as error:
        is_condition = start == "condition"
        example = "success = false and level between 1 and 3" if is_condition else "Answer.success := true"
        hint = f"write it like {example}"
        found_at: Any = error.pos_in_stream  # declared as None
        position = int(found_at)
        is_end = isinstance(error, UnexpectedToken) and error.token.type == "$END"
        if is_end or not text[position:].strip():
            if is_condition and re.fullmatch(r"(not\s+)?[\w.]+", text.strip()):
                hint = f"write {text.strip():.40} = true"
            raise GuardError("it ends too early", hint=hint) from None
        if text[position - 1 : position + 1] == "==":
            position -= 1
        word = _WORD.match(text, position)
        found = word[0] if word else text[position]
        if is_condition:
            hint = next((said for each, said in _HINTS.items() if re.fullmatch(each, found)), hint)
        raise GuardError(
            f"column {position + 1} has {found!r:.40}, which is not allowed there", hint=hint
        ) from None


@cache
def _parser() -> Lark:
    starts = ["condition", "assignments"]
    return parser_of(Path(__file__).with_name("guard.lark"), start=starts, transformer=_GuardBuilder())


class _GuardBuilder:
    """Builds the tree while the text is parsed; its methods have the names of the grammar's rules."""

    def not_(self, children: list[Condition]) -> Condition:
        return Not(*children)

    def and_(self, children: list[Condition]) -> Condition:
        return And(tuple(children))

    def or_(self, children: list[Condition]) -> Condition:
        return Or(tuple(children))

    def plain(self, children: list[Token]) -> str:
        return str(children[0])

    def quoted(self, children: list[Token]) -> str:
        return unquoted(children[0])

    def field(self, children: list[str]) -> FieldName:
        return FieldName(children[0] if len(children) == 2 else None, children[-1])

    def number(self, children: list[Token]) -> Constant:
        return int(children[0], 16 if "x" in children[0].lower() else 10)

    def true(self, _: list[Token]) -> Constant:
        return True

    def false(self, _: list[Token]) -> Constant:
        return False

    def named(self, children: list[Token]) -> Constant:
        return str(children[0])[1:-1]

    def comparison(self, children: list[Any]) -> Condition:
        field, sign, value = children
        return Comparison(field, "<>" if sign == "!=" else str(sign), value)

    def turned(self, children: list[Any]) -> Condition:
        value, sign, field = children
        return self.comparison([field, TURNED.get(sign, sign), value])

    def between(self, children: list[Any]) -> Condition:
        field, low, high = children
        return And((Comparison(field, ">=", low), Comparison(field, "<=", high)))

    def not_between(self, children: list[Any]) -> Condition:
        return Not(self.between(children))

    def assignment(self, children: list[Any]) -> Assignment:
        return Assignment(*children)

    def assignments(self, children: list[Assignment]) -> tuple[Assignment, ...]:
        return tuple(children)
