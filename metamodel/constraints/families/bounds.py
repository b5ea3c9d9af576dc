"""What the metamodel asks of every class: required features, ranges, text that files can hold, no loose ends.

An element that fails here is checked no further: the other constraints can rely on it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pyecore.ecore import EReference

from dineros.metamodel.base import EObject, features_of, remembered
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.constraints.wording import describe
from dineros.metamodel.files.schema import INTEGERS, NOT_XML, Feature, Kind, model_class

_TEXTS = frozenset({"EString"})


@remembered
def _required(cls: type[EObject]) -> list[Feature]:
    """Return the features that must have a value; ids have constraints of their own."""
    features = model_class(cls).features.values()
    return [each for each in features if not each.identifies and (each.mandatory or each.default is not None)]


@remembered
def _references(cls: type[EObject]) -> list[Feature]:
    """Return the references to other elements, not to parts or containers."""
    known = features_of(cls)
    led = {name for name, each in known.items() if isinstance(each, EReference) and not each.container}
    features = model_class(cls).features.values()
    return [each for each in features if each.name in led and each.kind is not Kind.CONTAINMENT]


@remembered
def _attributes(cls: type[EObject], types: frozenset[str]) -> list[str]:
    features = model_class(cls).features.values()
    return [each.name for each in features if getattr(each.type, "name", None) in types]


def _given(element: EObject, types: frozenset[str]) -> Iterator[tuple[str, Any]]:
    """Yield name and value of the attributes of some types that an element has a value for."""
    held = element.__dict__
    for name in _attributes(type(element), types):
        if (value := held.get(name)) is not None:
            yield name, value


@constraint("{it} has no {found}", fix="set its {found}")
def required_feature(element: EObject, index: Index) -> Outcome:
    """A feature that the metamodel requires has a value."""
    for feature in _required(type(element)):
        if not feature.mandatory and feature.name not in element.__dict__:
            continue
        value = getattr(element, feature.name)
        if not len(value) if feature.many else value is None or (value == "" and feature.mandatory):
            return feature.name
    return True


@constraint("{it} has a number out of range: {found}", fix="use one from -2147483648 to 2147483647")
def number_range(element: EObject, index: Index) -> Outcome:
    """A whole number fits into 32 bits, as Ecore's EInt."""
    wrong = (each for each in _given(element, INTEGERS) if not -(2**31) <= each[1] < 2**31)
    return next((f"{name} ({value.bit_length()} bits)" for name, value in wrong), True)


@constraint("{it} has characters in its {found} that no file can hold", fix="remove the control characters")
def text_is_writable(element: EObject, index: Index) -> Outcome:
    """A text holds no characters that XML 1.0 excludes."""
    return next((name for name, text in _given(element, _TEXTS) if NOT_XML.search(text)), True)


@constraint(
    "{it} refers to {found}, which is not in the model", fix="add it to the model, or end the reference"
)
def target_in_model(element: EObject, index: Index) -> Outcome:
    """What an element refers to is part of the same model."""
    members = index.members
    for feature in _references(type(element)):
        if feature.name in element.__dict__:
            held = getattr(element, feature.name)
            for target in held if feature.many else (held,):
                if target is not None and target not in members:
                    return f"{describe(target)} ({feature.name})"
    return True
