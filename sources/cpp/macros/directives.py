"""Directives of the preprocessor: definitions of macros, included headers and conditions."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

LITERAL = (
    r"//(?:[^\\\n]|\\\r?\n|\\.)*|/\*.*?(?:\*/|\Z)"
    r'|(?:u8|[uUL])?R"(?P<mark>[^\s()\\"]{0,16})\(.*?\)(?P=mark)"'
    r"|\"(?:[^\"\\\n]|\\.)*\"|'(?:[^'\\\n]|\\.)+'|\b\d(?:'?[\w.])*"
)
"""Comments, strings, characters and numbers: macros are not expanded in them."""
DIRECTIVE = r"^[ \t]*\#[ \t]*(?P<which>\w+)(?P<rest>(?:[^\\\n]|\\\r?\n|\\.)*)"
_PART = re.compile(f"(?P<literal>{LITERAL})|(?P<directive>{DIRECTIVE})", re.DOTALL | re.MULTILINE)
_DEFINED = re.compile(r"\s*(\w+)(?:\(([\w\s,.]*)\)|(?!\(|\w))(.*)", re.DOTALL)
_COMMENT = re.compile(f"(?P<literal>{LITERAL})", re.DOTALL)
_CONDITION = re.compile(r"[ \t]*#[ \t]*(if|ifdef|ifndef|elif|else|endif)\b(.*)")
_NEVER = re.compile(r"^[ \t]*#[ \t]*if[ \t]+(?:0|1|true|false)\b", re.MULTILINE)
_KNOWN = {"0": False, "false": False, "1": True, "true": True}
_GUARD = re.compile(r"_(?:H|HH|HPP|HXX)_*$|_$", re.IGNORECASE)


@dataclass(frozen=True)
class Macro:
    """A macro.

    Attributes
    ----------
    parameters : tuple of str or None
        None: it is used without arguments. The last one may be ``__VA_ARGS__``, or end with ``...``.
    line : int
        Where it is defined, from 1.
    branches : tuple of (int, int)
        The conditions around it, each with the number of the branch.
    is_one_of_several : bool
        Whether other branches of a condition define it differently.
    bodies : tuple of str
        What all of these branches define.
    """

    name: str
    parameters: tuple[str, ...] | None
    body: str
    path: str
    line: int
    branches: tuple[tuple[int, int], ...] = ()
    is_one_of_several: bool = False
    bodies: tuple[str, ...] = ()


@dataclass(frozen=True)
class Directive:
    """A directive: ``define`` with a macro, ``undef`` with a name, or ``include`` with a header."""

    start: int
    kind: str
    name: str
    macro: Macro | None = None
    is_later_kept: bool = False


def directives(path: str, text: str) -> Iterator[Directive]:
    """Yield the directives of a file that define macros, and the headers that it includes."""
    stack: list[tuple[int, int, bool]] = []
    conditions, line, at = 0, 1, 0
    for found in _PART.finditer(text):
        if found["directive"] is None:
            continue
        which, rest, start = found["which"], found["rest"], found.start()
        line, at = line + text.count("\n", at, start), start
        if which.startswith("if"):
            conditions += 1
            stack.append((conditions, 0, which == "ifdef"))
        elif which.startswith("el") and stack:
            number, branch, is_ifdef = stack[-1]
            stack[-1] = (number, branch + 1, is_ifdef)
        elif which == "endif" and stack:
            stack.pop()
        elif which == "include":
            yield Directive(start, which, rest.partition("//")[0].strip().strip('<>"'))
        elif which == "undef":
            yield Directive(start, which, rest.split()[0] if rest.split() else "")
        elif which == "define" and (parts := _DEFINED.match(rest)) is not None:
            names = None
            if parts[2] is not None:
                given = [each.strip() for each in parts[2].split(",")] if parts[2].strip() else []
                names = tuple("__VA_ARGS__" if each == "..." else each for each in given)
            joined = re.sub(r"\\\r?\n", " ", parts[3])
            body = " ".join(_COMMENT.sub(_without_comment, joined).split("\n")).strip()
            if names is not None or body or not _GUARD.search(parts[1]):
                branches = tuple((number, branch) for number, branch, _ in stack)
                macro = Macro(parts[1], names, body, path, line, branches)
                yield Directive(start, which, parts[1], macro, bool(stack) and stack[-1][2])


def without_dead(text: str) -> str:
    r"""Return a text whose branches that ``#if 0`` and ``#if 1`` exclude are blank; lines keep their numbers.

    Examples
    --------
    >>> without_dead("#if 0\nold\n#else\nnew\n#endif")
    '     \n   \n     \nnew\n      '
    """
    if _NEVER.search(text) is None:
        return text
    lines = text.split("\n")
    stack: list[tuple[bool | None, bool]] = []  # whether the branch is taken, and whether it is read
    for number, line in enumerate(lines):
        found = _CONDITION.match(line)
        is_read = all(each for _, each in stack)
        is_fixed = False
        if found is not None:
            which, asked = found[1], found[2].partition("//")[0].partition("/*")[0].strip()
            if which.startswith("if"):
                known = _KNOWN.get(asked) if which == "if" else None
                stack.append((known, known is not False))
                is_fixed = known is not None
            elif stack and which in ("else", "elif") and stack[-1][0] is not None:
                is_fixed = which == "else"
                if which == "elif" and stack[-1][0] is False:
                    return text  # a chain of conditions
                stack[-1] = (stack[-1][0], not stack[-1][0])
            elif stack and which == "endif":
                is_fixed = stack.pop()[0] is not None
        is_end = found is not None and not found[1].startswith("if") and all(each for _, each in stack)
        if is_fixed or not (is_read or is_end):
            lines[number] = " " * len(line)
    return "\n".join(lines)


def _without_comment(found: re.Match[str]) -> str:
    return " " if found[0].startswith(("//", "/*")) else found[0]
