"""Texts that functions make of a format: ``format("%s/odom", name)``, ``fmt::format("{}/odom", name)``."""

from __future__ import annotations

import re

from dineros.sources.cpp.following.calls import Call
from dineros.sources.cpp.following.statements import Statements
from dineros.sources.cpp.operations import binary
from dineros.sources.cpp.values import Const, Open, Value, constant, part

_PRINTF = re.compile(r"%(?:(%)|[-+ #0]*\d*(?:\.\d+)?(?:hh|h|ll|l|z|j|t)?([diuscxXfFgGeEop]))")
_PADDED = re.compile(r"%0\d[diu]")
"""A number with zeros before it."""
_BRACES = re.compile(r"\{\{|\}\}|\{(?::[^{}]*)?\}")
_WRITES = {"snprintf": 2, "sprintf": 1}
"""Functions that write a text to a buffer, with the position of the format."""
_PLAIN = {"d", "i", "u", "s"}
"""Conversions that give the usual text of a value."""


def formatted(machine: Statements, call: Call) -> Value | None:
    """Return the text of a call of ``format``, ``uFormat`` or ``StrFormat``; None: another call.

    The first argument is the format; the others must be as many as it takes. Functions such as ``snprintf``
    write the text to a buffer.
    """
    if call.on is None and call.last in _WRITES and len(call.args) > (at := _WRITES[call.last]):
        written = constant(call.args[at])
        count = len([each for each in _PRINTF.finditer(str(written)) if not each[1]])
        is_known = isinstance(written, str) and count == len(call.args) - at - 1
        text = _filled(str(written), _PRINTF, call.args[at + 1 :]) if is_known else Open("a text")
        machine.assign(call.nodes[0], text, call.frame)
        return Open("the length of a text")
    given = constant(call.args[0]) if call.args else None
    if call.on is not None or not call.last.lower().endswith("format") or not isinstance(given, str):
        return None
    rest = call.args[1:]
    conversions = [each for each in _PRINTF.finditer(given) if not each[1]]
    if conversions and len(conversions) == len(rest):
        return _filled(given, _PRINTF, rest)
    if len([each for each in _BRACES.findall(given) if each not in ("{{", "}}")]) == len(rest) > 0:
        return _filled(given, _BRACES, rest)
    return None


def of_text(text: str, call: Call) -> Value | None:
    """Return the result of a method of a known text; None: another method, or unknown arguments."""
    given = [constant(each) for each in call.args]
    if call.last in ("size", "length") and not given:
        return Const(len(text))
    if call.last == "empty" and not given:
        return Const(not text)
    if call.last == "substr" and given and all(type(each) is int and each >= 0 for each in given[:2]):
        return Const(text[given[0] :][: given[1] if len(given) > 1 else None])
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
    if conversion.re is _PRINTF and isinstance(value, Const) and _PADDED.fullmatch(conversion[0]):
        number = value.value
        if type(number) is int and number >= 0:
            return Const(str(number).zfill(int(conversion[0][2:].rstrip("diu"))))
    is_plain = conversion[0] == "{}" or (
        conversion.re is _PRINTF and len(conversion[0]) == 2 and conversion[2] in _PLAIN
    )
    if not is_plain:
        return Open("a text", "{" + conversion[0].strip("{}") + "}")
    if isinstance(value, Const):
        is_exact = isinstance(value.value, (str, int)) and not isinstance(value.value, bool)
        return Const(str(value.value)) if is_exact else Open("a text", part(value))
    return Open("a text", part(value))
