"""Which rule made which element from what.

Generated from `trace.ecore` by `make regenerate`; edits are lost.
"""

from __future__ import annotations

import sys
from functools import partial
from typing import Any

import pyecore.ecore as Ecore

from dineros.metamodel.base import EObject, Mandatory, MetaEClass, ModelList, complete, reference

name = "trace"
nsURI = "http://dineros.org/trace/1.0"
nsPrefix = "trace"

eClass = Ecore.EPackage(name=name, nsURI=nsURI, nsPrefix=nsPrefix)
eClassifiers: dict[str, Any] = {}
getEClassifier = partial(Ecore.getEClassifier, searchspace=eClassifiers)
eSubpackages: list[Any] = []
eSuperPackage = None


class TraceModel(EObject, metaclass=MetaEClass):
    """Trace links of one transformation."""

    source: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """File or id of the source model."""
    target: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """File or id of the target model."""
    links: ModelList[TraceLink] = reference("TraceLink", containment=True, upper=-1)
    """The links, in the order they were made."""


class TraceLink(EObject, metaclass=MetaEClass):
    """One created element."""

    rule: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Name of the rule."""
    role: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Name of the element in the rule's right-hand side."""
    application: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=0)
    """Number of the rule application; links with the same number were made together."""
    index: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    """Number of the server instance, from 1, where there is one."""
    clientIndex: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    """Number of the server instance whose call it belongs to, from 1, where the client is on a server page."""
    sources: ModelList[EObject] = reference("EObject", upper=-1)
    """Elements the rule matched."""
    target: Mandatory[EObject] = reference("EObject", lower=1, required=True)
    """The element it made."""


complete(sys.modules[__name__])
