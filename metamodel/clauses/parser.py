"""From the text of a clause to an expression (grammar: ``clause.lark``), with bounds and error positions."""

from __future__ import annotations

from functools import cache, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.metamodel.clauses.expressions import (
    WORDS,
    And,
    Constant,
    Equivalent,
    Expression,
    Implies,
    Not,
    Or,
    Signal,
    SignalIs,
    signals_of,
    unquoted,
)
from dineros.metamodel.errors import ClauseError
from dineros.metamodel.grammars import parser_of

if TYPE_CHECKING:
    from lark import Lark, Token
    from lark.exceptions import UnexpectedInput

MAX_LENGTH = 65_536
"""Longest text of a clause, in characters."""

MAX_DEPTH = 100
"""Deepest nesting of operators."""


@lru_cache(maxsize=1024)
def parse(text: str) -> Expression:
    """Read a boolean expression over signals, such as ``Door & Mode <> 'idle'``.

    Operators, the weakest first: ``<->``, ``->``, ``|`` (``||``, ``∨``, ``or``), ``&`` (``&&``,
    ``∧``, ``and``), ``!`` (``¬``, ``not``). Names that are not plain words are in double quotes, values of
    signals, compared by ``=`` and ``<>``, in single ones.

    Raises
    ------
    ClauseError
        The text is not such an expression (`column` tells where), or it is longer than `MAX_LENGTH` or nested
        deeper than `MAX_DEPTH`.
    """
    if len(text) > MAX_LENGTH:
        raise ClauseError(
            f"the clause has {len(text)} characters, more than {MAX_LENGTH}",
            column=MAX_LENGTH + 1,
            hint="split it over several transitions",
        )
    from lark.exceptions import UnexpectedInput

    try:
        expression: Expression = _parser().parse(text)  # type: ignore[assignment]
    except UnexpectedInput as error:
        raise _syntax_error(text, error) from None
    if expression.depth > MAX_DEPTH:
        raise ClauseError(
            f"the clause nests {expression.depth} operators, more than {MAX_DEPTH}",
            column=1,
            hint="write it with less nesting, such as a & b & c",
        )
    return expression


def signal_names(text: str) -> list[str]:
    """Return the names of the signals of a clause, each once, in order of first use.

    Raises
    ------
    ClauseError
        As for `parse`.
    """
    return list(dict.fromkeys(signals_of(parse(text))))


def column_of(text: str, name: str) -> int | None:
    """Return where the text of a clause first names a signal, from 1.

    Examples
    --------
    >>> column_of('ab & !"a"', "a")
    7
    """
    return next((found.start() + 1 for found in WORDS.finditer(text) if unquoted(found[0]) == name), None)


@cache
def _parser() -> Lark:
    return parser_of(Path(__file__).with_name("clause.lark"), transformer=_ClauseBuilder())


class ConnectiveBuilder:
    """Builds connectives while a text is parsed: bottom-up, so that no nesting can exhaust the stack.

    Methods of builders are called as the rules of their grammars are.
    """

    def not_(self, children: list[Expression]) -> Expression:  # noqa: D102
        return Not(*children)

    def and_(self, children: list[Expression]) -> Expression:  # noqa: D102
        return And(tuple(children))

    def or_(self, children: list[Expression]) -> Expression:  # noqa: D102
        return Or(tuple(children))


class _ClauseBuilder(ConnectiveBuilder):
    """Builds the tree of a clause."""

    def signal(self, children: list[Token]) -> Expression:
        return Signal(str(children[0]))

    def quoted(self, children: list[Token]) -> Expression:
        return Signal(unquoted(children[0]))

    def is_(self, children: list[Token]) -> Expression:
        return SignalIs(str(unquoted(children[0])), str(children[1])[1:-1])

    def is_not(self, children: list[Token]) -> Expression:
        return Not(self.is_(children))

    def true(self, _: list[Expression]) -> Expression:
        return Constant(True)

    def false(self, _: list[Expression]) -> Expression:
        return Constant(False)

    def implies(self, children: list[Expression]) -> Expression:
        return Implies(*children)

    def equivalent(self, children: list[Expression]) -> Expression:
        return Equivalent(*children)


def _syntax_error(text: str, error: UnexpectedInput) -> ClauseError:
    """Say in one line where the text stops being an expression and what could follow there."""
    from lark.exceptions import UnexpectedCharacters, UnexpectedToken

    line, column, found, expected, hint = error.line, error.column, "", set[str](), None
    if isinstance(error, UnexpectedToken):
        found, expected = str(error.token), set(error.accepts or error.expected)
    elif isinstance(error, UnexpectedCharacters):
        found, expected = error.char, set(error.allowed or ()) - {"RPAR"}  # allowed there, open or not
    if not found:
        line, column = text.count("\n") + 1, len(text) - text.rfind("\n")
    if "NAME" in expected:
        wanted = "a signal, '!' or '('"
        if found == '"':
            hint = "the quote that opens here is not closed"
    elif expected == {"VALUE"}:
        wanted = "a value in single quotes"
    else:
        ends = {"RPAR": " or ')'", "$END": " or the end"}
        wanted = "an operator" + "".join(shown for terminal, shown in ends.items() if terminal in expected)
        if found and (found[0].isalnum() or found[0] in '"._-'):
            hint = "put a name with blanks or special characters into double quotes"
    where = f"line {line}, column {column}" if "\n" in text else f"column {column}"
    shown = repr(found) if found else "the end"
    return ClauseError(f"{where}: expected {wanted}, found {shown}", column=column, hint=hint)
