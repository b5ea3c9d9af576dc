"""Literals and operators of C++ on constants, durations and texts."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from dineros.sources.cpp.parsing import text_of
from dineros.sources.cpp.values import MOST_VALUES, Const, Either, Open, Seconds, Value, one_of, options, part

if TYPE_CHECKING:
    from tree_sitter import Node

_ESCAPES = {"n": "\n", "t": "\t", '"': '"', "\\": "\\", "'": "'", "0": "\0"}


def number(text: str) -> Value:
    """Return the value of a literal."""
    plain = text.replace("'", "")
    try:
        if re.fullmatch(r"0[xX][0-9a-fA-F]{1,32}[uUlL]*", plain):
            return Const(int(plain.rstrip("uUlL"), 16))
        if re.fullmatch(r"[0-9]{1,40}[uUlL]*", plain):
            return Const(int(plain.rstrip("uUlL")))
        if math.isfinite(found := float(plain.rstrip("fFlL"))):
            return Const(found)
    except ValueError:
        pass
    return Open(text[:60])


def text_literal(node: Node) -> str:
    """Return the text of a literal, without quotes."""
    found = ""
    for each in node.named_children:
        if each.type == "escape_sequence":
            found += _ESCAPES.get(text_of(each)[1:], "?")
        elif each.type in ("string_content", "raw_string_content"):
            found += text_of(each)
    return found


_NUMBERS: dict[str, Callable[[Any, Any], Any]] = {
    **{"-": operator.sub, "*": operator.mul, "+": operator.add},
    **{"<": operator.lt, ">": operator.gt, "<=": operator.le, ">=": operator.ge},
}


def binary(sign: str, left: Value, right: Value) -> Value:
    """Return the result of an operator for two values."""
    if isinstance(left, Either) and not isinstance(right, Either):
        return _one_of([binary(sign, each, right) for each in left.options])
    if isinstance(right, Either) and not isinstance(left, Either):
        return _one_of([binary(sign, left, each) for each in right.options])
    if isinstance(left, Const) and isinstance(right, Const):
        return _constants(sign, left.value, right.value)
    if sign == "+" and (_is_text(left) or _is_text(right)):
        return Open("a text", part(left) + part(right))
    if isinstance(left, Seconds) or isinstance(right, Seconds):
        return _durations(sign, left, right)
    return Open(f"{_words(left)} {sign} {_words(right)}"[:60])


def _one_of(values: list[Value]) -> Value:
    found = one_of(values)
    return found if len(options(found)) <= MOST_VALUES else Open("many values")


def _is_text(value: Value) -> bool:
    return (isinstance(value, Const) and isinstance(value.value, str)) or (
        isinstance(value, Open) and bool(value.parts)
    )


def _words(value: Value) -> str:
    return value.text if isinstance(value, Open) else str(getattr(value, "value", "value"))


def _constants(sign: str, left: Any, right: Any) -> Value:
    if sign in ("==", "!="):
        return Const((left == right) == (sign == "=="))
    if isinstance(left, str) and isinstance(right, str) and sign == "+":
        return Const((left + right)[:10_000])
    if not isinstance(left, (int, float)) or not isinstance(right, (int, float)):
        return Open(f"{left} {sign} {right}"[:60])
    if max(abs(left), abs(right)) > 1e18:
        return Open("a large number")
    if sign in _NUMBERS:
        return Const(_NUMBERS[sign](left, right))
    if sign in ("/", "%") and right:
        if isinstance(left, int) and isinstance(right, int):
            whole = abs(left) // abs(right) * (1 if (left < 0) == (right < 0) else -1)
            return Const(whole if sign == "/" else left - whole * right)
        return Const(left / right) if sign == "/" else Open("%")
    return Open(f"{left} {sign} {right}"[:60])


def _durations(sign: str, left: Value, right: Value) -> Value:
    a = left.value if isinstance(left, (Seconds, Const)) else None
    b = right.value if isinstance(right, (Seconds, Const)) else None
    if not isinstance(a, (int, float)) or not isinstance(b, (int, float)):
        return Open("a duration")
    if sign in ("<", ">", "<=", ">="):
        return Const(bool(_NUMBERS[sign](a, b)))
    if sign in ("+", "-") and isinstance(left, Seconds) and isinstance(right, Seconds):
        return Seconds(a + b if sign == "+" else a - b)
    if sign == "*":
        return Seconds(a * b)
    if sign == "/" and b:
        return Const(a / b) if isinstance(right, Seconds) else Seconds(a / b)
    return Open("a duration")
