"""The formula language of selt, read after its manual: what stand-ins understand, apart from how we write it.

Identifiers run as far as they can, prefixes bind tightest, infixes group to the right with the precedences of
the manual. A formula becomes one of our trees; `S`, `E` and `L` tell places, events and constants apart.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from dineros.analysis.logic.language.syntax import (
    And,
    Comparison,
    Constant,
    Deadlock,
    Equivalent,
    Finally,
    Fired,
    Formula,
    Globally,
    Implies,
    Name,
    Next,
    Not,
    Or,
    Release,
    Until,
)

SUB = "\0sub"
"""Stands for a place that is marked in states that were not explored further."""

_SYMBOLS = r"~`!@#$%^&*\-+=:?|/\\<>\[\];"
_TOKEN = re.compile(
    rf"\s+|(?P<next>\(\s*\))|(?P<paren>[()])|(?P<name>(?:[SEL]\.)?(?:\{{(?:[^{{}}\\]|\\.)*\}}|[A-Za-z0-9_']+))"
    rf"|(?P<symbol>[{_SYMBOLS}]+)",
    re.DOTALL,
)
_LEVELS: list[dict[str, type[Formula] | str]] = [
    {"U": Until, "V": Release},
    {"=>": Implies, "<=>": Equivalent},
    {"/\\": And, "\\/": Or},
    {"<=": "<=", ">=": ">=", "=": "==", "lt": "<", "gt": ">", "le": "<=", "ge": ">="},
    {"+": "+"},
    {"*": "*"},
]
_PREFIXES: dict[str, type[Formula]] = {"[]": Globally, "<>": Finally, "-": Not, "()": Next}


@dataclass
class Sum:
    """A number: factors of places, and a constant."""

    factors: dict[str, int]
    constant: int = 0


def read(text: str) -> Formula:
    """Read a formula, or fail."""
    tokens, position = [], 0
    while position < len(text):
        found = _TOKEN.match(text, position)
        assert found, f"cannot read {text[position : position + 20]!r}"
        position = found.end()
        if found["next"]:
            tokens.append("()")
        elif found[0].strip():
            tokens.append(found[0])
    reader = _Reader(tokens)
    tree = _formula(reader.level(0))
    assert not reader.tokens, f"left over: {reader.tokens}"
    return tree


class _Reader:
    def __init__(self, tokens: list[str]) -> None:
        self.tokens = tokens

    def level(self, number: int) -> Formula | Sum:
        if number == len(_LEVELS):
            return self.prefix()
        left = self.level(number + 1)
        if not self.tokens or self.tokens[0] not in _LEVELS[number]:
            return left
        meaning = _LEVELS[number][self.tokens.pop(0)]
        return _infix(meaning, left, self.level(number))

    def prefix(self) -> Formula | Sum:
        if self.tokens[0] in _PREFIXES:
            return _PREFIXES[self.tokens.pop(0)](_formula(self.prefix()))  # type: ignore[call-arg]
        token = self.tokens.pop(0)
        if token == "(":
            inner = self.level(0)
            assert self.tokens.pop(0) == ")"
            return inner
        return _identifier(token)


def _identifier(token: str) -> Formula | Sum:
    kind, name = (token[0], token[2:]) if token[1:2] == "." else ("", token)
    if name.startswith("{"):
        name = re.sub(r"\\(.)", r"\1", name[1:-1], flags=re.DOTALL)
    if kind == "S":
        return Sum({name: 1})
    if kind == "E":
        return Fired(Name(name))
    constants: dict[str, Formula | Sum] = {
        "T": Constant(True),
        "F": Constant(False),
        "dead": Deadlock(),
        "sub": Sum({SUB: 1}),
    }
    if name in constants:
        return constants[name]
    assert not kind and name.isdigit(), f"{token} is unknown"
    return Sum({}, int(name))


def _infix(meaning: type[Formula] | str, left: Formula | Sum, right: Formula | Sum) -> Formula | Sum:
    if meaning is And:
        return And((_formula(left), _formula(right)))
    if meaning is Or:
        return Or((_formula(left), _formula(right)))
    if isinstance(meaning, type):
        return meaning(_formula(left), _formula(right))  # type: ignore[call-arg]
    assert isinstance(left, Sum), f"{meaning} is ill-typed"
    assert isinstance(right, Sum), f"{meaning} is ill-typed"
    if meaning == "*":
        if right.factors:
            left, right = right, left
        assert not right.factors
        return Sum({p: k * right.constant for p, k in left.factors.items()}, left.constant * right.constant)
    sign = 1 if meaning == "+" else -1
    factors = dict(left.factors)
    for place, factor in right.factors.items():
        factors[place] = factors.get(place, 0) + sign * factor
    constant = left.constant + sign * right.constant
    if meaning == "+":
        return Sum(factors, constant)
    terms = tuple((k, Name(p)) for p, k in factors.items())
    return Comparison(terms, meaning, -constant)  # type: ignore[arg-type]


def _formula(part: Formula | Sum) -> Formula:
    """A number is true where it is not zero."""
    if isinstance(part, Sum):
        return Comparison(tuple((k, Name(p)) for p, k in part.factors.items()), ">=", 1 - part.constant)
    return part
