"""Petri net model (PNM): the flattened net that is analysed (paper, Sect. 5.5).

Generated from `pnm.ecore` by `make regenerate`; edits are lost.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Never

import pyecore.ecore as Ecore
from pyecore.resources import global_registry

from dineros.metamodel import pn
from dineros.metamodel.base import (
    EnumLiteral,
    EObject,
    MetaEClass,
    ModelList,
    enumeration,
    initialise,
    notify_listeners,
    refuse_unknown,
    resolve_references,
    show,
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

if TYPE_CHECKING:

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

    class OverflowVariant(EnumLiteral):
        """How a full queue drops (rules T5a and T5b)."""

        weighted: ClassVar[OverflowVariant]
        """Ordinary arcs on Load (T5b)."""
        inhibitor: ClassVar[OverflowVariant]
        """Inhibitor arc on Capacity (T5a)."""

else:
    SignalVariant = enumeration(
        "SignalVariant",
        [
            "none",
            "fullyEnabled",
            "inputEnabled",
            "ioEnabled",
        ],
    )
    OverflowVariant = enumeration(
        "OverflowVariant",
        [
            "weighted",
            "inhibitor",
        ],
    )


class PlaceInvariant(EObject, metaclass=MetaEClass):
    """Weighted sum of tokens that no firing changes.

    Attributes
    ----------
    name : str
        What it says.
    value : int
        The sum.
    terms : ModelList[InvariantTerm]
        Places and their weights.
    """

    name: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    value: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=0)
    terms: ModelList[InvariantTerm] = Ecore.EReference(containment=True, lower=1, required=True, upper=-1)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

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
    """A place of an invariant.

    Attributes
    ----------
    place : pn.Place
        The place.
    weight : int
        Its weight.
    """

    place: pn.Place = Ecore.EReference(lower=1, required=True)
    weight: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=1)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

    def __init__(self, *, place: pn.Place | None = None, weight: int | None = None, **unknown: Never) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class PetriNetModel(pn.Net):
    """A plain net without references and nested pages.

    Attributes
    ----------
    systemModel : str
        Id of the system model it was made from.
    signals : SignalVariant
        Signal rules used.
    overflow : OverflowVariant
        Overflow rule used.
    certificate : ModelList[PlaceInvariant]
        Place invariants that the rules guarantee.
    """

    systemModel: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    signals: SignalVariant = Ecore.EAttribute(eType=SignalVariant, default_value=SignalVariant.inputEnabled)
    overflow: OverflowVariant = Ecore.EAttribute(
        eType=OverflowVariant, default_value=OverflowVariant.weighted
    )
    certificate: ModelList[PlaceInvariant] = Ecore.EReference(containment=True, upper=-1)

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


resolve_references(
    types=[
        (PlaceInvariant.terms, InvariantTerm),
        (InvariantTerm.place, pn.Place),
        (PetriNetModel.certificate, PlaceInvariant),
    ],
    opposites=[],
)

for _enumeration in (
    SignalVariant,
    OverflowVariant,
):
    eClassifiers[_enumeration.name] = _enumeration
    eClass.eClassifiers.append(_enumeration)
global_registry[nsURI] = sys.modules[__name__]
