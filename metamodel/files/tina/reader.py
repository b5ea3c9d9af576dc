"""Reading TINA's ``.net``: declarations (see `parsing`) are summed up and then made a net."""

from __future__ import annotations

import re
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from dineros.metamodel import pn
from dineros.metamodel.errors import ModelFileError, near_matches
from dineros.metamodel.files.exact import exact_number, fraction_of, nearest
from dineros.metamodel.files.schema import read_integer
from dineros.metamodel.files.tina.parsing import FACTORS, Arc, Declaration, Parser, Text, Token
from dineros.metamodel.positions import remember_at

_BLANK = re.compile(r"\s")
_NORMAL = pn.ArcKind.normal
_ROLES = {"?": pn.ArcKind.read, "?-": pn.ArcKind.inhibitor}


@dataclass(slots=True)
class _Node:
    """What the declarations state about a place or transition."""

    token: Token
    label: str | None = None
    tokens: int | None = None
    given: Token | None = None
    """Where its marking or interval stands."""
    interval: tuple[float, float | None, bool, bool] | None = None
    takes: dict[tuple[str, str], tuple[int, Token]] = field(default_factory=dict)
    """Of a transition: weight by place and arc kind (``>`` for what it puts)."""


def net_from_text(content: bytes, path: Path) -> pn.Net:
    """Return the net that the content of a ``.net`` file describes, on one page.

    Ids are the names in the file, with ``_`` for white space; labels become names.

    Raises
    ------
    ModelFileError
        The file is not in this format, or holds what a net cannot: with line and column.
    """
    return _TinaReader(Text(content, path)).read()


