"""Texts that functions make of a format: ``format("%s/odom", name)``, ``fmt::format("{}/odom", name)``."""

from __future__ import annotations

import re

from dineros.sources.cpp.following.calls import Call
from dineros.sources.cpp.operations import binary
from dineros.sources.cpp.values import Const, Open, Value, constant, part

_PRINTF = re.compile(r"%(?:(%)|[-+ #0]*\d*(?:\.\d+)?(?:hh|h|ll|l|z|j|t)?([diuscxXfFgGeEop]))")
_BRACES = re.compile(r"\{\{|\}\}|\{(?::[^{}]*)?\}")
_PLAIN = {"d", "i", "u", "s"}
"""Conversions that give the usual text of a value."""


def formatted(call: Call) -> Value | None:
    """Return the text of a call of a function called ``format``; None: another call.

    The first argument is the format; the others must be as many as it takes.
    """
    given = constant(call.args[0]) if call.args else None
    if call.on is not None or call.last != "format" or not isinstance(given, str):
        return None
    rest = call.args[1:]
    conversions = [each for each in _PRINTF.finditer(given) if not each[1]]
    if conversions and len(conversions) == len(rest):
        return _filled(given, _PRINTF, rest)
    if len([each for each in _BRACES.findall(given) if each not in ("{{", "}}")]) == len(rest) > 0:
        return _filled(given, _BRACES, rest)
    return None


def _filled(text: str, pattern: re.Pattern[str], args: list[Value]) -> Value:
    found: Value = Const("")
    at, left = 0, list(args)
    for each in pattern.finditer(text):
        found = binary("+", found, Const(text[at : each.start()]))
        at = each.end()
        if each[0] in ("%%", "{{", "}}"):
            found = binary("+", found, Const(each[0][0]))
            continue
        found = binary("+", found, _shown(each, left.pop(0)))
    return binary("+", found, Const(text[at:]))


def _shown(conversion: re.Match[str], value: Value) -> Value:
    """Return what a conversion makes of a value; a width, or a number with decimals, is not followed."""
    is_plain = conversion[0] == "{}" or (
        conversion.re is _PRINTF and len(conversion[0]) == 2 and conversion[2] in _PLAIN
    )
    if not is_plain:
        return Open("a text", "{" + conversion[0].strip("{}") + "}")
    if isinstance(value, Const):
        is_exact = isinstance(value.value, (str, int)) and not isinstance(value.value, bool)
        return Const(str(value.value)) if is_exact else Open("a text", part(value))
    return Open("a text", part(value))
