"""Petri net model (PNM): the flattened net that is analysed (paper, Sect. 5.5).

Generated from `pnm.ecore` by `make regenerate`; edits are lost.
"""

from __future__ import annotations

import sys
from functools import partial
from typing import Any, ClassVar

import pyecore.ecore as Ecore

from dineros.metamodel import pn
from dineros.metamodel.base import (
    Choice,
    EnumLiteral,
    EObject,
    Mandatory,
    MetaEClass,
    ModelList,
    complete,
    enumeration,
    reference,
)

name = "pnm"
nsURI = "http://dineros.org/pnm/1.0"
nsPrefix = "pnm"

eClass = Ecore.EPackage(name=name, nsURI=nsURI, nsPrefix=nsPrefix)
eClassifiers: dict[str, Any] = {}
getEClassifier = partial(Ecore.getEClassifier, searchspace=eClassifiers)
eSubpackages: list[Any] = []
eSuperPackage = None


@enumeration
class SignalVariant(EnumLiteral):
    """How signals may change (rules I1 to I6)."""

    none: ClassVar[SignalVariant]
    """Clauses and signals are dropped."""
    fullyEnabled: ClassVar[SignalVariant]
    """At any time."""
    inputEnabled: ClassVar[SignalVariant]
    """While the inputs of a transition that uses them are marked."""
    ioEnabled: ClassVar[SignalVariant]
    """As inputEnabled, or while its outputs are marked."""


@enumeration
class OverflowVariant(EnumLiteral):
    """How a full queue drops (rules T5a and T5b)."""

    weighted: ClassVar[OverflowVariant]
    """Ordinary arcs on Load (T5b)."""
    inhibitor: ClassVar[OverflowVariant]
    """Inhibitor arc on Capacity (T5a)."""


class PlaceInvariant(EObject, metaclass=MetaEClass):
    """Weighted sum of tokens that no firing changes."""

    name: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """What it says."""
    value: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=0)
    """The sum."""
    terms: ModelList[InvariantTerm] = reference(
        "InvariantTerm", containment=True, lower=1, required=True, upper=-1
    )
    """Places and their weights."""


class InvariantTerm(EObject, metaclass=MetaEClass):
    """A place of an invariant."""

    place: Mandatory[pn.Place] = reference("pn.Place", lower=1, required=True)
    """The place."""
    weight: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=1)
    """Its weight."""


class PetriNetModel(pn.Net):
    """A plain net without references and nested pages."""

    systemModel: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Id of the system model it was made from."""
    signals: Choice[SignalVariant] = Ecore.EAttribute(
        eType=SignalVariant, default_value=SignalVariant.inputEnabled
    )
    """Signal rules used."""
    overflow: Choice[OverflowVariant] = Ecore.EAttribute(
        eType=OverflowVariant, default_value=OverflowVariant.weighted
    )
    """Overflow rule used."""
    certificate: ModelList[PlaceInvariant] = reference("PlaceInvariant", containment=True, upper=-1)
    """Place invariants that the rules guarantee."""


class Sheet(pn.Page):
    """The page on which the rules put what they make."""


complete(sys.modules[__name__])
