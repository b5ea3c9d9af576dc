"""Commands as people, broken pages and forgers send them, drawn for the model at hand."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Any

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject, features_of
from dineros.metamodel.editing.composed.templates import TEMPLATES
from dineros.metamodel.editing.editor import Editor
from dineros.metamodel.editing.handles import subtree
from dineros.metamodel.editing.offered import classes_for
from dineros.metamodel.elements import label, node_net_of

NASTY: list[Any] = [
    None,
    "",
    " ",
    "\x00",
    "{",
    "e0",
    "e99999",
    "$p",
    -1,
    0,
    2**70,
    1e308,
    True,
    [],
    {},
    "a & ",
    "<x/>",
]


class Drawer:
    """Draws groups of commands as JSON values.

    Parameters
    ----------
    editor : Editor
        What they are for.
    random : Random
        Where choices come from.
    """

    def __init__(self, editor: Editor, random: Random) -> None:
        self.editor, self.random = editor, random

    def group(self, forged: float = 0.15) -> Any:
        """Return a group, some of them wrong."""
        parts = list(subtree(self.editor.root))
        found: Any = [self._one(parts) for _ in range(self.random.choice((1, 1, 1, 2, 3)))]
        if self.random.random() < forged:
            command = self.random.choice(found)
            key = self.random.choice(list(command))
            command[key if self.random.random() < 0.7 else "unknown"] = self.random.choice(NASTY)
        return self.random.choice((found, NASTY)) if self.random.random() < forged / 10 else found

    def operation(self) -> dict[str, Any]:
        """Return something composed of commands."""
        parts = list(subtree(self.editor.root))
        beside = [each for each in parts if isinstance(each, pn.PageObject)]
        page = self._any(parts, pn.Page)
        here = [each for each in beside if each.eContainer() is page] or beside or parts
        some = self.random.sample(here, min(len(here), self.random.choice((1, 2, 3, 9))))
        elements = [self._handle(each) for each in some]
        token = self._handle(self._any(parts, sym.BalloonToken))
        kinds: list[type[EObject]] = [pn.Page, pn.Net]
        target = self._handle(self._any(parts, self.random.choice(kinds)))
        return self.random.choice(
            [
                {"kind": "copy", "elements": elements, "owner": target, "dx": 10, "dy": -2.5},
                {
                    "kind": "copy",
                    "elements": [self._handle(self._any(parts))],
                    "owner": target,
                    "dx": 0,
                    "dy": 0,
                },
                {"kind": "into", "elements": elements, "page": target},
                {
                    "kind": "group",
                    "elements": elements,
                    "type": self.random.choice(["pn.Page", "sym.CallbackPage"]),
                },
                {"kind": "group", "elements": elements},
                {"kind": "split", "page": self._handle(page)},
                {
                    "kind": "join",
                    "source": self._handle(self._any(parts, pn.PlaceNode)),
                    "target": self._handle(self._any(parts, pn.TransitionNode)),
                    "x": 5,
                    "y": -5,
                },
                {"kind": "split", "page": self._handle(self._any(parts, sym.CallbackPage))},
                {
                    "kind": "fill",
                    "token": token,
                    "field": self.random.choice(["color", "a", "pose"]),
                    "text": self.random.choice(["red", "[1, 2]", "", None, "true"]),
                },
                {"kind": "insert", "template": self.random.choice(list(TEMPLATES)), "x": 5, "y": 5},
            ]
        )

    def _one(self, parts: list[EObject]) -> dict[str, Any]:
        makers: list[Callable[[list[EObject]], dict[str, Any]]] = [
            *(self._create,) * 4,
            *(self._arc,) * 3,
            *(self._set,) * 5,
            self._delete,
            self._place,
            self._list,
            *(self._move,) * 3,
            self._bend,
            *(self._clause,) * 2,
            self._rename,
        ]
        return self.random.choice(makers)(parts)

    def _handle(self, element: EObject) -> str:
        return self.editor.handles.of(element) or "e0"

    def _any(self, parts: list[EObject], kind: type[EObject] = pn.Element) -> EObject:
        fitting = [each for each in parts if isinstance(each, kind)]
        return self.random.choice(fitting or parts)

    def _create(self, parts: list[EObject]) -> dict[str, Any]:
        owner = self.random.choice(parts)
        features = [
            each for each in features_of(type(owner)).values() if each.is_reference and each.containment
        ]
        if not features:
            return self._move(parts)
        feature = self.random.choice(features)
        fitting = [
            (name, cls)
            for name, cls in classes_for(type(self.editor.root)).items()
            if issubclass(cls, getattr(feature._eType, "python_class", feature._eType))
        ]
        if not fitting:
            return self._move(parts)
        name, cls = self.random.choice(fitting)
        values: dict[str, Any] = {}
        for each in features_of(cls).values():
            if each.is_reference and each.lower > 0 and not each.many and not each.containment:
                values[each.name] = self._handle(
                    self._any(parts, getattr(each._eType, "python_class", each._eType))
                )
            elif not each.is_reference and not each.iD and (each.lower > 0 or self.random.random() < 0.2):
                values[each.name] = self._value(each)
        made = {
            "kind": "create",
            "owner": self._handle(owner),
            "feature": feature.name,
            "type": name,
            "values": values,
        }
        if self.random.random() < 0.3:
            made["index"] = self.random.randrange(3)
        return made

    def _arc(self, parts: list[EObject]) -> dict[str, Any]:
        ends = {
            "source": self._handle(self._any(parts, pn.Node)),
            "target": self._handle(self._any(parts, pn.Node)),
        }
        owner = self._handle(self._any(parts, pn.Page))
        return {"kind": "create", "owner": owner, "feature": "arcs", "type": "pn.Arc", "values": ends}

    def _value(self, feature: Any) -> Any:
        kind = feature._eType
        if hasattr(kind, "eLiterals"):
            return self.random.choice([str(each) for each in kind.eLiterals])
        if kind.name == "EBoolean":
            return self.random.random() < 0.5
        if kind.name == "EString":
            return self.random.choice(
                ("a", "b c", ' " & <', "é\n", "", "{}", None, "x" * 50, "geometry_msgs/msg/Pose")
            )
        return self.random.choice(
            (0, 1, 2, 7, -1, 2**31 - 1, *((0.5, 1e300) if "Double" in kind.name else ()), None)
        )

    def _set(self, parts: list[EObject]) -> dict[str, Any]:
        element = self.random.choice(parts)
        feature = self.random.choice(list(features_of(type(element)).values()))
        if feature.is_reference:
            target = self._any(parts, getattr(feature._eType, "python_class", feature._eType))
            value: Any = self.random.choice((self._handle(target), None))
        else:
            value = self._value(feature)
        return {"kind": "set", "element": self._handle(element), "feature": feature.name, "value": value}

    def _rename(self, parts: list[EObject]) -> dict[str, Any]:
        kinds: list[type[EObject]] = [pn.Element, sym.InputSignal, sym.TokenField]
        element = self._any(parts, self.random.choice(kinds))
        feature, value = self.random.choice(("name", "id")), f"r{self.random.randrange(100)}"
        return {"kind": "set", "element": self._handle(element), "feature": feature, "value": value}

    def _delete(self, parts: list[EObject]) -> dict[str, Any]:
        return {"kind": "delete", "elements": [self._handle(self.random.choice(parts))]}

    def _place(self, parts: list[EObject]) -> dict[str, Any]:
        element = self._any(parts)
        feature = element.eContainmentFeature()
        container = element.eContainer()
        owner = element if container is None else self._any(parts, type(container))
        name = feature.name if feature is not None else "pages"
        index = self.random.choice((None, 0, 1, 5))
        return {
            "kind": "place",
            "element": self._handle(element),
            "owner": self._handle(owner),
            "feature": name,
            "index": index,
        }

    def _list(self, parts: list[EObject]) -> dict[str, Any]:
        one, other = (self._handle(self._any(parts, pn.Transition)) for _ in range(2))
        kind = self.random.choice(("add", "remove"))
        return {"kind": kind, "element": one, "feature": "overrides", "target": other}

    def _move(self, parts: list[EObject]) -> dict[str, Any]:
        x, y = (self.random.randrange(-500, 500) / 4 for _ in range(2))
        return {"kind": "move", "element": self._handle(self._any(parts, pn.PageObject)), "x": x, "y": y}

    def _bend(self, parts: list[EObject]) -> dict[str, Any]:
        points = [[self.random.randrange(9), 1.5] for _ in range(self.random.randrange(3))]
        return {"kind": "bend", "element": self._handle(self._any(parts, pn.Arc)), "points": points}

    def _clause(self, parts: list[EObject]) -> dict[str, Any]:
        transition = self._any(parts, sym.Transition)
        node_net = node_net_of(transition)
        names = [label(each) for each in node_net.signals] if node_net is not None else []
        words = [f'"{name}"' for name in names] or ["true"]
        one, other = self.random.choice(words), self.random.choice(words)
        text = self.random.choice((f"{one} & !{other}", f"{one} -> {other}", f"!{one}", "false", "a &", None))
        return {"kind": "clause", "element": self._handle(transition), "text": text}
