"""Petri net model (PNM): the flattened net that is analysed (paper, Sect. 5.5).

Generated from `pnm.ecore` by `make regenerate`; edits are lost.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from functools import partial
from typing import Any, ClassVar, Never

import pyecore.ecore as Ecore

from dineros.metamodel import pn
from dineros.metamodel.base import (
    EnumLiteral,
    EObject,
    MetaEClass,
    ModelList,
    complete,
    enumeration,
    initialise,
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

__all__ = [
    "InvariantTerm",
    "OverflowVariant",
    "PetriNetModel",
    "PlaceInvariant",
    "Sheet",
    "SignalVariant",
]


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

    def __init__(
        self,
        *,
        name: str | None = None,
        value: int | None = None,
        terms: Iterable[InvariantTerm] | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class InvariantTerm(EObject, metaclass=MetaEClass):
    """A place of an invariant."""

    place: pn.Place = reference("pn.Place", lower=1, required=True)
    """The place."""
    weight: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=1)
    """Its weight."""

    def __init__(self, *, place: pn.Place | None = None, weight: int | None = None, **unknown: Never) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class PetriNetModel(pn.Net):
    """A plain net without references and nested pages."""

    systemModel: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Id of the system model it was made from."""
    signals: SignalVariant = Ecore.EAttribute(eType=SignalVariant, default_value=SignalVariant.inputEnabled)
    """Signal rules used."""
    overflow: OverflowVariant = Ecore.EAttribute(
        eType=OverflowVariant, default_value=OverflowVariant.weighted
    )
    """Overflow rule used."""
    certificate: ModelList[PlaceInvariant] = reference("PlaceInvariant", containment=True, upper=-1)
    """Place invariants that the rules guarantee."""

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: pn.Graphics | None = None,
        labels: Iterable[pn.Label] | None = None,
        toolInfos: Iterable[pn.ToolInfo] | None = None,
        suppressions: Iterable[pn.Suppression] | None = None,
        pages: Iterable[pn.Page] | None = None,
        systemModel: str | None = None,
        signals: SignalVariant | str | None = None,
        overflow: OverflowVariant | str | None = None,
        certificate: Iterable[PlaceInvariant] | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class Sheet(pn.Page):
    """The page on which the rules put what they make."""

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: pn.Graphics | None = None,
        labels: Iterable[pn.Label] | None = None,
        toolInfos: Iterable[pn.ToolInfo] | None = None,
        suppressions: Iterable[pn.Suppression] | None = None,
        page: pn.Page | None = None,
        net: pn.Net | None = None,
        objects: Iterable[pn.PageObject] | None = None,
        arcs: Iterable[pn.Arc] | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


complete(sys.modules[__name__])
