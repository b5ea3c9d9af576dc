"""Directives of the preprocessor: definitions of macros, included headers and conditions."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Collection, Iterable, Iterator
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
_ROS_NAME = (
    r"\b(?P<name>(?:(?:BUILDING|BUILD|USE|IS|WITH|HAVE|ENABLE)_)?ROS(?:_?(?P<version>[12]))?"
    r"(?:_(?:FOUND|BUILD|ENABLED))?)\b"
)
_OF_ROS = re.compile(rf"(?P<not>!\s*)?(?:defined\s*)?(?:\(\s*)?{_ROS_NAME}\s*\)?")
_VERSION_NAME = r"_*ROS_VERSION_*"
_OF_VERSION = re.compile(
    rf"(?P<not>!\s*)?\(*\s*(?:(?:defined\s*\(?\s*)?{_VERSION_NAME}"
    rf"|{_VERSION_NAME}\s*(?P<sign>[=!<>]=|[<>])\s*(?P<number>\d))\s*\)*"
)
"""A question for the version of ROS, as the environment variable ``ROS_VERSION`` has it: 1 or 2."""
_NEVER = re.compile(
    r"^[ \t]*#[ \t]*(?:(?:el)?if[ \t]+(?:0|1|true|false)\b"
    rf"|(?:el)?if(?:n?def)?\b.*(?:{_ROS_NAME}|\b{_VERSION_NAME}\b))",
    re.MULTILINE,
)
_COMPARED: dict[str, Callable[[int, int], bool]] = {
    **{"==": operator.eq, "!=": operator.ne, "<": operator.lt},
    **{">": operator.gt, "<=": operator.le, ">=": operator.ge},
}
_NUMBER = re.compile(r"_?2")
_KNOWN = {"0": False, "false": False, "1": True, "true": True}
_GUARD = re.compile(r"_(?:H|HH|HPP|HXX)_*$|_$", re.IGNORECASE)


@dataclass(frozen=True)
class Macro:
    """A macro."""

    name: str
    parameters: tuple[str, ...] | None
    """None: it is used without arguments. The last one may be ``__VA_ARGS__``, or end with ``...``."""
    body: str
    path: str
    line: int
    """Where it is defined, from 1."""
    branches: tuple[tuple[int, int], ...] = ()
    """The conditions around it, each with the number of the branch."""
    is_one_of_several: bool = False
    """Whether other branches of a condition define it differently."""
    bodies: tuple[str, ...] = ()
    """What all of these branches define."""


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
    r"""Return a text in which the branches that are never compiled are blank; lines keep their numbers.

    Conditions of known value are ``0`` and ``1``, and macros that choose between ROS 1 and ROS 2, also with
    ``&&`` and ``||``: by their names, or by a version.

    Examples
    --------
    >>> without_dead("#if 0\nold\n#else\nnew\n#endif")
    '     \n   \n     \nnew\n      '
    >>> without_dead("#if __ROS_VERSION > 1\nnew\n#else\nold\n#endif")
    '                     \nnew\n     \n   \n      '
    >>> without_dead("#ifdef ROS1\nold\n#elif defined(ROS2)\nnew\n#endif")
    '           \n   \n                   \nnew\n      '
    """
    if _NEVER.search(text) is None:
        return text
    lines = text.split("\n")
    first = _of_ros_1(lines)
    stack: list[_Chain] = []
    for number, line in enumerate(lines):
        found = _CONDITION.match(line)
        is_read = all(each.is_read for each in stack)
        if found is None:
            lines[number] = line if is_read else " " * len(line)
            continue
        which = found[1]
        if which.startswith("if"):
            stack.append(_Chain())
        chain = stack[-1] if stack else _Chain()
        is_kept = all(each.is_read for each in stack[:-1]) and chain.enters(which, found[2], first)
        lines[number] = line if is_kept else " " * len(line)
        if is_kept and which == "elif" and chain.is_first:
            lines[number] = line.replace("elif", "if  ", 1)
        if which == "endif" and stack:
            stack.pop()
    return "\n".join(lines)


@dataclass(eq=False)
class _Chain:
    """A chain of conditions, from ``#if`` to ``#endif``."""

    is_over: bool = False
    """Whether an earlier branch is certainly compiled."""
    is_read: bool = True
    """Whether the current branch may be compiled."""
    opened: int = 0
    """How many conditions of unknown value there are so far: their directives are kept."""

    @property
    def is_first(self) -> bool:
        """Whether the current condition is the first one that is kept."""
        return self.opened == 1

    def enters(self, which: str, asked: str, first: Collection[str]) -> bool:
        """Go on to a directive; return whether it is kept."""
        if which == "endif":
            return self.opened > 0
        if self.is_over:
            self.is_read = False
            return False
        known = True if which == "else" else _value(which, asked, first)
        if known is not None and self.opened == 0:  # the whole chain so far has known values
            self.is_read = self.is_over = known
            return False
        if known is False and which == "elif":
            self.is_read = False
            return False
        self.is_read = True
        self.opened += which != "else"
        return True


def _of_ros_1(lines: Iterable[str]) -> set[str]:
    """Return the macros without a version that mean ROS 1: ``ROS_FOUND`` next to ``ROS2_FOUND``.

    If conditions of the latter are inside of those of the former, the former means any version.
    """
    plain, around, second, stack = set[str](), set[str](), set[str](), list[set[str]]()
    for found in filter(None, map(_CONDITION.match, lines)):
        which = found[1]
        if which == "endif":
            del stack[-1:]
            continue
        names = set[str]()
        for each in _OF_ROS.finditer(found[2]) if which != "else" else ():
            if each["version"] == "2":
                second.add(_NUMBER.sub("", each["name"]))
                outer = stack if which.startswith("if") else stack[:-1]
                around.update(*outer)
            elif not each["version"]:
                names.add(each["name"])
        plain |= names
        if which.startswith("if"):
            stack.append(names)
        elif stack:
            stack[-1] = names
    return (plain & second) - around


def _value(which: str, asked: str, first: Collection[str]) -> bool | None:
    """Return the value of a condition; None: it is not known."""
    asked = asked.partition("//")[0].partition("/*")[0].strip()
    is_name = which in ("ifdef", "ifndef")
    if is_name and "defined" in asked:
        return None
    found = _any(_all(_atom(part.strip(), first) for part in each.split("&&")) for each in asked.split("||"))
    return not found if which == "ifndef" and found is not None else found


def _any(values: Iterable[bool | None]) -> bool | None:
    found = set(values)
    return True if True in found else None if None in found else False


def _all(values: Iterable[bool | None]) -> bool | None:
    found = set(values)
    return False if False in found else None if None in found else True


def _atom(asked: str, first: Collection[str]) -> bool | None:
    """Return the value of a condition without operators other than ``!``."""
    if asked in _KNOWN:
        return _KNOWN[asked]
    version = _OF_VERSION.fullmatch(asked)
    if version is not None and asked.count("(") == asked.count(")"):
        sign = version["sign"]
        return (sign is None or _COMPARED[sign](2, int(version["number"]))) != bool(version["not"])
    found = _OF_ROS.fullmatch(asked)
    if found is None or asked.count("(") != asked.count(")"):
        return None
    if not found["version"] and found["name"] not in first:
        return None
    return (found["version"] == "2") != bool(found["not"])


def _without_comment(found: re.Match[str]) -> str:
    return " " if found[0].startswith(("//", "/*")) else found[0]
