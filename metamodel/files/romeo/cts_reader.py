"""Reading Romeo's ``.cts``: the part of that language in which Romeo itself writes time Petri nets.

::

    .cts        ::= typedef* 'initially' '{' (('place' | 'int') token (',' token)* ';')* '}' transition* rest
    typedef     ::= 'typedef' 'int' 'place' ';'
    token       ::= name '=' number
    transition  ::= 'transition' ['[' option (',' option)* ']'] name interval
                    'when' '(' guard ')' '{' effect '}'
    option      ::= 'intermediate' '{' effect '}'  |  ('priority' | 'speed' | 'cost' | 'control') '=' value
    interval    ::= ('[' | ']' | '(') bound ',' (bound | 'inf') (']' | '[' | ')')
    guard       ::= 'true'  |  condition ('and' condition)*
    condition   ::= name ('>=' | '>' | '<' | '<=') number  |  '(' guard ')'
    effect      ::= [change ((',' | ';') change)*] [';']
    change      ::= name '=' name (('+' | '-') number)*
    rest        ::= a formula, after 'check', 'graph', 'cost_rate' and the like; it is not read

What the intermediate marking takes are arcs from places; what the effect adds to that are arcs to places. A
guard that asks for more is a read arc, one with ``<`` an inhibitor arc. Everything else in the language,
such as variables, functions, parameters and speeds, is refused with its line.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from dineros.metamodel import pn
from dineros.metamodel.errors import ModelFileError, near_matches
from dineros.metamodel.files.exact import exact_number, fraction_of
from dineros.metamodel.files.schema import read_integer
from dineros.metamodel.files.tina.parsing import Text, Token
from dineros.metamodel.positions import remember

_Element = TypeVar("_Element", bound=pn.Element)
_TOKEN = re.compile(
    r"""(?:\s|//[^\n]*|/\*.*?\*/)*
    (?: (?P<number>[0-9]+(?:\.[0-9]+|/[0-9]+)?)
      | (?P<word>[A-Za-z_]\w*(?:::\w+)*)
      | (?P<sign>>=|<=|==|!=|&&|\|\||[][(){},;=<>+-])
      | (?P<end>\Z)
      | (?P<other>.)
    )""",
    re.VERBOSE | re.DOTALL,
)
_REST = frozenset({"check", "graph", "cost_rate", "simulate", "control", "nodes"})
_ROLES = {"read": pn.ArcKind.read, "inhibitor": pn.ArcKind.inhibitor}
_PLACES = ("place", "int")
"""Versions up to 3.4 declare places as whole numbers."""
_NO_VARIABLES = "a net has places only: variables, types and functions are not analysed"
_CHANGES = "only changes such as NAME = NAME + NUMBER, or with -, are read"


@dataclass(slots=True)
class _Transition:
    """A transition as the file has it; weights by place."""

    token: Token
    interval: pn.TimeInterval | None = None
    priority: int = 0
    takes: dict[str, int] = field(default_factory=dict)
    needs: dict[str, int] = field(default_factory=dict)
    inhibitors: dict[str, int] = field(default_factory=dict)
    effect: dict[str, int] = field(default_factory=dict)


def net_from_cts(content: bytes, path: Path) -> pn.Net:
    """Return the net that the content of a ``.cts`` file describes, on one page; ids are the names.

    Raises
    ------
    ModelFileError
        The file is not in this format, or says what a time Petri net cannot; with line and column.
    """
    return _CtsReader(Text(content, path)).read()


class _CtsReader:
    def __init__(self, text: Text) -> None:
        self._text = text
        self._tokens = self._all_tokens()
        self._at = 0
        self._places: dict[str, tuple[int, Token]] = {}
        self._transitions: dict[str, _Transition] = {}

    def _all_tokens(self) -> list[Token]:
        found: list[Token] = []
        at = 0
        while not found or found[-1].kind != "end":
            match = _TOKEN.match(self._text.text, at)
            assert match is not None and match.lastgroup is not None, "any character matches"
            found.append(Token(match.lastgroup, match[match.lastgroup], match.start(match.lastgroup)))
            at = match.end()
        return found

    def read(self) -> pn.Net:
        while self._peek() == "typedef":
            start = self._next()
            if [self._next().text for _ in range(3)] != ["int", "place", ";"]:
                raise self._text.error(start, "only 'typedef int place;' is read", _NO_VARIABLES)
        self._expect("initially", _NO_VARIABLES)
        self._expect("{")
        while self._peek() != "}":
            declares = self._next()
            if declares.text not in _PLACES:
                raise self._unexpected(declares, "'place'", _NO_VARIABLES)
            self._list_of_places()
        self._next()
        while self._peek() == "transition":
            self._next()
            self._transition()
        rest = self._next()
        if rest.kind != "end" and rest.text not in _REST:
            raise self._unexpected(rest, "a transition, or a formula to check")
        for later in self._tokens[self._at :]:
            if later.text in ("transition", "initially"):
                raise self._text.error(later, f"{later.text!r} follows {rest.text!r}")
        return self._net()

    # Tokens ------------------------------------------------------------------------------------------------

    def _peek(self) -> str:
        return self._tokens[self._at].text

    def _next(self) -> Token:
        token = self._tokens[self._at]
        self._at = min(self._at + 1, len(self._tokens) - 1)
        return token

    def _unexpected(self, token: Token, expected: str, hint: str | None = None) -> ModelFileError:
        found = "the end of the file" if token.kind == "end" else repr(token.text[:40])
        return self._text.error(token, f"unexpected {found}: {expected} is expected", hint)

    def _expect(self, text: str, hint: str | None = None) -> Token:
        token = self._next()
        if token.text != text:
            raise self._unexpected(token, repr(text), hint)
        return token

    def _name(self) -> Token:
        token = self._next()
        if token.kind != "word":
            raise self._unexpected(token, "a name")
        return token

    def _known(self, token: Token) -> str:
        if token.text not in self._places:
            hint = near_matches(token.text, self._places) or _NO_VARIABLES
            raise self._text.error(token, f"there is no place {token.text[:40]!r}", hint)
        return token.text

    def _whole(self, hint: str | None = None) -> int:
        token = self._next()
        try:
            return read_integer(token.text)
        except ValueError:
            raise self._unexpected(token, "a whole number of 32 bits", hint) from None

    # Parts -------------------------------------------------------------------------------------------------

    def _list_of_places(self) -> None:
        while True:
            name = self._name()
            if name.text in self._places:
                raise self._text.error(name, f"place {name.text[:40]!r} is declared twice")
            self._expect("=")
            self._places[name.text] = self._whole("tokens with colours are not read: unfold the net"), name
            token = self._next()
            if token.text == ";":
                return
            if token.text != ",":
                raise self._unexpected(token, "',' or ';'")

    def _transition(self) -> None:
        made = _Transition(self._tokens[self._at])
        if self._peek() == "[":
            self._next()
            self._option(made)
            while self._peek() == ",":
                self._next()
                self._option(made)
            self._expect("]")
        name = made.token = self._name()
        if name.text in self._transitions or name.text in self._places:
            raise self._text.error(name, f"the name {name.text[:40]!r} is taken")
        made.interval = self._interval(name)
        self._expect("when")
        self._expect("(")
        self._guard(made)
        self._expect(")")
        self._expect("{")
        made.effect = self._changes()
        self._transitions[name.text] = made

    def _option(self, made: _Transition) -> None:
        option = self._name()
        if option.text == "intermediate":
            self._expect("{")
            for place, change in self._changes().items():
                if change > 0:
                    raise self._text.error(option, f"the intermediate marking adds tokens to {place!r}")
                made.takes[place] = -change
            return
        self._expect("=")
        if option.text == "priority":
            made.priority = self._whole("priorities that change are not read")
            return
        value = self._next()
        if option.text == "speed":
            if value.text != "1" or self._peek() not in (",", "]"):
                hint = "clocks that run at another speed are stopwatches"
                raise self._text.error(option, "a speed is not read", hint)
        elif option.text in ("cost", "control"):
            while self._peek() not in (",", "]") and value.kind != "end":
                value = self._next()  # changes no behaviour
        else:
            raise self._text.error(option, f"the option {option.text[:40]!r} is not supported")

    def _interval(self, transition: Token) -> pn.TimeInterval | None:
        start = self._next()
        if start.text not in ("[", "]", "("):
            raise self._unexpected(start, "an interval such as [1,2]")
        low = self._bound()
        self._expect(",")
        high = None
        if self._peek() == "inf":
            self._next()
        else:
            high = self._bound()
        end = self._next()
        if end.text not in ("]", "[", ")"):
            raise self._unexpected(end, "the end of the interval")
        low_open, high_open = start.text != "[", high is not None and end.text != "]"
        if high is not None:
            width = fraction_of(high) - fraction_of(low)
            if width < 0 or (not width and (low_open or high_open)):
                raise self._text.error(start, f"the interval of transition {transition.text!r} is empty")
        elif not low and not low_open:
            return None
        return pn.TimeInterval(earliest=low, latest=high, earliestExcluded=low_open, latestExcluded=high_open)

    def _bound(self) -> float:
        token = self._next()
        try:
            return exact_number(token.text)
        except ValueError:
            hint = "parameters are not read: parametric nets are not analysed"
            raise self._unexpected(token, "a number", hint) from None

    def _guard(self, made: _Transition) -> None:
        """Read conditions that are joined by 'and', with parentheses anywhere."""
        depth = 0
        while True:
            while self._peek() == "(":
                self._next()
                depth += 1
            if self._peek() == "true":
                self._next()
            else:
                self._condition(made)
            while depth and self._peek() == ")":
                self._next()
                depth -= 1
            if self._peek() in ("and", "&&"):
                self._next()
            elif depth:
                raise self._unexpected(self._next(), "'and' or ')'")
            else:
                return

    def _condition(self, made: _Transition) -> None:
        place = self._known(self._name())
        sign = self._next()
        weight = self._whole("a place is compared with a number") + (sign.text in (">", "<="))
        if sign.text in (">=", ">"):
            made.needs[place] = max(made.needs.get(place, 0), weight)
        elif sign.text in ("<", "<="):
            made.inhibitors[place] = min(made.inhibitors.get(place, weight), weight)
        else:
            raise self._unexpected(sign, "'>=', '>', '<' or '<='")
        if weight < 1 and sign.text == "<":
            raise self._text.error(sign, f"{place} < 0 is never true")

    def _changes(self) -> dict[str, int]:
        """Read changes up to the closing brace; return them by place, without those that change nothing."""
        found: dict[str, int] = {}
        while self._peek() != "}":
            if self._peek() in (",", ";"):
                self._next()
                continue
            name = self._name()
            place = self._known(name)
            self._expect("=", _CHANGES)
            again = self._next()
            if again.text != place:
                raise self._unexpected(again, repr(place), _CHANGES)
            while self._peek() in ("+", "-"):
                factor = 1 if self._next().text == "+" else -1
                found[place] = found.get(place, 0) + factor * self._whole(_CHANGES)
        self._next()
        return {place: change for place, change in found.items() if change}

    # Making the net ----------------------------------------------------------------------------------------

    def _net(self) -> pn.Net:
        names = {*self._places, *self._transitions}

        def free(name: str) -> str:
            while name in names:
                name += "_"
            names.add(name)
            return name

        net = pn.Net(id=free(re.sub(r"\s", "_", self._text.path.stem) or "net"))
        page = pn.Page(id=free("page"), net=net)
        places = {
            name: self._placed(pn.Place(id=name, tokens=tokens), token)
            for name, (tokens, token) in self._places.items()
        }
        made = {
            name: self._placed(pn.Transition(id=name, interval=one.interval), one.token)
            for name, one in self._transitions.items()
        }
        page.objects.extend([*places.values(), *made.values()])
        for name, one in self._transitions.items():
            for kind, place, weight in self._arcs(name, one):
                ends = (made[name], places[place]) if kind == "output" else (places[place], made[name])
                role = _ROLES.get(kind, pn.ArcKind.normal)
                suffix = f"-{kind}" if kind in _ROLES else ""
                id = free(f"{ends[0].id}-{ends[1].id}{suffix}")
                arc = pn.Arc(id=id, source=ends[0], target=ends[1], weight=weight, kind=role)
                page.arcs.append(self._placed(arc, one.token))
            lower = [made[low] for low, other in self._transitions.items() if other.priority < one.priority]
            made[name].overrides.extend(lower)
        return net

    def _arcs(self, name: str, one: _Transition) -> list[tuple[str, str, int]]:
        found: list[tuple[str, str, int]] = []
        for place in self._places:
            take, need = one.takes.get(place, 0), one.needs.get(place, 0)
            put = one.effect.get(place, 0) + take
            if put < 0:
                message = f"transition {name!r} takes tokens from {place!r}, which 'intermediate' keeps"
                raise self._text.error(one.token, message, "list in 'intermediate' the tokens that it takes")
            if need < take:
                message = f"transition {name!r} takes {take} from {place!r}, and its guard asks for {need}"
                raise self._text.error(one.token, message, f"write {place} >= {take}")
            found += [
                (kind, place, weight)
                for kind, weight in (
                    ("normal", take),
                    ("read", need - take),
                    ("inhibitor", one.inhibitors.get(place, 0)),
                    ("output", put),
                )
                if weight
            ]
        return found

    def _placed(self, element: _Element, token: Token) -> _Element:
        remember(element, self._text.location(token))
        return element
