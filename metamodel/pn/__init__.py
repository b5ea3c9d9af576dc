"""Place/transition nets with pages and references (ISO/IEC 15909-1 and -2), inhibitor and read arcs, time
intervals and priorities.

Generated from `pn.ecore` by `make regenerate`; edits are lost.
"""

from __future__ import annotations

import sys
from functools import partial
from typing import Any, ClassVar

import pyecore.ecore as Ecore

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

name = "pn"
nsURI = "http://dineros.org/pn/1.0"
nsPrefix = "pn"

eClass = Ecore.EPackage(name=name, nsURI=nsURI, nsPrefix=nsPrefix)
eClassifiers: dict[str, Any] = {}
getEClassifier = partial(Ecore.getEClassifier, searchspace=eClassifiers)
eSubpackages: list[Any] = []
eSuperPackage = None


@enumeration
class ArcKind(EnumLiteral):
    """What an arc asks of and does to its place."""

    normal: ClassVar[ArcKind]
    """Takes or puts as many tokens as its weight."""
    inhibitor: ClassVar[ArcKind]
    """From a place to a transition: enabled while the place holds fewer tokens than the weight."""
    read: ClassVar[ArcKind]
    """From a place to a transition: enabled while the place holds at least as many tokens as the weight;
    takes none.
    """


@enumeration
class LabelKind(EnumLiteral):
    """Which text label of an element a layout belongs to."""

    elementName: ClassVar[LabelKind]
    """The name of an element."""
    initialMarking: ClassVar[LabelKind]
    """The token count of a place."""
    inscription: ClassVar[LabelKind]
    """The weight of an arc."""


@Ecore.abstract
class Element(EObject, metaclass=MetaEClass):
    """Anything with an identity in a net."""

    id: str = Ecore.EAttribute(eType=Ecore.EString, iD=True, lower=1, required=True)
    """Unique in the file; what references and the command line use."""
    name: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """What people read; the id where it is absent."""
    sourceLine: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """Line of the source code that the element stands for, as `file:line`; absent where no code was read."""
    graphics: Graphics | None = reference("Graphics", containment=True)
    """Where a net editor draws the element."""
    labels: ModelList[Label] = reference("Label", containment=True, upper=-1)
    """Layout of the element's text labels."""
    toolInfos: ModelList[ToolInfo] = reference("ToolInfo", containment=True, upper=-1)
    """Blocks of other tools, kept as they are."""
    suppressions: ModelList[Suppression] = reference("Suppression", containment=True, upper=-1)
    """Findings about the element, or about what it contains, that were accepted."""


class Point(EObject, metaclass=MetaEClass):
    """A point or an offset in the plane, in the editor's units."""

    x: float = Ecore.EAttribute(eType=Ecore.EDouble, lower=1, required=True)
    """To the right."""
    y: float = Ecore.EAttribute(eType=Ecore.EDouble, lower=1, required=True)
    """Downwards."""


class Graphics(EObject, metaclass=MetaEClass):
    """Layout of an element (ISO/IEC 15909-2, clause 7.1.1)."""

    positions: ModelList[Point] = reference("Point", containment=True, upper=-1)
    """One point for a node, the bend points for an arc."""
    offset: Point | None = reference("Point", containment=True)
    """Offset of a label from its element."""
    dimension: Point | None = reference("Point", containment=True)
    """Width (x) and height (y)."""
    style: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """The PNML elements fill, line and font, as XML text."""


class Label(EObject, metaclass=MetaEClass):
    """Layout of one text label of an element."""

    kind: Choice[LabelKind] = Ecore.EAttribute(eType=LabelKind, default_value=LabelKind.elementName)
    """Which label."""
    graphics: Graphics | None = reference("Graphics", containment=True)
    """Its layout."""
    toolInfos: ModelList[ToolInfo] = reference("ToolInfo", containment=True, upper=-1)
    """Blocks of other tools inside the label."""


