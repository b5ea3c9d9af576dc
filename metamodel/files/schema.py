"""The features of a model class in order, as readers and writers need them; looked up once per class."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto
from math import isfinite
from typing import Any

from pyecore.ecore import EEnum
from pyecore.ecore import EObject as AnyObject

from dineros.metamodel import pn, pnm, rtm, sym, trace
from dineros.metamodel.base import EnumLiteral, EObject, features_of, remembered
from dineros.metamodel.errors import near_matches
from dineros.metamodel.files.exact import ExactNumber, decimal_text, exact_number

PACKAGES: dict[str, Any] = {package.nsURI: package for package in (pn, sym, rtm, pnm, trace)}
"""The metamodels that files may use, by namespace."""

INTEGERS = frozenset({"EInt", "EIntegerObject"})
"""Names of the types of whole numbers."""

NOT_XML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")
"""Characters that XML 1.0 has no place for, not even escaped (Sect. 2.2, Char)."""

_INTEGER = re.compile(r"[+-]?[0-9]{1,20}")


class Kind(Enum):
    """How a feature is written in a file."""

    ATTRIBUTE = auto()
    CONTAINMENT = auto()
    REFERENCE = auto()
    NOT_STORED = auto()
    """Container, transient or derived: follows from the rest."""


@dataclass(frozen=True, slots=True)
class Feature:
    """A structural feature: how it is stored and what its values are."""

    name: str
    kind: Kind
    many: bool
    mandatory: bool
    """Its lower bound is 1."""
    required: bool
    """It is mandatory and has no default: an object without it is incomplete."""
    identifies: bool
    default: Any
    type: Any
    """The class of the objects it holds, or the Ecore data type of its values."""
    read: Callable[[str], object]
    write: Callable[[Any], str]


@dataclass(frozen=True, slots=True)
class ModelClass:
    """A model class with its features, inherited ones first, in the order of the metamodel."""

    python_class: type[EObject]
    prefix: str
    uri: str
    name: str
    abstract: bool
    features: dict[str, Feature]
    containments: tuple[Feature, ...]
    required: tuple[Feature, ...]
    identifier: str | None
    """The attribute that identifies its objects."""

    @property
    def qualified_name(self) -> str:
        """The name with the package, such as ``sym:Place``."""
        return f"{self.prefix}:{self.name}"


@remembered
def model_class(cls: type[EObject]) -> ModelClass:
    """Return the schema of a model class."""
    features = {name: _feature(feature) for name, feature in _in_order(cls).items()}
    package = cls.eClass.ePackage
    return ModelClass(
        python_class=cls,
        prefix=package.nsPrefix,
        uri=package.nsURI,
        name=cls.eClass.name,
        abstract=bool(cls.eClass.abstract),
        features=features,
        containments=tuple(each for each in features.values() if each.kind is Kind.CONTAINMENT),
        required=tuple(feature for feature in features.values() if feature.required),
        identifier=next((name for name, feature in features.items() if feature.identifies), None),
    )


def class_of(element: EObject) -> ModelClass:
    """Return the schema of the class of a model object."""
    return model_class(type(element))


def find_class(uri: str | None, name: str) -> ModelClass | str:
    """Return the class of this name in the package of this namespace, or a hint where there is none."""
    package = PACKAGES.get(uri or "")
    if package is None:
        return near_matches(uri or "", PACKAGES) or f"known are {', '.join(PACKAGES)}"
    found = package.eClassifiers.get(name)
    if isinstance(found, type):
        return model_class(found)
    classes = [known for known, value in package.eClassifiers.items() if isinstance(value, type)]
    return near_matches(name, classes) or f"classes of {package.nsPrefix} are {', '.join(sorted(classes))}"


def values_of(element: EObject, feature: Feature) -> list[EObject]:
    """Return what a containment or a reference of an object holds."""
    value = getattr(element, feature.name)
    if feature.many:
        return list(value)
    return [] if value is None else [value]


def parts_of(element: EObject) -> list[EObject]:
    """Return the objects that an object contains itself, in the order of the features."""
    touched = element.__dict__  # an unset feature would be filled just by looking at it
    containments = [feature for feature in class_of(element).containments if feature.name in touched]
    return [part for feature in containments for part in values_of(element, feature)]


def identity(element: EObject) -> str | None:
    """Return the value of the attribute that identifies an object, if its class has one."""
    identifier = class_of(element).identifier
    value: str | None = getattr(element, identifier) if identifier else None
    return value


def shortened(text: str) -> str:
    """Return a text in quotes for a message, its end left out where it is long."""
    return repr(text if len(text) <= 60 else text[:57] + "...")


def describe(element: EObject) -> str:
    """Return class and id for messages, such as ``sym:Place 'Ready'``."""
    name = identity(element)
    return class_of(element).qualified_name + (f" {shortened(name)}" if name else "")


def _in_order(cls: type[EObject]) -> dict[str, Any]:
    """Return the features of a class, those of supertypes first, each once."""
    known = features_of(cls)
    ordered: dict[str, Any] = {}

    def collect(eclass: Any) -> None:
        for parent in eclass.eSuperTypes:
            collect(parent)
        for feature in eclass.eStructuralFeatures:
            ordered.setdefault(feature.name, known[feature.name])

    collect(cls.eClass)
    return ordered


def _feature(feature: Any) -> Feature:
    etype = feature._eType
    read: Callable[[str], object] = str
    write: Callable[[Any], str] = str
    if feature.is_reference:
        kind = Kind.CONTAINMENT if feature.containment else Kind.REFERENCE
        if feature.eOpposite and feature.eOpposite.containment:
            kind = Kind.NOT_STORED
        etype = etype if isinstance(etype, type) else etype.python_class
        if etype.__name__ == "EObject":
            etype = AnyObject
    else:
        assert not feature.many, "attributes with several values are not supported"
        kind = Kind.ATTRIBUTE
        read, write = _conversions(etype)
    if feature.transient or feature.derived:
        kind = Kind.NOT_STORED
    default = None if feature.is_reference else feature.get_default_value()
    return Feature(
        name=feature.name,
        kind=kind,
        many=bool(feature.many),
        mandatory=feature.lower > 0,
        required=feature.lower > 0 and kind is not Kind.NOT_STORED and default is None,
        identifies=not feature.is_reference and bool(feature.iD),
        default=default,
        type=etype,
        read=read,
        write=write,
    )


def _conversions(etype: Any) -> tuple[Callable[[str], object], Callable[[Any], str]]:
    """Return how a text becomes a value (ValueError: the reason, and perhaps a hint) and a value a text."""
    if isinstance(etype, EEnum):
        return _literal_reader(etype), _literal_name
    if etype.name in INTEGERS:
        return read_integer, _integer_text
    if etype.name in ("EDouble", "EDoubleObject"):
        return _read_number, number_text
    if etype.name in ("EBoolean", "EBooleanObject"):
        return _read_boolean, lambda value: "true" if value else "false"
    assert etype.name == "EString", f"no file format has the type {etype.name}"
    return str, str


def _literal_reader(enumeration: Any) -> Callable[[str], object]:
    literals: dict[str, object] = {literal.name: literal for literal in enumeration.eLiterals}

    def read(text: str) -> object:
        try:
            return literals[text]
        except KeyError:
            raise ValueError(f"is one of {', '.join(literals)}", near_matches(text, literals)) from None

    return read


def _literal_name(value: EnumLiteral) -> str:
    return str(value.name)


def read_integer(text: str) -> int:
    """Return a whole number of 32 bits, the range of EInt.

    Raises
    ------
    ValueError
        The text is not such a number; the message says what is expected.
    """
    text = text.strip()
    if not _INTEGER.fullmatch(text):
        raise ValueError("takes a whole number")
    return _checked(int(text))


def _integer_text(value: int) -> str:
    return str(_checked(int(value)))


def _checked(value: int) -> int:
    if not -(2**31) <= value < 2**31:
        raise ValueError("takes a whole number of 32 bits")
    return value


def _read_number(text: str) -> float:
    if "/" in text:  # EMF has no such numbers
        raise ValueError("takes a number")
    return exact_number(text)


def number_text(value: float) -> str:
    """Return the shortest text of a number, without a fraction where it has none.

    Raises
    ------
    ValueError
        It is not finite, or is a quotient without a decimal text; the message says so.
    """
    if not isfinite(value):
        raise ValueError("takes a finite number")
    if isinstance(value, ExactNumber):
        text = decimal_text(value.fraction)
        if text is None:
            raise ValueError(f"takes a decimal number, and {value} has no end")
        return text
    if value.is_integer() and abs(value) < 1e15:
        return str(int(value))
    return repr(value)


def _read_boolean(text: str) -> bool:
    if text not in ("true", "false"):
        raise ValueError("is true or false")
    return text == "true"
