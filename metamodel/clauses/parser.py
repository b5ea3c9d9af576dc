"""From the text of a clause to an expression, with bounds and error positions.

The weakest operator comes first; ``->`` groups to the right, ``<->`` to the left, and a chain of ``&`` or
``|`` is one operation. It is read with a stack (Dijkstra's shunting yard), so that no nesting exhausts that
of Python::

    equivalence: implication ("<->" implication)*
    implication: disjunction ["->" implication]
    disjunction: conjunction ("|" conjunction)*
    conjunction: negation ("&" negation)*
    negation:    "!" negation | atom
    atom:        name | name "=" value | name "<>" value | "true" | "false" | "(" equivalence ")"
"""

from __future__ import annotations

import re
from functools import lru_cache
from typing import NamedTuple

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

MAX_LENGTH = 65_536
"""Longest text of a clause, in characters."""

MAX_DEPTH = 100
"""Deepest nesting of operators."""

# A name ends in a letter, a digit or an underscore, so that `a->b` is an implication.
_NAME = r"\w+(?:[.-]+\w+)*"
_QUOTED = r'"(?:[^"\\]|\\["\\])*"'
_VALUE = r"'[^']+'"
_OPERATOR = r"<->|and|->|\|\||&&|or|[|&∨∧→↔]"
_OPERAND = re.compile(rf"(?P<name>{_NAME}|{_QUOTED})|[(!¬]")
_AFTER_OPERAND = re.compile(rf"(?P<operator>{_OPERATOR})|\)")
_COMPARISON = re.compile(r"\s*(=|<>)\s*")
_VALUES = re.compile(_VALUE)
_ANY = re.compile(rf"{_NAME}|{_QUOTED}|{_VALUE}|{_OPERATOR}|<>|[=()!¬]")
_BLANKS = re.compile(r"\s*")

_NOT, _OPEN = "!", "("
_NAMES = {
    **dict.fromkeys(("<->", "↔"), "<->"),
    **dict.fromkeys(("->", "→"), "->"),
    **dict.fromkeys(("|", "||", "∨", "or"), "|"),
    **dict.fromkeys(("&", "&&", "∧", "and"), "&"),
}
_BINDING = {_OPEN: 0, "<->": 1, "->": 2, "|": 3, "&": 4, _NOT: 5}


@lru_cache(maxsize=1024)
def parse(text: str) -> Expression:
    """Read a boolean expression over signals, such as ``Door & Mode <> 'idle'``.

    Operators, the weakest first: ``<->``, ``->``, ``|`` (``||``, ``∨``, ``or``), ``&`` (``&&``,
    ``∧``, ``and``), ``!`` (``¬``, ``not``). Names that are not plain words are in double quotes, values of
    signals, compared by ``=`` and ``<>``, in single ones.

    Raises
    ------
    ClauseError
        The text is not such an expression (`column` is its position), or it is longer than `MAX_LENGTH` or
        nested deeper than `MAX_DEPTH`.
    """
    if len(text) > MAX_LENGTH:
        raise ClauseError(
            f"the clause has {len(text)} characters, more than {MAX_LENGTH}",
            column=MAX_LENGTH + 1,
            hint="split it over several transitions",
        )
    expression = _Reading(text).expression()
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


class _Pending(NamedTuple):
    """An operator whose last operand is not complete, or an open parenthesis."""

    operator: str
    operands: list[Expression]


