"""Filters: how a value is written at each kind of place in a generated file.

A value of a model is data: a name may hold quotes, line feeds or the end of a comment. So each kind of place
has its filter, whose result is `Written`, and `require_written` refuses to write anything else: a template
cannot forget. A text that is cut, joined or changed in a template is plain again. Only a `Name` needs no
filter, since it is letters, digits and underscores, which no format takes for anything else.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable

import jinja2
import jinja2.sandbox

from dineros.metamodel.errors import with_article

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(?:\.[A-Za-z_][A-Za-z0-9_]*)*")
# Characters that XML 1.0 has no place for (Sect. 2.2, Char).
_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_XML = str.maketrans(
    {
        "&": "&amp;",
        "<": "&lt;",
        ">": "&gt;",
        '"': "&quot;",
        "'": "&apos;",
        "\t": "&#9;",
        "\n": "&#10;",
        "\r": "&#13;",
    }
)
_PLAIN_YAML = re.compile(r"[A-Za-z_/][A-Za-z0-9_/]*")
# What YAML 1.1 takes for something else than a text (types bool and null of the tag repository).
_YAML_WORDS = frozenset({"y", "n", "yes", "no", "on", "off", "true", "false", "null"})
_MARKDOWN = re.compile(r"[\\`*\[\]|~]|(?<![^\W_])_|_(?![^\W_])")


class UnfilteredError(TypeError):
    """A template writes a value that went through no filter."""


class Written(str):
    """What a filter, or a template itself, made of values: it is put into a file as it is."""

    __slots__ = ()


class Name(Written):
    """A name that can stand anywhere in a generated file: identifiers in ASCII, joined by dots if need be.

    Raises
    ------
    ValueError
        The text is no such name.
    """

    __slots__ = ()

    def __new__(cls, text: str) -> Name:
        """Make a name."""
        if not _NAME.fullmatch(text):
            raise ValueError(f"{text!r} is not a name")
        return super().__new__(cls, text)


class Environment(jinja2.sandbox.ImmutableSandboxedEnvironment):
    """Templates that write only what went through a filter, or needs none, and see only what they are given.

    A template is a program, and a user's may come from anybody. What a macro or a block makes consists of
    parts that were written, and so is written itself.
    """

    @staticmethod
    def concat(parts: Iterable[str]) -> Written:
        """Join what was written; Jinja does so for macros and blocks, too (cf. NativeEnvironment)."""
        return Written("".join(parts))


def require_written(value: object) -> object:
    """Return what a template writes.

    Raises
    ------
    UnfilteredError
        It went through no filter, but should.
    """
    if isinstance(
        value, (Written, int, jinja2.Undefined)
    ):  # what is undefined says so itself when it is written
        return value
    raise UnfilteredError(f"{value!r} goes through no filter")


def python(value: object) -> Written:
    """Write a value as a Python literal, texts in double quotes as formatters want them."""
    return Written(_python(value))


def _python(value: object) -> str:
    if isinstance(value, str):
        return f'"{_inside_quotes(value)}"'
    if isinstance(value, (list, tuple)):
        inner = ", ".join(_python(element) for element in value)
        return f"[{inner}]" if isinstance(value, list) else f"({inner}{',' if len(value) == 1 else ''})"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_python(key)}: {_python(each)}" for key, each in value.items()) + "}"
    if value is None or isinstance(value, (bool, int, float)):
        return repr(value)
    raise _refused(value)


def docstring(value: object) -> Written:
    """Write a text inside of double quotes, one or three, of a Python file, which reads it unchanged."""
    return Written(_inside_quotes(_text(value)))


def comment(value: object) -> Written:
    r"""Write a text in a comment to the end of the line, in Python, YAML, CMake or a ROS interface.

    What cannot be seen is spelled, such as ``<U+000A>``. So is the backslash, and ``*/`` gets a blank:
    comments of ROS interfaces become comments of C. ``coding:`` gets one, too, since it would set the
    encoding of Python (PEP 263).
    """
    text = _visible(_text(value).replace("\\", "<U+005C>")).replace("*/", "* /")
    return Written(re.sub(r"coding(?=[:=])", "coding ", text))


def xml(value: object) -> Written:
    """Write a text in XML, between tags or in an attribute; what XML cannot hold is spelled."""
    return Written(_NOT_XML.sub(_spelled, _text(value)).translate(_XML))


def xml_comment(value: object) -> Written:
    """Write a text in a comment of XML or Markdown, where two hyphens may not meet (XML 1.0, Sect. 2.5)."""
    text = re.sub("-(?=-)", "- ", _visible(_text(value)))
    return Written(f"{text} " if text.endswith("-") else text)


def yaml(value: object) -> Written:
    """Write a text, number or truth value as YAML; a text in double quotes unless it is a plain word."""
    if isinstance(value, (bool, int, float)):
        return Written(json.dumps(value))
    text = _text(value)
    is_plain = _PLAIN_YAML.fullmatch(text) and text.lower() not in _YAML_WORDS
    return Written(text if is_plain else f'"{_inside_quotes(text)}"')


def cmake(value: object) -> Written:
    """Write a text as a quoted argument of CMake."""
    return Written('"' + re.sub(r'(["\\$])', r"\\\1", _visible(_text(value))) + '"')


def markdown(value: object) -> Written:
    """Write a text in one line of Markdown, also in a table."""
    text = _MARKDOWN.sub(r"\\\g<0>", _visible(_text(value)))
    return Written(re.sub("&|<", lambda found: "&amp;" if found.group() == "&" else "&lt;", text))


def code(value: object) -> Written:
    """Write a text as code in one line of Markdown, between backticks, also in a table."""
    text = _visible(_text(value)).replace("|", "\\|")
    fence = "`" * (1 + max(map(len, re.findall("`+", text)), default=0))
    padding = " " if "`" in text else ""
    return Written(f"{fence}{padding}{text}{padding}{fence}")


def name(value: object) -> Name:
    """Write an identifier.

    Raises
    ------
    UnfilteredError
        The value is none.
    """
    try:
        return Name(_text(value))
    except ValueError as error:
        raise UnfilteredError(str(error)) from None


FILTERS = {
    "name": name,
    "py": python,
    "docstring": docstring,
    "comment": comment,
    "xml": xml,
    "xml_comment": xml_comment,
    "yaml": yaml,
    "cmake": cmake,
    "md": markdown,
    "code": code,
}
"""The filters by their names in templates."""


def _text(value: object) -> str:
    if isinstance(value, (str, int, float)):
        return str(value)
    raise _refused(value)


def _refused(value: object) -> UnfilteredError:
    return UnfilteredError(f"no filter writes {with_article(type(value).__name__)}")


def _inside_quotes(text: str) -> str:
    return "".join(map(_escaped, text))


def _escaped(character: str) -> str:
    if character in '"\\':
        return f"\\{character}"
    return character if character.isprintable() else character.encode("unicode_escape").decode()


def _visible(text: str) -> str:
    return "".join(each if each.isprintable() else f"<U+{ord(each):04X}>" for each in text)


def _spelled(found: re.Match[str]) -> str:
    return f"<U+{ord(found.group()):04X}>"
