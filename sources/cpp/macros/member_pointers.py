"""Rewrites types of pointers to methods, and calls through them, which the grammar of C++ does not know."""

from __future__ import annotations

import re

from dineros.sources.cpp.macros.directives import LITERAL

_TOKEN = re.compile(rf"(?P<literal>{LITERAL})|(?P<sign>->\*|(?<=[\w)\]])\.\*(?=[\w(:]))", re.DOTALL)
_TYPE = re.compile(
    rf"(?P<literal>{LITERAL})|"
    r"\b[\w:]+(?:<(?:[^<>(){};]|<[^<>(){};]*>)*>)?[\s*&]*"
    r"\(\s*[\w:]+(?:<[^<>();]*>)?::\*\s*(?:const\b\s*)?(?P<name>\w*(?:\s*\[\w*\])*)\s*\)\s*"
    r"\((?:[^();]|\([^();]*\))*\)(?:\s*(?:const|noexcept)\b)*",
    re.DOTALL,
)
"""The type of a pointer to a method, with the name of what has it."""
_BRACKETS = {"(": 1, "[": 1, "{": 1, ")": -1, "]": -1, "}": -1}
_MOST_CALLS = 500
"""Limit of the calls that are rewritten in a file."""
_MOST_CHARACTERS = 2000
"""Limit of the characters of the object, and of the pointer."""


def with_bound_members(text: str) -> str:
    r"""Return a text in which ``std::bind_front`` binds pointers to members that are called.

    Their types become ``std::function``. Lines keep their numbers.

    Examples
    --------
    >>> with_bound_members("(this->*step_)(3);")
    'std::bind_front(step_, this)(3);'
    >>> with_bound_members("(robot.*(steps.at(1)))();")
    'std::bind_front((steps.at(1)), robot)();'
    >>> with_bound_members("this->*number = 3; // (a->*b)()")
    'this->*number = 3; // (a->*b)()'
    >>> with_bound_members("int (Robot::*step_)(int) const = &Robot::step;")
    'std::function step_ = &Robot::step;'
    """
    if "::*" in text:
        text = _TYPE.sub(_as_function, text)
    if "->*" not in text and ".*" not in text:
        return text
    for _ in range(_MOST_CALLS):
        for found in reversed([each for each in _TOKEN.finditer(text) if each["sign"] is not None]):
            parts = _call(text, found.start(), found.end())
            if parts is not None:
                start, end, (holder, pointer) = parts
                lines = "\n" * holder.count("\n")  # the pointer stands on its line
                holder = " ".join(holder.split("\n"))
                text = f"{text[:start]}{lines}std::bind_front({pointer}, {holder}){text[end:]}"
                break
        else:
            break
    return text


def _as_function(found: re.Match[str]) -> str:
    if found["literal"] is not None:
        return found[0]
    return f"std::function {found['name']}".rstrip() + "\n" * found[0].count("\n")


def _call(text: str, start: int, end: int) -> tuple[int, int, tuple[str, str]] | None:
    """Return where a call begins, where its arguments do, the object and the pointer; None: no call."""
    first, last = _bracket(text, start - 1, -1), _bracket(text, end, 1)
    if first is None or last is None or text[first] != "(" or text[last] != ")":
        return None
    if text[last + 1 :].lstrip()[:1] != "(":
        return None
    return first, last + 1, (text[first + 1 : start].strip(), text[end:last].strip())


def _bracket(text: str, at: int, step: int) -> int | None:
    """Return the bracket around a position, searched in one direction; None: it is too far away."""
    level = 0
    for place in range(at, at + step * _MOST_CHARACTERS, step):
        if not 0 <= place < len(text) or text[place] == ";":
            return None
        level += _BRACKETS.get(text[place], 0) * step
        if level < 0:
            return place
    return None