class _Reading:
    """The reading of a clause: the text up to `at` is in `pending`."""

    def __init__(self, text: str) -> None:
        self.text, self.at = text, 0
        self.pending: list[_Pending] = []

    def expression(self) -> Expression:
        """Return the whole expression."""
        while True:
            operand = self._operand()
            while True:
                self._skip_blanks()
                found = _AFTER_OPERAND.match(self.text, self.at)
                if found is None:
                    return self._whole(operand)
                if found["operator"] is not None:
                    break
                operand = self._closed(operand)
            self.at = found.end()
            self._operator(_NAMES[found[0]], operand)

    def _operand(self) -> Expression:
        """Read an atom, after any number of negations and parentheses."""
        while True:
            self._skip_blanks()
            found = _OPERAND.match(self.text, self.at)
            if found is None:
                raise self._error("a signal, '!' or '('")
            self.at = found.end()
            if found["name"] is not None and found[0] != "not":
                return self._atom(found[0])
            self.pending.append(_Pending(_OPEN if found[0] == _OPEN else _NOT, []))

    def _atom(self, word: str) -> Expression:
        if word in ("true", "false"):
            return Constant(word == "true")
        comparison = _COMPARISON.match(self.text, self.at)
        if comparison is None:
            return Signal(unquoted(word))
        self.at = comparison.end()
        value = _VALUES.match(self.text, self.at)
        if value is None:
            raise self._error("a value in single quotes")
        self.at = value.end()
        is_equal = SignalIs(unquoted(word), value[0][1:-1])
        return is_equal if comparison[1] == "=" else Not(is_equal)

    def _operator(self, operator: str, operand: Expression) -> None:
        """Take an operator, after its left operand; a `->` before a `->` stays open."""
        operand = self._reduced(operand, _BINDING[operator])
        last = self.pending[-1] if self.pending else None
        if last is not None and last.operator == operator and operator in "&|":
            last.operands.append(operand)
            return
        if last is not None and last.operator == operator == "<->":
            operand = _applied(self.pending.pop(), operand)
        self.pending.append(_Pending(operator, [operand]))

    def _reduced(self, operand: Expression, binding: int) -> Expression:
        """Complete the operators that bind more strongly, of which this is the last operand."""
        while self.pending and _BINDING[self.pending[-1].operator] > binding:
            operand = _applied(self.pending.pop(), operand)
        return operand

    def _closed(self, operand: Expression) -> Expression:
        """Take a closing parenthesis."""
        operand = self._reduced(operand, _BINDING[_OPEN])
        if not self.pending:
            raise self._error("an operator")
        self.pending.pop()
        self.at += 1
        return operand

    def _whole(self, operand: Expression) -> Expression:
        """Return the expression that ends here."""
        operand = self._reduced(operand, _BINDING[_OPEN])
        if self.at < len(self.text) or self.pending:
            raise self._error("an operator")
        return operand

    def _skip_blanks(self) -> None:
        blanks = _BLANKS.match(self.text, self.at)
        assert blanks is not None
        self.at = blanks.end()

    def _error(self, wanted: str) -> ClauseError:
        """Return in one line where the text stops being an expression and what could follow there."""
        hint = None
        word = _ANY.match(self.text, self.at)
        found = word[0] if word is not None else self.text[self.at : self.at + 1]
        if wanted.startswith("a signal"):
            if found == '"':
                hint = "the quote that opens here is not closed"
        elif wanted == "an operator":
            if word is not None or not found:
                wanted += " or ')'" if self.pending else " or the end"
            if found and (found[0].isalnum() or found[0] in '"._-'):
                hint = "put a name with blanks or special characters into double quotes"
        at = self.at if found else len(self.text)
        line, column = self.text.count("\n", 0, at) + 1, at - self.text.rfind("\n", 0, at)
        where = f"line {line}, column {column}" if "\n" in self.text else f"column {column}"
        shown = repr(found) if found else "the end"
        return ClauseError(f"{where}: expected {wanted}, found {shown}", column=column, hint=hint)


def _applied(pending: _Pending, last: Expression) -> Expression:
    """Return the operation with its last operand."""
    match pending.operator:
        case "!":
            return Not(last)
        case "&":
            return And((*pending.operands, last))
        case "|":
            return Or((*pending.operands, last))
        case "->":
            return Implies(pending.operands[0], last)
        case _:
            return Equivalent(pending.operands[0], last)
