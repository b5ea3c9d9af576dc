"""Describes the metamodels for pages, which offer tools and forms: all data comes from the .ecore files."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from typing import Any

from lxml import etree
from pyecore.ecore import EAttribute, EEnum

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject, features_of
from dineros.metamodel.calls import OUTCOMES
from dineros.metamodel.constraints import all_constraints
from dineros.metamodel.constraints.wording import words_for
from dineros.metamodel.editing.composed.templates import TEMPLATES
from dineros.metamodel.editing.offered import NOT_WITHIN, ONLY_UNDER, classes_for, name_of
from dineros.metamodel.files.schema import Kind, model_class
from dineros.metamodel.files.xml import parse_bytes

_TYPES = {
    "EString": "text",
    "EInt": "integer",
    "EIntegerObject": "integer",
    "EDouble": "number",
    "EDoubleObject": "number",
    "EBoolean": "boolean",
}
_KINDS = {Kind.ATTRIBUTE: "attribute", Kind.CONTAINMENT: "part", Kind.REFERENCE: "reference"}
_SHAPES: dict[type[EObject], str] = {
    pn.Place: "place",
    pn.Transition: "transition",
    pn.ReferencePlace: "place-reference",
    pn.ReferenceTransition: "transition-reference",
    sym.NodeNet: "node",
    sym.CallbackPage: "callback",
    pn.Page: "page",
    sym.TopicChannel: "topic",
    sym.ServiceChannel: "service",
    sym.ActionChannel: "action",
}
"""Classes of elements on sheets, with their role; a class precedes those that it extends."""

_LINES: dict[type[EObject], list[tuple[str, str, str]]] = {
    pn.Arc: [("source", "target", "arc")],
    pn.ReferencePlace: [("target", "self", "reference")],
    pn.ReferenceTransition: [("target", "self", "reference")],
    sym.PublisherPort: [("place", "in", "publish")],
    sym.SubscriberPort: [("in", "place", "subscribe")],
    sym.Dispatcher: [("in", "node", "subscribe")],
    sym.ClientPort: [("request", "in", "request"), ("in", "response", "response")],
    sym.ServerPort: [("in", "entry", "call"), ("exit", "in", "return")],
    sym.ActionClientPort: [
        ("goal", "in", "request"),
        ("cancel", "in", "request"),
        *(("in", each, "response") for each in (*OUTCOMES, "rejected", "accepted", "feedback")),
    ],
    sym.ActionServerPort: [
        ("in", "entry", "call"),
        ("in", "cancel", "call"),
        *((each, "in", "return") for each in ("succeeded", "aborted", "canceled", "feedback")),
    ],
}
"""Which references are drawn as lines: from, to and kind; ``self`` is the object, ``in`` its container."""

_DOCUMENTATION = "eAnnotations/details[@key='documentation']"


def description_for(root: pn.Net) -> dict[str, Any]:
    """Return the classes of a model, as JSON values.

    Returns
    -------
    dict
        ``classes``: by name, with ``words``, ``says``, ``supers``, ``made`` (whether one can be made),
        ``rules`` (constraints about it), ``features`` (each with name, text, kind, type, bounds and default),
        the ``shape`` and ``lines`` that it is drawn as, and where it is offered: ``notWithin`` objects of
        another class, only ``under`` a middleware;
        ``enumerations``: by name, their literals with their texts;
        ``templates``: what the model can begin with, each with its name and text.
    """
    made = classes_for(type(root))
    classes: dict[str, Any] = {}
    enumerations: dict[str, Any] = {}
    for cls in (type(root), *made.values()):
        for each in (cls, *_supers(cls)):
            classes.setdefault(name_of(each), _class(each, enumerations))
    for name in made:
        classes[name]["made"] = True
    templates = TEMPLATES.items() if isinstance(root, sym.SystemModel) else ()
    return {
        "classes": classes,
        "enumerations": enumerations,
        "templates": [{"name": name, "says": make.__doc__ or ""} for name, make in templates],
    }


def _supers(cls: type[EObject]) -> list[type[EObject]]:
    return [
        each for each in cls.__mro__[1:] if hasattr(each, "eClass") and each.__module__.startswith("dineros.")
    ]


def _class(cls: type[EObject], enumerations: dict[str, Any]) -> dict[str, Any]:
    information = model_class(cls)
    features = []
    for name, stored in information.features.items():
        if stored.kind is Kind.NOT_STORED:
            continue
        feature = features_of(cls)[name]
        said: dict[str, Any] = {
            "name": name,
            "says": _said(feature.eContainingClass, name),
            "kind": _KINDS[stored.kind],
            "type": _type(feature, stored.type, enumerations),
        }
        if stored.many:
            said["many"] = True
        if stored.required:
            said["required"] = True
        if stored.default is not None:
            plain = isinstance(stored.default, str | int | float | bool)
            said["default"] = stored.default if plain else str(stored.default)
        features.append(said)
    shape = next((shape for each, shape in _SHAPES.items() if issubclass(cls, each)), None)
    lines = [line for each, found in _LINES.items() if issubclass(cls, each) for line in found]
    drawn = {"shape": shape} if shape else {}
    limits = {"notWithin": name_of(NOT_WITHIN[cls])} if cls in NOT_WITHIN else {}
    if cls in ONLY_UNDER:
        limits["under"] = str(ONLY_UNDER[cls])
    return {
        **drawn,
        **limits,
        **(
            {"lines": [{"from": begin, "to": end, "kind": kind} for begin, end, kind in lines]}
            if lines
            else {}
        ),
        "words": words_for(cls),
        "says": _said(cls.eClass, None),
        "supers": [name_of(each) for each in _supers(cls)],
        "made": False,
        "rules": [each.says for each in all_constraints() if each.about is cls],
        "features": features,
    }


def _type(feature: Any, target: Any, enumerations: dict[str, Any]) -> str:
    kind = feature._eType
    if not isinstance(feature, EAttribute):
        return name_of(target)
    if not isinstance(kind, EEnum):
        return _TYPES[kind.name]
    name = f"{kind.ePackage.nsPrefix}.{kind.name}"
    if name not in enumerations:
        enumerations[name] = [
            {
                "name": str(each.name),
                "says": _texts(kind.ePackage.nsPrefix).get(f"{kind.name}/{each.name}", ""),
            }
            for each in kind.eLiterals
        ]
    return name


def _said(eclass: Any, feature: str | None) -> str:
    key = eclass.name if feature is None else f"{eclass.name}/{feature}"
    return _texts(eclass.ePackage.nsPrefix).get(key, "")


@cache
def _texts(package: str) -> dict[str, str]:
    """Return the documentation of a package's classes, enumerations, features and literals."""
    file = files("dineros.metamodel") / f"{package}.ecore"
    found: dict[str, str] = {}
    for each in parse_bytes(file.read_bytes(), file.name).getroot().iterchildren("eClassifiers"):
        name = each.get("name", "")
        found[name] = _text(each)
        for inner in (*each.iterchildren("eStructuralFeatures"), *each.iterchildren("eLiterals")):
            found[f"{name}/{inner.get('name')}"] = _text(inner)
    return found


def _text(element: etree._Element) -> str:
    details = element.find(_DOCUMENTATION)
    return "" if details is None else str(details.get("value", ""))
