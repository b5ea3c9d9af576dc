r"""The grammar of TINA's ``.net``, as its manual page "formats" describes it: from text to declarations.

::

    .net      ::= (netdesc | trdesc | pldesc | lbdesc | prdesc | ntdesc)*
    netdesc   ::= 'net' name
    trdesc    ::= 'tr' name [':' name] [interval] [arc* '->' arc*]
    pldesc    ::= 'pl' name [':' name] ['(' number ')'] [arc* '->' arc*]
    lbdesc    ::= 'lb' name name
    prdesc    ::= 'pr' name+ ('<' | '>') name+
    ntdesc    ::= 'nt' name ('0' | '1') name
    interval  ::= ('[' | ']') bound ',' bound ('[' | ']')  |  ('[' | ']') bound ',' 'w' '['
    bound     ::= number  |  digits '.' digits  |  digits '/' digits
    arc       ::= name [('*' | '?' | '?-' | '!' | '!-') number]
    number    ::= digits ['K' | 'M' | 'G' | 'T' | 'P' | 'E']
    name      ::= letters, digits, ' and _  |  '{' anything, with \{ \} \\ '}'

White space separates, comments go from ``#`` to the end of the line. The grammar is ambiguous where a name
in a list of arcs could also be the key word of the next declaration. It is the key word, unless the file
declares a node of that name (``pl pl (1)``) and the word is not the first on its line.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from dineros.metamodel.errors import Location, ModelFileError, near_matches

NAME_LIMIT = 500_000
KEY_WORDS = ("net", "tr", "pl", "lb", "pr", "nt")
FACTORS = {letter: 1000**power for power, letter in enumerate("KMGTPE", start=1)}

_TOKEN = re.compile(
    r"""(?:[\ \t\r\n\f]|\#[^\n]*)*
    (?: (?P<word>[A-Za-z0-9_']+)
      | (?P<quoted>\{(?:[^{}\\]|\\.)*\})
      | (?P<arrow>->)
      | (?P<kind>\*|\?-|\?|!-|!)
      | (?P<sign>[][(),:<>])
      | (?P<end>\Z)
      | (?P<other>.)
    )""",
    re.VERBOSE | re.DOTALL,
)
_BEGIN = f"a declaration begins with {', '.join(KEY_WORDS)}"
_OTHER_TOOLS = (
    "this is TINA's format, and .net files of GreatSPN, SYNET and others are not: export PNML there"
)
_NUMBER = re.compile(r"[0-9]+[KMGTPE]?")
_DIGITS = re.compile(r"[0-9]+")
_ESCAPED = re.compile(r"\\(.)", re.DOTALL)
_ODD_NAMES = re.compile(rf"^[ \t]*(?:pl|tr)[ \t]+({'|'.join(KEY_WORDS)})(?![A-Za-z0-9_'])", re.MULTILINE)


class Token(NamedTuple):
    """A part of the text; `kind` is that of `_TOKEN`, `at` its position in the text."""

    kind: str | None
    text: str
    at: int

    @property
    def plain(self) -> str:
        """A name without its quotes."""
        return _ESCAPED.sub(r"\1", self.text[1:-1]) if self.kind == "quoted" else self.text

    @property
    def is_name(self) -> bool:
        """Whether it is a name, quoted or not."""
        return self.kind in ("word", "quoted")


class Arc(NamedTuple):
    """A place of a transition, or the other way round."""

    name: Token
    kind: str
    """``*`` normal, ``?`` read, ``?-`` inhibitor, ``!`` and ``!-`` stopwatch."""
    weight: Token | None


class Declaration(NamedTuple):
    """A ``tr`` or ``pl`` declaration; `given` is an interval (start, bound, bound, end) or a marking."""

    kind: str
    name: Token
    label: Token | None
    given: list[Token] | Token | None
    inputs: list[Arc]
    outputs: list[Arc]


class Statement(NamedTuple):
    """A ``net``, ``lb``, ``pr`` or ``nt`` declaration; `more` holds the lower transitions of a priority."""

    kind: str
    names: list[Token]
    more: list[Token]


class Text:
    """The text of a file, and the locations in it.

    Raises
    ------
    ModelFileError
        It is not UTF-8, is empty, or has too many names.
    """

    def __init__(self, content: bytes, path: Path) -> None:
        self.path = path
        try:
            self.text = content.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            line = content.count(b"\n", 0, error.start) + 1
            hint = "convert it to UTF-8"
            raise ModelFileError("is not UTF-8 text", location=Location(path, line), hint=hint) from error
        names = re.finditer(r"[\w']+|\{", self.text)
        if next(islice(names, NAME_LIMIT, None), None) is not None:
            raise ModelFileError(f"has more than {NAME_LIMIT} names", location=Location(path))
        if not self.text.strip():
            raise ModelFileError("is empty", location=Location(path), hint="a net is expected")
        self._lines = [0, *(match.end() for match in re.finditer("\n", self.text))]

    def line(self, token: Token) -> int:
        """Return the line of a token, from 1."""
        return bisect_right(self._lines, token.at)

    def location(self, token: Token) -> Location:
        """Return file, line and column of a token."""
        return self.location_at(token.at)

    def location_at(self, at: int) -> Location:
        """Return file, line and column of a position in the text, from 0."""
        line = bisect_right(self._lines, at)
        return Location(self.path, line, at - self._lines[line - 1] + 1)

    def error(self, token: Token, message: str, hint: str | None = None) -> ModelFileError:
        """Return an error about a token, to be raised."""
        return ModelFileError(message, location=self.location(token), hint=hint)

    def is_first_on_line(self, token: Token) -> bool:
        """Return whether only white space is before a token on its line."""
        return not self.text[self._lines[self.line(token) - 1] : token.at].strip()


class Parser:
    """Yields the declarations of a text."""

    def __init__(self, text: Text) -> None:
        self._text = text
        self._odd = frozenset(_ODD_NAMES.findall(text.text))
        """Key words that are names of nodes, too."""
        self._position = 0
        self._token = Token(None, "", 0)
        self._advance()

    def declarations(self) -> Iterator[Declaration | Statement]:
        """Yield one declaration after the other.

        Raises
        ------
        ModelFileError
            The text does not follow the grammar, with line and column.
        """
        while self._token.kind != "end":
            word = self._token
            if word.kind != "word" or word.text not in KEY_WORDS:
                near = near_matches(word.text, KEY_WORDS) if word.kind == "word" else None
                is_first = not self._text.text[: word.at].strip()
                raise self._unexpected(near or (f"{_BEGIN}; {_OTHER_TOOLS}" if is_first else _BEGIN))
            self._advance()
            if word.text in ("tr", "pl"):
                yield self._node(word.text)
            elif word.text == "pr":
                yield self._priority()
            else:
                count = {"net": 1, "lb": 2, "nt": 3}[word.text]
                names = [self._name() for _ in range(count)]
                if word.text == "nt" and names[1].text not in ("0", "1"):
                    raise self._text.error(names[1], "a note has the number 0 or 1 between its name and text")
                yield Statement(word.text, names, [])

    def _node(self, kind: str) -> Declaration:
        name = self._name()
        label = self._name() if self._take(":") else None
        given: list[Token] | Token | None = None
        if kind == "tr" and self._token.text in ("[", "]") and self._token.kind == "sign":
            given = self._interval()
        elif kind == "pl" and self._take("("):
            given = self._number()
            self._expect(")")
        inputs = self._arcs()
        outputs: list[Arc] = []
        if self._token.kind == "arrow":
            self._advance()
            outputs = self._arcs()
        elif inputs:
            raise self._unexpected("expected a name, ->")
        return Declaration(kind, name, label, given, inputs, outputs)

    def _interval(self) -> list[Token]:
        start = self._advance()
        low = self._bound()
        self._expect(",")
        unbounded = self._token.kind == "word" and self._token.text == "w"
        high = self._advance() if unbounded else self._bound()
        if self._token.kind != "sign" or self._token.text not in ("[", "]"):
            raise self._unexpected("expected [, ]")
        return [start, low, high, self._advance()]

    def _arcs(self) -> list[Arc]:
        found = []
        while self._token.is_name and not self._begins_declaration():
            name = self._advance()
            if self._token.kind == "kind":
                found.append(Arc(name, self._advance().text, self._number()))
            else:
                found.append(Arc(name, "*", None))
        return found

    def _begins_declaration(self) -> bool:
        token = self._token
        if token.kind != "word" or token.text not in KEY_WORDS:
            return False
        return token.text not in self._odd or self._text.is_first_on_line(token)

    def _priority(self) -> Statement:
        first = [self._name()]
        while self._token.is_name:
            first.append(self._name())
        sign = self._advance()
        if sign.kind != "sign" or sign.text not in ("<", ">"):
            self._token = sign
            raise self._unexpected("expected <, >, a name")
        second = [self._name()]
        while self._token.is_name and not self._begins_declaration():
            second.append(self._name())
        return Statement("pr", first, second) if sign.text == ">" else Statement("pr", second, first)

    def _name(self) -> Token:
        if not self._token.is_name:
            raise self._unexpected("expected a name")
        return self._advance()

    def _number(self) -> Token:
        if self._token.kind != "word" or not _NUMBER.fullmatch(self._token.text):
            raise self._unexpected(f"expected a number, such as 3 or 2K; factors are {', '.join(FACTORS)}")
        return self._advance()

    def _bound(self) -> Token:
        """Return a number, which may be decimal or rational, as one token."""
        first = self._number()
        if not self._follows(first) or self._token.text not in (".", "/"):
            return first
        point = self._advance()
        if not self._follows(point) or not _DIGITS.fullmatch(self._token.text) or not first.text.isdigit():
            raise self._unexpected("a bound is a number such as 3, 0.25 or 1/3")
        return Token("word", first.text + point.text + self._advance().text, first.at)

    def _follows(self, before: Token) -> bool:
        """Return whether no white space is between a token and the next one."""
        return self._token.at == before.at + len(before.text)

    def _take(self, sign: str) -> bool:
        if self._token.kind == "sign" and self._token.text == sign:
            self._advance()
            return True
        return False

    def _expect(self, sign: str) -> None:
        if not self._take(sign):
            raise self._unexpected(f"expected {sign}")

    def _advance(self) -> Token:
        """Read the next token and return the one before it."""
        before = self._token
        match = _TOKEN.match(self._text.text, self._position)
        assert match is not None and match.lastgroup is not None
        self._position = match.end()
        self._token = Token(match.lastgroup, match[match.lastgroup], match.start(match.lastgroup))
        return before

    def _unexpected(self, hint: str) -> ModelFileError:
        token = self._token
        found = "the end of the file" if token.kind == "end" else repr(token.text[:40])
        if token.text == "{":
            hint = "a quoted name ends with }, and inside { } \\ are written \\{ \\} \\\\"
        return self._text.error(token, f"unexpected {found}", hint)
