"""Deep copies of parts of a model."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from pyecore.ecore import EReference

from dineros.metamodel.base import EObject, features_of, remembered


@remembered
def _plan(eclass: type[EObject]) -> tuple[list[tuple[str, bool]], list[str], list[tuple[str, bool]]]:
    """Return the containments, attributes and plain references of a class, by (name, many)."""
    containments, attributes, references = [], [], []
    for name, feature in features_of(eclass).items():
        if not isinstance(feature, EReference):
            attributes.append(name)
        elif feature.containment:
            containments.append((name, feature.many))
        elif not feature.container and not feature.transient:
            references.append((name, feature.many))
    return sorted(containments), sorted(attributes), sorted(references)


def contents(element: EObject) -> list[EObject]:
    """Return the elements that an element contains directly, in model order."""
    found: list[EObject] = []
    held: dict[str, Any] = element.__dict__
    for name, many in _plan(type(element))[0]:
        if name not in held:  # never touched: empty
            continue
        value = getattr(element, name)
        if many:
            found.extend(value)
        elif value is not None:
            found.append(value)
    return found


def deep_copy(
    root: EObject,
    *,
    omit: Collection[EObject] = frozenset(),
    classes: Mapping[type[EObject], type[EObject]] | None = None,
) -> tuple[EObject, dict[EObject, EObject]]:
    """Copy an element with all its contents.

    References to copied elements lead to the copies, all others to their original targets.

    Parameters
    ----------
    root : model object
        The element to copy.
    omit : collection of model objects
        Contained elements to leave out, with all their contents; references to them are left out as well.
    classes : mapping, optional
        Classes whose objects become objects of another class (one with at least the same features).

    Returns
    -------
    tuple
        The copy, and a dictionary from each original to its copy.
    """
    changed = classes or {}
    images: dict[EObject, EObject] = {}
    stack = [root]
    while stack:
        original = stack.pop()
        held: dict[str, Any] = original.__dict__
        copied = changed.get(type(original), type(original))()
        for name in _plan(type(original))[1]:
            if name in held and original.eIsSet(name):
                setattr(copied, name, getattr(original, name))
        images[original] = copied
        stack.extend(child for child in reversed(contents(original)) if child not in omit)
    for original, copied in images.items():
        _fill(original, copied, images, omit)
    return images[root], images


def _fill(
    original: EObject, copied: EObject, images: dict[EObject, EObject], omit: Collection[EObject]
) -> None:
    containments, _, references = _plan(type(original))
    held: dict[str, Any] = original.__dict__
    for name, many in containments + references:
        if name not in held:
            continue
        value = getattr(original, name)
        if many:
            targets = [images.get(target, target) for target in value if target not in omit]
            getattr(copied, name).extend(targets)
        elif value is not None and value not in omit:
            setattr(copied, name, images.get(value, value))
