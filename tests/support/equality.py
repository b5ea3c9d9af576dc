"""Structural comparison of two models over the features of their classes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from dineros.metamodel.base import EObject, features_of


def differences(first: EObject, second: EObject, ignore: frozenset[str] = frozenset()) -> list[str]:
    """Return what differs, one line each with the path of the object; equal models give an empty list.

    Containment is compared recursively and in order, attributes by value, other references by the
    path of their target inside its model (by id where the target stands in another one). Transient
    features and containers follow from the rest and are not compared; neither are the features named
    in `ignore`.
    """
    paths = (dict(_paths(first)), dict(_paths(second)))
    found: list[str] = []
    stack = [(first, second)]
    while stack:
        left, right = stack.pop()
        path = paths[0][left]
        if type(left) is not type(right):
            found.append(f"{path}: {_kind(left)} is not {_kind(right)}")
            continue
        for name, feature in features_of(type(left)).items():
            if name in ignore or feature.transient or _is_container(feature):
                continue
            values = _values(left, feature), _values(right, feature)
            if feature.is_reference and feature.containment:
                if len(values[0]) != len(values[1]):
                    found.append(f"{path}.{name}: {values[0]} is not {values[1]}")
                else:
                    stack.extend(reversed(list(zip(*values, strict=True))))
                continue
            shown = [
                [_name(value, own) if isinstance(value, EObject) else _text(value) for value in side]
                for side, own in zip(values, paths, strict=True)
            ]
            if shown[0] != shown[1]:
                found.append(f"{path}.{name}: {', '.join(shown[0])} is not {', '.join(shown[1])}")
    return found


def _paths(root: EObject) -> Iterator[tuple[EObject, str]]:
    """Yield every object of a model with its path such as ``pages.0/objects.2``."""
    stack = [(root, "")]
    while stack:
        element, path = stack.pop()
        yield element, path or "/"
        for name, feature in features_of(type(element)).items():
            if feature.is_reference and feature.containment:
                for index, child in enumerate(_values(element, feature)):
                    stack.append((child, f"{path}/{name}.{index}"))


def _values(element: EObject, feature: Any) -> list[Any]:
    value = getattr(element, feature.name)
    if feature.many:
        return list(value)
    return [] if value is None else [value]


def _is_container(feature: Any) -> bool:
    return bool(feature.is_reference and feature.eOpposite and feature.eOpposite.containment)


def _text(value: object) -> str:
    return repr(value) if isinstance(value, (str, int, float, bool)) else str(value)


def _name(element: EObject, own: dict[EObject, str]) -> str:
    return own.get(element) or f"elsewhere:{getattr(element, 'id', None)}"


def _kind(element: EObject) -> str:
    return f"{element.eClass.ePackage.nsPrefix}.{element.eClass.name}"
