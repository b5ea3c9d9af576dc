"""What the metamodel asks of every class: required features, ranges, text that files can hold, no loose ends.

An element that fails here is checked no further: the other constraints can rely on it.
"""

from __future__ import annotations

import re

from dineros.metamodel.base import EObject
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.constraints.shape import shape_of
from dineros.metamodel.constraints.wording import describe

# Characters that XML 1.0 has no place for, not even escaped (Sect. 2.2, Char).
_NOT_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


@constraint("{it} has no {found}", fix="set its {found}")
def required_feature(element: EObject, index: Index) -> Outcome:
    """A feature that the metamodel requires has a value."""
    for feature in shape_of(element).required:
        if feature.lower == 0 and not element.eIsSet(feature):
            continue
        value = getattr(element, feature.name)
        if (
            len(value) < feature.lower
            if feature.many
            else value is None or (value == "" and feature.lower > 0)
        ):
            return str(feature.name)
    return True


@constraint("{it} has a number out of range: {found}", fix="use one from -2147483648 to 2147483647")
def number_range(element: EObject, index: Index) -> Outcome:
    """A whole number fits into 32 bits, as Ecore's EInt."""
    for feature in shape_of(element).integers:
        if element.eIsSet(feature):
            value = getattr(element, feature.name)
            if value is not None and not -(2**31) <= value < 2**31:
                return f"{feature.name} ({value.bit_length()} bits)"
    return True


@constraint("{it} has a {found} that no file can hold", fix="remove the control characters")
def text_is_writable(element: EObject, index: Index) -> Outcome:
    """A text holds no characters that XML 1.0 excludes."""
    for feature in shape_of(element).texts:
        if element.eIsSet(feature):
            value = getattr(element, feature.name)
            if value and _NOT_XML.search(value):
                return str(feature.name)
    return True


@constraint(
    "{it} refers to {found}, which is not in the model", fix="add it to the model, or end the reference"
)
def target_in_model(element: EObject, index: Index) -> Outcome:
    """What an element refers to is part of the same model."""
    for name, target in shape_of(element).targets(element):
        if target not in index.members:
            return f"{describe(target)} ({name})"
    return True