class _TinaReader:
    def __init__(self, text: Text) -> None:
        self._text = text
        self._name: Token | None = None
        self._places: dict[str, _Node] = {}
        self._transitions: dict[str, _Node] = {}
        self._priorities: list[tuple[Token, Token]] = []

    def read(self) -> pn.Net:
        labels: list[list[Token]] = []
        for declaration in Parser(self._text).declarations():
            if isinstance(declaration, Declaration):
                self._node(declaration)
            elif declaration.kind == "net":
                self._title(declaration.names[0])
            elif declaration.kind == "lb":
                labels.append(declaration.names)
            elif declaration.kind == "pr":
                pairs = ((first, second) for first in declaration.names for second in declaration.more)
                self._priorities.extend(pairs)
        nodes = {**self._places, **self._transitions} if labels else {}
        for labelled, label in labels:
            self._known(labelled, nodes).label = label.plain
        for name, node in self._transitions.items():
            if name in self._places:
                raise self._text.error(
                    node.token, f"{name!r} is a place and a transition", "rename one of them"
                )
        return self._net()

    def _title(self, name: Token) -> None:
        if self._name is not None:
            lines = f"on lines {self._text.line(self._name)} and {self._text.line(name)}"
            raise self._text.error(name, f"the net has two names, {lines}", "a file holds one net")
        self._name = name

    # Summing up ----------------------------------------------------------------------------------------

    def _node(self, declaration: Declaration) -> None:
        nodes = self._transitions if declaration.kind == "tr" else self._places
        node = nodes.setdefault(declaration.name.plain, _Node(declaration.name))
        if declaration.label is not None:
            node.label = declaration.label.plain
        if isinstance(declaration.given, Token):
            if node.tokens is not None:
                raise self._twice(declaration, "markings", node.given)
            node.tokens = self._integer(declaration.given, 0)
            node.given = declaration.given
        elif declaration.given is not None:
            interval = self._interval(declaration.given)
            if node.interval not in (None, interval):
                raise self._twice(declaration, "intervals", node.given)
            node.interval = interval
            node.given = declaration.given[0]
        for arc in declaration.inputs:
            if declaration.kind == "tr":
                self._arc(arc.name, declaration.name, arc, arc.kind)
            else:
                self._arc(declaration.name, arc.name, arc, ">")
        for arc in declaration.outputs:
            if declaration.kind == "tr":
                self._arc(arc.name, declaration.name, arc, ">")
            else:
                self._arc(declaration.name, arc.name, arc, arc.kind)

    def _twice(self, declaration: Declaration, what: str, first: Token | None) -> ModelFileError:
        assert first is not None
        given = declaration.given
        second = given if isinstance(given, Token) else declaration.name
        node = f"{'transition' if declaration.kind == 'tr' else 'place'} {declaration.name.plain!r}"
        lines = f"on lines {self._text.line(first)} and {self._text.line(second)}"
        return self._text.error(second, f"{node} has two {what}, {lines}")

    def _arc(self, place: Token, transition: Token, arc: Arc, kind: str) -> None:
        if arc.kind.startswith("!"):
            raise self._text.error(
                arc.name, "stopwatch arcs cannot be represented", "use a read or an inhibitor arc"
            )
        if kind == ">" and arc.kind != "*":
            raise self._text.error(arc.name, "only a normal arc can lead from a transition to a place")
        weight = 1 if arc.weight is None else self._integer(arc.weight, 1)
        self._places.setdefault(place.plain, _Node(place))
        known = self._transitions.setdefault(transition.plain, _Node(transition)).takes
        key = (place.plain, kind)
        if key in known:
            # Arcs add up; of several conditions the strictest holds.
            weight = {"?": max, "?-": min}.get(kind, _add)(weight, known[key][0])
            self._in_range(weight, arc.name)
        known[key] = (weight, arc.name)

    def _interval(self, parts: list[Token]) -> tuple[float, float | None, bool, bool]:
        start, earliest, latest, end = parts
        low, low_open, high_open = self._bound(earliest), start.text == "]", end.text == "["
        if latest.text == "w":
            if not high_open:
                raise self._text.error(latest, "an unbounded interval ends with w[")
            return low, None, low_open, False
        high = self._bound(latest)
        exact_low, exact_high = fraction_of(low), fraction_of(high)
        if exact_high < exact_low or (exact_high == exact_low and (low_open or high_open)):
            shown = f"{start.text}{earliest.text},{latest.text}{end.text}"
            raise self._text.error(earliest, f"the interval {shown} is empty")
        return low, high, low_open, high_open

    def _bound(self, token: Token) -> float:
        text = token.text
        try:
            if text[-1] in FACTORS:
                return nearest(fraction_of(exact_number(text[:-1])) * FACTORS[text[-1]])
            return exact_number(text)
        except ValueError as error:
            raise self._text.error(token, f"the bound {text[:40]!r} is not understood: it {error}") from None

    def _integer(self, token: Token, least: int) -> int:
        text = token.text
        factor = FACTORS.get(text[-1], 1)
        try:
            value = read_integer(text if factor == 1 else text[:-1]) * factor
        except ValueError as error:
            raise self._text.error(token, f"{text[:40]!r} is too large") from error
        if value < least:
            raise self._text.error(token, f"a weight must be {least} or more, not {value}")
        return self._in_range(value, token)

    def _in_range(self, value: int, token: Token) -> int:
        if value >= 2**31:
            raise self._text.error(token, f"{value} is too large", "numbers have 32 bits")
        return value

    # Making the net ----------------------------------------------------------------------------------------

    def _net(self) -> pn.Net:
        identifiers = _Identifiers()
        ids = {name: identifiers(name) for name in (*self._places, *self._transitions)}
        title = self._name.plain if self._name else self._text.path.stem
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
        # Arcs are joined to nodes first: what is on no page yet is quicker to join.
        page.arcs.extend(self._arcs(places, transitions, identifiers))
        page.objects.extend([*places.values(), *transitions.values()])
        for higher, lower in self._priorities:
            first = transitions[self._known(higher, self._transitions).token.plain]
            first.overrides.append(transitions[self._known(lower, self._transitions).token.plain])
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
                role = _ROLES.get(kind, _NORMAL)
                suffix = "" if role is _NORMAL else f"-{role}"
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
        remember_at(element, self._text, token.at)
        return element

    def _known(self, token: Token, nodes: dict[str, _Node]) -> _Node:
        name = token.plain
        if name not in nodes:
            raise self._text.error(token, f"there is no {name!r}", near_matches(name, nodes))
        return nodes[name]


class _Identifiers:
    """Makes ids of names: without white space, each once."""

    def __init__(self) -> None:
        self._used: set[str] = set()
        self._next: defaultdict[str, int] = defaultdict(lambda: 2)

    def __call__(self, name: str) -> str:
        stem = _BLANK.sub("_", name) or "_"
        identifier = stem
        while identifier in self._used:
            identifier = f"{stem}_{self._next[stem]}"
            self._next[stem] += 1
        self._used.add(identifier)
        return identifier


def _label(name: str, node: _Node, identifier: str) -> str | None:
    return node.label or (name if name != identifier else None)


def _add(first: int, second: int) -> int:
    return first + second