class ToolInfo(EObject, metaclass=MetaEClass):
    """A block of another tool (ISO/IEC 15909-2, toolspecific), kept through loading and saving."""

    tool: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Name of the tool."""
    version: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Version of the tool."""
    content: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """The whole block as XML text."""


class Suppression(EObject, metaclass=MetaEClass):
    """A finding of a check that was accepted: it is reported as suppressed and does not fail the check."""

    rule: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """The rule of the finding, such as queue-overflow."""
    reason: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Why it is accepted; shown in every report."""
    until: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """The last day on which it is accepted, such as 2027-03-31; always where it is absent."""


class TimeInterval(EObject, metaclass=MetaEClass):
    """Firing interval of a time Petri net (Merlin)."""

    earliest: float = Ecore.EAttribute(eType=Ecore.EDouble, default_value=0.0)
    """Earliest firing time."""
    latest: float | None = Ecore.EAttribute(eType=Ecore.EDoubleObject)
    """Latest firing time; absent: unbounded."""
    earliestExcluded: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    """The interval is open at its start."""
    latestExcluded: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    """The interval is open at its end."""
    source: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """Where a measured interval comes from: the recording, the number of times and their quantiles."""


class Net(Element):
    """A Petri net: pages with places, transitions and arcs."""

    pages: ModelList[Page] = reference("Page", opposite="net", containment=True, upper=-1)
    """Top-level pages, in order."""


@Ecore.abstract
class PageObject(Element):
    """What a page may hold besides arcs."""

    page: Page | None = reference("Page")
    """The page it is on."""


class Arc(Element):
    """Joins a place and a transition (or references to them) of the same page."""

    page: Page | None = reference("Page", opposite="arcs")
    """The page it is on."""
    source: Mandatory[Node] = reference("Node", opposite="outgoing", lower=1, required=True)
    """Where it starts."""
    target: Mandatory[Node] = reference("Node", opposite="incoming", lower=1, required=True)
    """Where it ends."""
    weight: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=1)
    """1 or more."""
    kind: Choice[ArcKind] = Ecore.EAttribute(eType=ArcKind, default_value=ArcKind.normal)
    """What it asks and does."""


class Page(PageObject):
    """Part of a net; pages nest and add no semantics."""

    net: Net | None = reference("Net")
    """The net, for a top-level page."""
    objects: ModelList[PageObject] = reference("PageObject", opposite="page", containment=True, upper=-1)
    """Nodes and nested pages, in order."""
    arcs: ModelList[Arc] = reference("Arc", containment=True, upper=-1)
    """Arcs between nodes of this page, in order."""


@Ecore.abstract
class Node(PageObject):
    """Place, transition, or a reference to one."""

    outgoing: ModelList[Arc] = reference("Arc", upper=-1, transient=True)
    """Arcs that start here."""
    incoming: ModelList[Arc] = reference("Arc", upper=-1, transient=True)
    """Arcs that end here."""


@Ecore.abstract
class PlaceNode(Node):
    """Place or reference place."""


@Ecore.abstract
class TransitionNode(Node):
    """Transition or reference transition."""


class Place(PlaceNode):
    """Holds tokens."""

    tokens: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=0)
    """Tokens in the initial marking, 0 or more."""
    capacity: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    """Largest number of tokens that it may hold, 1 or more; absent: any."""


class Transition(TransitionNode):
    """Changes the marking when it fires."""

    interval: TimeInterval | None = reference("TimeInterval", containment=True)
    """Earliest and latest firing time since it became enabled."""
    overrides: ModelList[Transition] = reference("Transition", upper=-1)
    """Transitions of lower priority: they may not fire while this one is enabled."""


class ReferencePlace(PlaceNode):
    """Stands for a place of another page."""

    target: Mandatory[PlaceNode] = reference("PlaceNode", lower=1, required=True)
    """The place, or a reference to it."""


class ReferenceTransition(TransitionNode):
    """Stands for a transition of another page."""

    target: Mandatory[TransitionNode] = reference("TransitionNode", lower=1, required=True)
    """The transition, or a reference to it."""


complete(sys.modules[__name__])
