"""The contents of a rule's picture: shapes, lines and boxes of both sides, before layout."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from typing import Literal, TypeAlias

from pyecore.ecore import EReference

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject, features_of
from dineros.transformations.language.creation import Copy, ForAll, Fragment, Image, Member, New
from dineros.transformations.language.expressions import Constant, Expression, Path, Variable, python_class
from dineros.transformations.language.functions import Ancestor
from dineros.transformations.language.patterns import Absent, Index, Made, Node
from dineros.transformations.language.rule import Rule
from dineros.transformations.pictures.describing import maker_of, value_text
from dineros.transformations.pictures.shapes import Box, Line, LineKind, Shape, Status

StatusOf: TypeAlias = "Callable[[Variable], Status]"

_KINDS: dict[str, LineKind] = {"read": "read", "inhibitor": "inhibitor"}
_DIRECTIONS: dict[type[EObject], dict[str, Literal["in", "out"]]] = {
    sym.PublisherPort: {"place": "in", "channel": "in"},
    sym.SubscriberPort: {"place": "out", "channel": "out"},
    sym.ClientPort: {"request": "in", "response": "out", "channel": "in"},
    sym.ServerPort: {"entry": "out", "exit": "in", "channel": "out"},
    sym.ActionClientPort: {
        **dict.fromkeys(("goal", "cancel", "channel"), "in"),
        **dict.fromkeys(("succeeded", "aborted", "canceled", "rejected", "accepted", "feedback"), "out"),
    },
    sym.ActionServerPort: {
        **dict.fromkeys(("entry", "cancel", "channel"), "out"),
        **dict.fromkeys(("succeeded", "aborted", "canceled", "feedback"), "in"),
    },
}
"""Whether tokens enter or leave a port by a feature."""


class Side:
    """One side of a rule.

    `left`: whether it is the left-hand side.
    """

    def __init__(self, rule: type[Rule], left: bool) -> None:
        self.shapes: dict[str, Shape] = {}
        self.lines: list[Line] = []
        self.boxes: dict[str, Box] = {}
        """`shapes`, `lines`, `boxes`: the contents to draw; shapes and boxes by key."""
        self.notes: list[str] = []
        """Text below the picture: numbers, conditions, abbreviations."""
        self._short: dict[str, str] = {}
        if left:
            self._match(
                rule.lhs,
                lambda node: "deleted" if any(node is other for other in rule.deleted) else "kept",
                None,
            )
            self.notes.extend(str(condition) for condition in rule.where)
            for pattern in rule.absent:
                self._forbid(pattern)
            self._use_members(rule)
        else:
            kept = [item for item in rule.rhs if isinstance(item, (Node, Made))]
            self._match(kept, lambda _: "kept", None)
            self._make(rule.rhs)
        for item in rule.rhs:
            if isinstance(item, Copy):
                self._prototype(item.original)
        self.notes.extend(f"{short} = {text}" for text, short in self._short.items())

    # Matched elements

    def _match(self, nodes: Sequence[Variable], status: StatusOf, box: str | None) -> None:
        for node in nodes:  # boxes first, so that their contents find them
            if isinstance(node, Index):
                self.notes.append(f"{node} = 1 … {node._upto}")
            elif isinstance(node, Made) and node._fragment is not None:
                self.boxes[_key(node)] = Box(
                    _key(node), f"{node}: {maker_of(node)}", "group", status(node), box
                )
        for node in nodes:
            if isinstance(node, Node) and isinstance(node._of, Ancestor):
                self._page_around(node, nodes, status(node), box)
            elif isinstance(node, Node) and isinstance(node._of, Image):
                self._page(node._of.copy, status(node), box)
        for node in nodes:
            if isinstance(node, (Node, Made)) and node.eclass is not None and not _is_arc(node):
                self._element(node, status(node), box)
        for node in nodes:
            if isinstance(node, Node):
                self._links(node, status(node), box)

    def _element(self, node: Node | Made, status: Status, box: str | None) -> None:
        assert node.eclass is not None
        if _key(node) in self.boxes:
            return
        shape = self._shape(node, status, box)
        if isinstance(node, Made):
            shape.notes.append(maker_of(node))
        elif isinstance(node._of, Image):
            shape.box = _key(node._of.copy)
        if isinstance(node, Node):
            for name, value in node._features.items():
                if not isinstance(value, Variable) and not _is_arc(node):
                    shape.notes.append(f"{name} = {value_text(value)}")

    def _page_around(self, page: Node, nodes: Sequence[Variable], status: Status, box: str | None) -> None:
        """Draw a page as a box around the place, or the page, from which it was found."""
        assert isinstance(page._of, Ancestor)
        inner = page._of.base
        self.boxes[_key(page)] = Box(_key(page), _title(page), "page", status, box)
        for node in nodes:
            if isinstance(node, Node) and node._of is not None and str(node._of) == str(inner):
                self._shape(node, "kept", _key(page))
                return
        shape = self._shape(inner, status, _key(page))
        if not isinstance(inner, Variable):
            shape.name = _steps(inner)[1].split(".")[0]

    def _page(self, page: Variable, status: Status, box: str | None) -> None:
        if _key(page) not in self.boxes:
            note = f", {maker_of(page)}" if isinstance(page, Made) else ""
            self.boxes[_key(page)] = Box(_key(page), f"{_title(page)}{note}", "page", status, box)

    def _prototype(self, page: Expression) -> None:
        """Draw the page from which a copy is made, with the places of its port on it."""
        start, _ = _steps(page)
        if not isinstance(start, Variable) or _key(start) not in self.shapes:
            return
        self.boxes[_key(page)] = Box(_key(page), f"«page» {page}", "page", "kept")
        for name, key in self._inside(page, start, "kept").items():
            source, target = (key, _key(start)) if name == "exit" else (_key(start), key)
            self.lines.append(Line(source, target, "link" if name == "…" else "flow", "kept"))

    def _links(self, node: Node, status: Status, box: str | None) -> None:
        if _is_arc(node):
            self._matched_arc(node, status, box)
            return
        for name, value in node._features.items():
            if isinstance(value, Variable) and value.eclass is not None:
                label = "" if name == "channel" else name
                self._link(value, node, name, node.eclass, status, label)
        if isinstance(node._of, Ancestor):
            start, features = _steps(node._of.base)
            if features:
                self._line(start, node._of.base, "flow", status)
        if node._of is None or isinstance(node._of, (Ancestor, Image)):
            return
        start, features = _steps(node._of)
        if isinstance(start, Variable):
            names = features.split(".")
            label = features if len(names) < 3 else f"{names[0]} … {names[-1]}"
            self._link(start, node, names[0], start.eclass, status, label)
        else:
            self.notes.append(f"{node} of {node._of}")

    def _link(
        self,
        start: Expression,
        end: Expression,
        feature: str,
        port: type[EObject] | None,
        status: Status,
        label: str,
    ) -> None:
        direction = _direction(port, feature)
        if direction == "in":
            start, end = end, start
        elif not direction:
            self._line(start, end, "link", status, label)
            return
        self._line(start, end, "flow", status, "" if feature == "place" else label)

    def _matched_arc(self, node: Node, status: Status, box: str | None) -> None:
        ends = [
            node._features[end] if end in node._features else Path(node, end) for end in ("source", "target")
        ]
        for end, opposite in zip(ends, reversed(ends), strict=True):
            if isinstance(end, Path):
                self._end(end, opposite, status, box)
        self._line(ends[0], ends[1], "normal", status, str(node))

    def _forbid(self, pattern: Absent) -> None:
        key = f"absent {len(self.boxes)}"
        self.boxes[key] = Box(key, "there is no", "absent", "matched")
        self._match(pattern.nodes, lambda _: "matched", key)
        self.notes.extend(f"there is no: {condition}" for condition in pattern.where)

    def _use_members(self, rule: type[Rule]) -> None:
        """Draw the members of looked-up groups at which arcs of the right-hand side end."""
        for item in _made_by(rule.rhs):
            if isinstance(item, New):
                for value in item.features.values():
                    if isinstance(value, Member):
                        self._shape(value, "kept", None)

    # Made elements

    def _make(self, items: Sequence[Variable | ForAll], box: str | None = None) -> None:
        groups = self._groups(items, box)
        for item in items:
            if isinstance(item, New) and not issubclass(item.eclass or EObject, pn.Arc):
                shape = self._shape(item, "created", groups.get(item.symbol.partition(".")[0], box))
                shape.inside = self._tokens(item.features.get("tokens"))
                for name, value in item.features.items():
                    if isinstance(value, Variable) and _direction(item.eclass, name):
                        self._link(value, item, name, item.eclass, "created", "")
                into = item.into
                if into is not None and isinstance(_steps(into)[0], Variable):
                    start, features = _steps(into)
                    self._line(start, item, "link", "created", features)
            elif isinstance(item, Copy):
                self._copy(item, box)
        for item in items:
            if isinstance(item, New) and issubclass(item.eclass or EObject, pn.Arc):
                self._made_arc(item, groups.get(item.symbol.partition(".")[0], box))
            elif isinstance(item, ForAll):
                self._for_all(item, box)

    def _groups(self, items: Sequence[Variable | ForAll], box: str | None) -> dict[str, str]:
        found: dict[str, str] = {}
        for item in items:
            name, point, _ = item.symbol.partition(".") if isinstance(item, New) else ("", "", "")
            if point and name not in found:
                assert isinstance(item, New)
                group: Fragment = getattr(item.rule, name)
                title = f"{name}: {type(group).__name__}"
                found[name] = f"group {name}"
                self.boxes[found[name]] = Box(found[name], title, "group", "created", box)
        return found

    def _copy(self, item: Copy, box: str | None) -> None:
        title = f"{_title(item)}: copy of {item.original}"
        self.boxes[_key(item)] = Box(_key(item), title, "page", "created", box)
        self._inside(item, _steps(item.original)[0], "created")

    def _inside(self, page: Expression, port: Expression, status: Status) -> dict[str, str]:
        """Draw the places of a page that a port names, or placeholder ones; return their keys by name."""
        keys = {name: f"{_key(page)}.{name}" for name in _places_of(port.eclass) or ["…"]}
        for name, key in keys.items():
            self.shapes[key] = Shape(key, EObject if name == "…" else pn.Place, name, status, _key(page))
        return keys

    def _made_arc(self, item: New, box: str | None) -> None:
        source, target = item.features["source"], item.features["target"]
        kind = item.features.get("kind")
        weight = self._tokens(item.features.get("weight"))
        for end, opposite in ((source, target), (target, source)):
            if _key(end) not in self.shapes:
                self._end(end, opposite, "matched" if box else "kept", box)
        shown = _KINDS.get(str(kind), "normal")
        self._line(source, target, shown, "created", "" if weight == "●" else weight)

    def _for_all(self, item: ForAll, outer: str | None) -> None:
        key = f"for all {len(self.boxes)}"
        names = ", ".join(map(str, item.nodes))
        where = f", {' and '.join(map(str, item.where))}" if item.where else ""
        self.boxes[key] = Box(key, f"for all {names}{where}", "for-all", "matched", outer)
        self._match(item.nodes, lambda _: "matched", key)
        self._make(item.make, key)

    # Shapes and lines

    def _end(self, end: Expression, opposite: Expression, status: Status, box: str | None) -> None:
        """Draw the end of an arc; the other end decides whether a `pn.Node` is a place."""
        shape = self._shape(end, status, box)
        if shape.eclass is pn.Node:
            shape.eclass = pn.Place
            if issubclass(opposite.eclass or EObject, pn.PlaceNode):
                shape.eclass = pn.Transition

    def _shape(self, value: Expression, status: Status, box: str | None) -> Shape:
        key = _key(value)
        if key not in self.shapes:
            name = key
            if isinstance(value, Member):
                box, name = _key(value._group), value._role
                status = self.boxes[box].status
            elif isinstance(value, New):
                name = key.rpartition(".")[2]
            self.shapes[key] = Shape(key, value.eclass or EObject, name, status, box)
        return self.shapes[key]

    def _line(
        self, source: Expression, target: Expression, kind: LineKind, status: Status, label: str = ""
    ) -> None:
        if _key(source) in self.shapes and _key(target) in self.shapes:
            self.lines.append(Line(_key(source), _key(target), kind, status, label))

    def _tokens(self, value: Expression | None) -> str:
        """Return the text for a number of tokens; a long expression is abbreviated, with a note."""
        if value is None or (isinstance(value, Constant) and value.value == 0):
            return ""
        if isinstance(value, Constant):
            return "●" if value.value == 1 else str(value)
        text = str(value)
        if text not in self._short:
            letters = re.findall(r"\.([a-z])\w*", text) or ["n"]
            taken = list(self._short.values())
            self._short[text] = next(
                f"{letters[-1]}{prime}"
                for prime in ("", "′", "″", "‴")
                if f"{letters[-1]}{prime}" not in taken
            )
        return self._short[text]


def _key(value: Expression) -> str:
    if isinstance(value, New) and not value.symbol:
        return str(value.features.get("id"))
    return str(value)


def _steps(value: Expression) -> tuple[Expression, str]:
    """Split `port.place` into the variable and the features."""
    features: list[str] = []
    while isinstance(value, Path):
        features.append(value._feature)
        value = value._base
    return value, ".".join(reversed(features))


def _title(page: Variable) -> str:
    kind = "node net" if page.eclass is not None and issubclass(page.eclass, sym.NodeNet) else "page"
    return f"«{kind}» {page}"


def _is_arc(node: Variable) -> bool:
    return node.eclass is not None and issubclass(node.eclass, pn.Arc)


def _places_of(eclass: type[EObject] | None) -> list[str]:
    """Return the features of a port that refer to a place."""
    if eclass is None:
        return []
    return [
        name
        for name, feature in features_of(eclass).items()
        if isinstance(feature, EReference) and not feature.many and python_class(feature._eType) is pn.Place
    ]


def _direction(port: type[EObject] | None, feature: str) -> Literal["in", "out"] | None:
    return _DIRECTIONS.get(port, {}).get(feature) if port is not None else None


def _made_by(items: Sequence[Variable | ForAll]) -> Iterator[Variable]:
    """Yield the elements that a right-hand side makes, including those of for-alls."""
    for item in items:
        if isinstance(item, ForAll):
            yield from item.created()
        else:
            yield item
