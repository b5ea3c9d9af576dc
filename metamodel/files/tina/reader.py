"""Reading TINA's ``.net``: lark parses declarations, which are summed up and then made a net."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

from lark import Lark, Token, Transformer
from lark.exceptions import LarkError, UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from dineros.metamodel import pn
from dineros.metamodel.errors import Location, ModelFileError, near_matches
from dineros.metamodel.files.schema import read_integer
from dineros.metamodel.positions import remember

NAME_LIMIT = 500_000
_FACTORS = {"K": 1_000, "M": 1_000_000}
_SHOWN = {
    "NAME": "a name",
    "QUOTED": None,
    "INTEGER": "a number",
    "UNBOUNDED": "w",
    "STOPWATCH": None,
    "HIGHER": ">",
    "LOWER": "<",
    "$END": "the end",
}


class _Arc(NamedTuple):
    name: Token
    kind: str
    """``*`` normal, ``?`` read, ``?-`` inhibitor, ``!`` and ``!-`` stopwatch."""
    weight: Token | None


class _Declaration(NamedTuple):
    """A ``tr`` or ``pl`` line; `given` is an interval or a marking."""

    kind: str
    name: Token
    label: Token | None
    given: list[Token] | Token | None
    inputs: list[_Arc] | None
    outputs: list[_Arc] | None


class _Declarations(Transformer[Token, list[Any]]):
    """Turns parse results into declarations while parsing."""

    def start(self, children: list[Any]) -> list[Any]:
        return children

    def net(self, children: list[Any]) -> tuple[str, Token]:
        return ("net", children[0])

    def transition(self, children: list[Any]) -> _Declaration:
        return _Declaration("tr", *children)

    def place(self, children: list[Any]) -> _Declaration:
        return _Declaration("pl", *children)

    def label(self, children: list[Any]) -> tuple[str, Token, Token]:
        return ("lb", children[0], children[1])

    def priority(self, children: list[Any]) -> tuple[str, list[Token], list[Token]]:
        middle = next(index for index, token in enumerate(children) if token.type in ("HIGHER", "LOWER"))
        left, right = children[:middle], children[middle + 1 :]
        return ("pr", left, right) if children[middle].type == "HIGHER" else ("pr", right, left)

    def note(self, children: list[Any]) -> tuple[str]:
        return ("nt",)

    def interval(self, children: list[Any]) -> list[Any]:
        return children

    def arcs(self, children: list[Any]) -> list[Any]:
        return children

    def arc(self, children: list[Any]) -> _Arc:
        name, kind, weight = children
        return _Arc(name, str(kind) if kind else "*", weight)


@cache
def _parser() -> Lark:
    return Lark.open("tina.lark", rel_to=__file__, parser="lalr", transformer=_Declarations())


@dataclass(slots=True)
class _Node:
    """What the declarations say of a place or transition."""

    token: Token
    label: str | None = None
    tokens: int | None = None
    interval: tuple[float, float | None, bool, bool] | None = None
    takes: dict[tuple[str, str], tuple[int, Token]] = field(default_factory=dict)
    """Of a transition: weight by place and arc kind (``>`` for what it puts)."""


def net_from_text(content: bytes, path: Path) -> pn.Net:
    """Return the net that the content of a ``.net`` file describes.

    Raises
    ------
    ModelFileError
        See `read_net`.
    """
    return _Reader(path).read(content)


class _Reader:
    def __init__(self, path: Path) -> None:
        self._path = path
        self._name: Token | None = None
        self._places: dict[str, _Node] = {}
        self._transitions: dict[str, _Node] = {}
        self._priorities: list[tuple[Token, Token]] = []

    def read(self, content: bytes) -> pn.Net:
        labels: list[tuple[Token, Token]] = []
        for declaration in self._parse(content):
            match declaration:
                case _Declaration():
                    self._node(declaration)
                case ("net", name):
                    self._name = name
                case ("lb", name, label):
                    labels.append((name, label))
                case ("pr", higher, lower):
                    self._priorities.extend((first, second) for first in higher for second in lower)
        for name, label in labels:
            self._known(name, {**self._places, **self._transitions}).label = _plain(label)
        for name, node in self._transitions.items():
            if name in self._places:
                raise self._error(node.token, f"{name!r} is a place and a transition", "rename one of them")
        return self._net()

    def _parse(self, content: bytes) -> list[Any]:
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            line = content.count(b"\n", 0, error.start) + 1
            raise ModelFileError("is not UTF-8 text", location=Location(self._path, line)) from error
        names = re.finditer(r"[\w']+|\{", text)
        if next(islice(names, NAME_LIMIT, None), None) is not None:
            raise ModelFileError(f"has more than {NAME_LIMIT} names", location=Location(self._path))
        if not text.strip():
            raise ModelFileError("is empty", location=Location(self._path), hint="a net is expected")
        try:
            declarations: list[Any] = _parser().parse(text)  # type: ignore[assignment]
        except UnexpectedInput as error:
            raise self._unexpected(error, text) from error
        except LarkError as error:
            raise ModelFileError(f"is no .net file: {error}", location=Location(self._path)) from error
        return declarations

    # Summing up ----------------------------------------------------------------------------------------

    def _node(self, declaration: _Declaration) -> None:
        nodes = self._transitions if declaration.kind == "tr" else self._places
        node = nodes.setdefault(_plain(declaration.name), _Node(declaration.name))
        if declaration.label is not None:
            node.label = _plain(declaration.label)
        if isinstance(declaration.given, Token):
            if node.tokens is not None:
                raise self._error(declaration.given, f"place {_plain(declaration.name)!r} has two markings")
            node.tokens = self._integer(declaration.given, 0)
        elif declaration.given is not None:
            interval = self._interval(declaration.given)
            if node.interval not in (None, interval):
                raise self._error(
                    declaration.name, f"transition {_plain(declaration.name)!r} has two intervals"
                )
            node.interval = interval
        for arc in declaration.inputs or ():
            if declaration.kind == "tr":
                self._arc(arc.name, declaration.name, arc, arc.kind)
            else:
                self._arc(declaration.name, arc.name, arc, ">")
        for arc in declaration.outputs or ():
            if declaration.kind == "tr":
                self._arc(arc.name, declaration.name, arc, ">")
            else:
                self._arc(declaration.name, arc.name, arc, arc.kind)

    def _arc(self, place: Token, transition: Token, arc: _Arc, kind: str) -> None:
        if arc.kind.startswith("!"):
            raise self._error(
                arc.name, "stopwatch arcs cannot be represented", "use a read or an inhibitor arc"
            )
        if kind == ">" and arc.kind != "*":
            raise self._error(arc.name, "only a normal arc can lead from a transition to a place")
        weight = 1 if arc.weight is None else self._integer(arc.weight, 1)
        self._places.setdefault(_plain(place), _Node(place))
        known = self._transitions.setdefault(_plain(transition), _Node(transition)).takes
        key = (_plain(place), kind)
        if key in known:
            # Arcs add up; of several conditions the strictest holds.
            weight = {"?": max, "?-": min}.get(kind, _add)(weight, known[key][0])
            self._in_range(weight, arc.name)
        known[key] = (weight, arc.name)

    def _interval(self, parts: list[Token]) -> tuple[float, float | None, bool, bool]:
        start, earliest, latest, end = parts
        low, low_open, high_open = float(self._integer(earliest, 0)), start == "]", end == "["
        if latest.type == "UNBOUNDED":
            if not high_open:
                raise self._error(latest, "an unbounded interval ends with w[")
            return low, None, low_open, False
        high = float(self._integer(latest, 0))
        if high < low or (high == low and (low_open or high_open)):
            raise self._error(
                earliest, f"the interval {''.join(map(str, (start, earliest, ',', latest, end)))} is empty"
            )
        return low, high, low_open, high_open

    def _integer(self, token: Token, least: int) -> int:
        factor = _FACTORS.get(token[-1], 1)
        try:
            value = read_integer(token.rstrip("KM")) * factor
        except ValueError as error:
            raise self._error(token, f"{token[:40]!r} is too large") from error
        if value < least:
            raise self._error(token, f"a weight is {least} or more, not {value}")
        return self._in_range(value, token)

    def _in_range(self, value: int, token: Token) -> int:
        if value >= 2**31:
            raise self._error(token, f"{value} is too large", "numbers have 32 bits")
        return value

    # Making the net ----------------------------------------------------------------------------------------

    def _net(self) -> pn.Net:
        identifiers = _Identifiers()
        ids = {name: identifiers(name) for name in (*self._places, *self._transitions)}
        title = _plain(self._name) if self._name else self._path.stem
        net = pn.Net(id=identifiers(title or "net"))
        if title and net.id != title:
            net.name = title
        page = pn.Page(id=identifiers("page"))
        places = {}
        for name, node in self._places.items():
            place = pn.Place(id=ids[name], name=_label(name, node, ids[name]), tokens=node.tokens or 0)
            places[name] = self._placed(place, node.token)
        transitions = {}
        for name, node in self._transitions.items():
            transition = pn.Transition(id=ids[name], name=_label(name, node, ids[name]))
            if node.interval is not None:
                low, high, low_open, high_open = node.interval
                transition.interval = pn.TimeInterval(
                    earliest=low, latest=high, earliestExcluded=low_open, latestExcluded=high_open
                )
            transitions[name] = self._placed(transition, node.token)
        page.objects.extend([*places.values(), *transitions.values()])
        page.arcs.extend(self._arcs(places, transitions, identifiers))
        for higher, lower in self._priorities:
            first = transitions[_plain(self._known(higher, self._transitions).token)]
            first.overrides.append(transitions[_plain(self._known(lower, self._transitions).token)])
        net.pages.append(page)
        return net

    def _arcs(
        self, places: dict[str, pn.Place], transitions: dict[str, pn.Transition], identifiers: _Identifiers
    ) -> list[pn.Arc]:
        made = []
        for transition_name, node in self._transitions.items():
            transition = transitions[transition_name]
            for (place_name, kind), (given, token) in node.takes.items():
                place = places[place_name]
                taken = node.takes.get((place_name, "*"), (0, token))[0]
                weight = given - taken if kind == "?" else given
                if weight < 1:
                    continue  # what it takes already asks for as much as it reads
                source, target = (transition, place) if kind == ">" else (place, transition)
                role = {"?": "read", "?-": "inhibitor"}.get(kind, "normal")
                suffix = "" if role == "normal" else f"-{role}"
                arc = pn.Arc(
                    id=identifiers(f"{source.id}-{target.id}{suffix}"),
                    source=source,
                    target=target,
                    weight=weight,
                    kind=role,
                )
                made.append(self._placed(arc, token))
        return made

    def _placed(self, element: Any, token: Token) -> Any:
        remember(element, Location(self._path, token.line, token.column))
        return element

    def _known(self, token: Token, nodes: dict[str, _Node]) -> _Node:
        name = _plain(token)
        if name not in nodes:
            raise self._error(token, f"there is no {name!r}", near_matches(name, nodes))
        return nodes[name]

    # Errors ----------------------------------------------------------------------------------------------

    def _unexpected(self, error: UnexpectedInput, text: str) -> ModelFileError:
        expected: Iterable[str] = ()
        location = Location(self._path, error.line, error.column)
        if isinstance(error, UnexpectedToken):
            expected = error.accepts or error.expected
            found = repr(str(error.token)[:40])
            if error.token.type == "$END":
                found = "the end of the file"
                location = Location(self._path, text.count("\n") + 1)
        else:
            assert isinstance(error, UnexpectedCharacters)
            expected = error.allowed or ()
            found = repr(error.char)
        wanted = sorted({shown for name in expected if (shown := _shown(name))})
        hint = f"expected {', '.join(wanted)}" if 0 < len(wanted) < 8 else None
        if found == "'{'":
            hint = "a quoted name ends with }, and inside { } \\ are written \\{ \\} \\\\"
        return ModelFileError(f"unexpected {found}", location=location, hint=hint)

    def _error(self, token: Token, message: str, hint: str | None = None) -> ModelFileError:
        return ModelFileError(message, location=Location(self._path, token.line, token.column), hint=hint)


class _Identifiers:
    """Makes ids of names: without white space, each once."""

    def __init__(self) -> None:
        self._used: set[str] = set()
        self._next: defaultdict[str, int] = defaultdict(lambda: 2)

    def __call__(self, name: str) -> str:
        stem = re.sub(r"\s", "_", name) or "_"
        identifier = stem
        while identifier in self._used:
            identifier = f"{stem}_{self._next[stem]}"
            self._next[stem] += 1
        self._used.add(identifier)
        return identifier


def _plain(token: Token) -> str:
    """Return a name without its quotes."""
    return re.sub(r"\\(.)", r"\1", token[1:-1], flags=re.DOTALL) if token.type == "QUOTED" else str(token)


def _label(name: str, node: _Node, identifier: str) -> str | None:
    return node.label or (name if name != identifier else None)


def _add(first: int, second: int) -> int:
    return first + second


def _shown(terminal: str) -> str | None:
    if terminal in _SHOWN:
        return _SHOWN[terminal]
    definition = next((known for known in _parser().terminals if known.name == terminal), None)
    return str(definition.pattern.value).replace("\\", "") if definition else terminal
