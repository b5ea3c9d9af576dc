"""What the metamodel says about a class, in the form that walking and bounds need."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pyecore.ecore import EAttribute, EReference

from dineros.metamodel.base import EObject, features_of

_INTEGERS = frozenset({"EInt", "EIntegerObject"})


@dataclass(frozen=True)
class Shape:
    """The features of a class, by what is asked of them.

    Attributes
    ----------
    containments : tuple
        References to parts.
    required : tuple
        Features that must have a value: a lower bound of 1 or more, or a default value. Ids have constraints
        of their own.
    references : tuple
        References to other elements, not to parts or containers.
    integers : tuple
        Attributes of 32 bits.
    texts : tuple
        Attributes that hold text.
    """

    containments: tuple[Any, ...]
    required: tuple[Any, ...]
    references: tuple[Any, ...]
    integers: tuple[Any, ...]
    texts: tuple[Any, ...]

    def children(self, element: EObject) -> list[EObject]:
        """Return the parts of an element, in the order of the features."""
        found: list[EObject] = []
        for feature in self.containments:
            if element.eIsSet(feature):  # an unset feature would be filled just by looking at it
                value = getattr(element, feature.name)
                if feature.many:
                    found.extend(value)
                elif value is not None:
                    found.append(value)
        return found

    def targets(self, element: EObject) -> list[tuple[str, EObject]]:
        """Return what an element refers to, with the names of the references."""
        found: list[tuple[str, EObject]] = []
        for feature in self.references:
            if element.eIsSet(feature):
                value = getattr(element, feature.name)
                if feature.many:
                    found.extend((feature.name, target) for target in value)
                elif value is not None:
                    found.append((feature.name, value))
        return found


def shape_of(element: EObject) -> Shape:
    """Return the shape of an element's class."""
    known = _SHAPES.get(type(element))
    if known is None:
        known = _SHAPES[type(element)] = _shape(type(element))
    return known


_SHAPES: dict[type, Shape] = {}


def _shape(cls: type[EObject]) -> Shape:
    inherited_first = list(reversed(cls.__mro__))
    features = sorted(
        features_of(cls).values(),
        key=lambda feature: inherited_first.index(feature.eContainingClass.python_class),
    )
    attributes = [feature for feature in features if isinstance(feature, EAttribute)]
    references = [feature for feature in features if isinstance(feature, EReference)]
    return Shape(
        containments=tuple(reference for reference in references if reference.containment),
        required=tuple(feature for feature in features if _is_required(feature)),
        references=tuple(
            reference for reference in references if not reference.containment and not reference.container
        ),
        integers=tuple(attribute for attribute in attributes if attribute._eType.name in _INTEGERS),
        texts=tuple(attribute for attribute in attributes if attribute._eType.name == "EString"),
    )


def _is_required(feature: Any) -> bool:
    if isinstance(feature, EAttribute):
        has_default = feature.get_default_value() is not None and not feature.many
        return not feature.iD and (feature.lower > 0 or has_default)
    return bool(feature.lower > 0)
