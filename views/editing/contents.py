"""Describes a model for pages: its objects by handle, with the marks of constraints."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from dineros.metamodel import pn
from dineros.metamodel.base import EObject
from dineros.metamodel.constraints import Violation
from dineros.metamodel.constraints.wording import describe
from dineros.metamodel.editing import Document
from dineros.metamodel.editing.commands import encode_command
from dineros.metamodel.editing.handles import subtree
from dineros.metamodel.editing.offered import follows_from_text, name_of
from dineros.metamodel.editing.violation_fixes import fix_of
from dineros.metamodel.elements import is_within
from dineros.metamodel.files.schema import Feature, Kind, class_of

MOST_MARKS = 500
"""Limit of the marks that pages get; others are only counted."""


def model_json(document: Document) -> dict[str, Any]:
    """Return the root's handle and all objects, by handle."""
    objects = {
        _handle(document, element): object_json(document, element)
        for element in subtree(document.root)
        if not follows_from_text(element)
    }
    return {"root": _handle(document, document.root), "objects": objects}


def changed_json(document: Document, touched: Iterable[EObject]) -> dict[str, Any]:
    """Return the current objects by handle; None for those that were removed with their content."""
    found: dict[str, Any] = {}
    for element in touched:
        if is_within(element, document.root):
            # An element restored by undo has its parts again.
            for part in subtree(element):
                if not follows_from_text(part):
                    found[_handle(document, part)] = object_json(document, part)
        else:
            for part in subtree(element):
                if not follows_from_text(part):
                    found.setdefault(_handle(document, part), None)
    return found


def object_json(document: Document, element: EObject) -> dict[str, Any]:
    """Return one object.

    Returns
    -------
    dict
        ``type``: its class; ``in`` and ``as``: its container and the feature there; ``values``: attributes
        that are not as by default; ``links``: parts and references, by feature: a handle or a list of them.
        An element of another file is an object with ``elsewhere`` and its id.
    """
    found: dict[str, Any] = {"type": name_of(type(element))}
    owner = element.eContainer()
    if owner is not None:
        found["in"] = _handle(document, owner)
        found["as"] = element.eContainmentFeature().name
    values: dict[str, Any] = {}
    links: dict[str, Any] = {}
    for name, feature in class_of(element).features.items():
        if feature.kind is Kind.ATTRIBUTE:
            value = getattr(element, name)
            if value is not None and value != feature.default:
                values[name] = value if isinstance(value, str | int | float | bool) else str(value)
        elif feature.kind is not Kind.NOT_STORED and element.eIsSet(name):
            _link(document, element, feature, links)
    if values:
        found["values"] = values
    if links:
        found["links"] = links
    return found


def _link(document: Document, element: EObject, feature: Feature, links: dict[str, Any]) -> None:
    value = getattr(element, feature.name)
    if feature.many:
        targets = [_target(document, each) for each in value if not follows_from_text(each)]
        if targets:
            links[feature.name] = targets
    elif value is not None:
        links[feature.name] = _target(document, value)


def _target(document: Document, element: EObject) -> Any:
    handle = document.handles.of(element)
    return {"elsewhere": getattr(element, "id", None)} if handle is None else handle


def _handle(document: Document, element: EObject) -> str:
    handle = document.handles.of(element)
    assert handle is not None, "every object of the model has one"
    return handle


def _fix(violation: Violation, document: Document) -> dict[str, Any]:
    found = fix_of(violation, document.handles)
    if found is None:
        return {}
    commands = [encode_command(each) for each in found.commands]
    return {"fixedBy": {"label": found.label, "commands": commands}}


def marks_json(document: Document, violations: list[Violation]) -> dict[str, Any]:
    """Return the violations of constraints, each at its element and at the nearest one with an id.

    Returns
    -------
    dict
        ``errors`` and ``warnings``: how many; ``marks``: the first of them, with the commands that fix
        them where there are some (``fixedBy``).
    """
    marks = []
    for violation in violations[:MOST_MARKS]:
        holder: EObject | None = violation.element
        while holder is not None and not isinstance(holder, pn.Element):
            holder = holder.eContainer()
        element = document.handles.of(violation.element)
        marks.append(
            {
                "element": element,
                "at": document.handles.of(holder) if holder is not None else element,
                "what": describe(violation.element),
                "constraint": violation.constraint,
                "severity": violation.severity,
                "message": violation.message,
                "fix": violation.fix,
                **_fix(violation, document),
            }
        )
    errors = sum(violation.severity == "error" for violation in violations)
    return {"errors": errors, "warnings": len(violations) - errors, "marks": marks}
