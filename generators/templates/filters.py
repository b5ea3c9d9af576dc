"""Filters that write a value for its position in a generated file.

A value of a model is data: a name may contain quotes, line feeds or the end of a comment. So each kind of
position has its filter, whose result is `Written`, and `require_written` refuses to write other values: a
template cannot forget the filter. A text that a template cuts, joins or changes is a plain string again. Only
a `Name` needs no filter: it consists of letters, digits and underscores, which are safe in all formats.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable

import jinja2
import jinja2.sandbox

from dineros.metamodel.errors import with_article

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(?:\.[A-Za-z_][A-Za-z0-9_]*)*")
# Characters that XML 1.0 does not allow (Sect. 2.2, Char).
_NOT_XML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")
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
# Words that YAML 1.1 does not read as text (types bool and null of the tag repository).
_YAML_WORDS = frozenset({"y", "n", "yes", "no", "on", "off", "true", "false", "null"})
_MARKDOWN = re.compile(r"[\\`*\[\]|~]|(?<![^\W_])_|_(?![^\W_])")


class UnfilteredError(TypeError):
    """A template writes a value without a filter."""


class Written(str):
    """The result of a filter, or of a template itself: it is put into a file unchanged."""

    __slots__ = ()


class Name(Written):
    """A name that is safe anywhere in a generated file: ASCII identifiers, optionally joined by dots.

    Raises
    ------
    ValueError
        The text is not such a name.
    """

    __slots__ = ()

    def __new__(cls, text: str) -> Name:
        """Create a name."""
        if not _NAME.fullmatch(text):
            raise ValueError(f"{text!r} is not a name")
        return super().__new__(cls, text)


class Environment(jinja2.sandbox.ImmutableSandboxedEnvironment):
    """Templates that write only filtered or safe values, and can use only the values that they get.

    A template is a program, and user templates are untrusted. The results of macros and blocks consist of
    written parts, so they count as written.
    """

    @staticmethod
    def concat(parts: Iterable[str]) -> Written:
        """Join written parts; Jinja uses this for macros and blocks, too (cf. NativeEnvironment)."""
        return Written("".join(parts))


def require_written(value: object) -> object:
    """Return a value that a template writes.

    Raises
    ------
    UnfilteredError
        It has passed no filter, but needs one.
    """
    if isinstance(
        value, (Written, int, jinja2.Undefined)
    ):  # an undefined value raises its own error when it is written
        return value
    raise UnfilteredError(f"{value!r} is written without a filter")


def python(value: object) -> Written:
    """Write a value as a Python literal, texts in double quotes as formatters prefer."""
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
    """Write a text inside of double quotes (one or three) of a Python file; Python reads it unchanged."""
    return Written(_inside_quotes(_text(value)))


def comment(value: object) -> Written:
    r"""Write a text in a comment to the end of the line, in Python, YAML, CMake or a ROS interface.

    Invisible characters are written as ``<U+000A>``. So is the backslash, and ``*/`` gets a blank: comments
    of ROS interfaces become comments of C. ``coding:`` gets a blank, too, since it would set the encoding of
    a Python file (PEP 263).
    """
    text = _visible(_text(value).replace("\\", "<U+005C>")).replace("*/", "* /")
    return Written(re.sub(r"coding(?=[:=])", "coding ", text))


def xml(value: object) -> Written:
    """Write a text in XML, between tags or in an attribute; characters not allowed in XML are spelled out."""
    return Written(_NOT_XML.sub(_spelled, _text(value)).translate(_XML))


def xml_comment(value: object) -> Written:
    """Write a text in a comment of XML or Markdown, which may not contain ``--`` (XML 1.0, Sect. 2.5)."""
    text = re.sub("-(?=-)", "- ", _visible(_text(value)))
    return Written(f"{text} " if text.endswith("-") else text)


def yaml(value: object) -> Written:
    """Write a text, number or Boolean as YAML; a text in double quotes unless it is a plain word."""
    if isinstance(value, (bool, int, float)):
        return Written(json.dumps(value))
    text = _text(value)
    is_plain = _PLAIN_YAML.fullmatch(text) and text.lower() not in _YAML_WORDS
    return Written(text if is_plain else f'"{_inside_quotes(text)}"')


def cmake(value: object) -> Written:
    """Write a text as a quoted argument of CMake."""
    return Written('"' + re.sub(r'(["\\$])', r"\\\1", _visible(_text(value))) + '"')


def markdown(value: object) -> Written:
    """Write a text on one line of Markdown, also in a table."""
    text = _MARKDOWN.sub(r"\\\g<0>", _visible(_text(value)))
    return Written(re.sub("&|<", lambda found: "&amp;" if found.group() == "&" else "&lt;", text))


def code(value: object) -> Written:
    """Write a text as code on one line of Markdown, in backticks, also in a table."""
    text = _visible(_text(value)).replace("|", "\\|")
    fence = "`" * (1 + max(map(len, re.findall("`+", text)), default=0))
    padding = " " if "`" in text else ""
    return Written(f"{fence}{padding}{text}{padding}{fence}")


def name(value: object) -> Name:
    """Write an identifier.

    Raises
    ------
    UnfilteredError
        The value is not an identifier.
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
    return UnfilteredError(f"no filter can write {with_article(type(value).__name__)}")


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
