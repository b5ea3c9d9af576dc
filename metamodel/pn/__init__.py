"""Place/transition nets with pages and references (ISO/IEC 15909-1 and -2), inhibitor and read arcs, time
intervals and priorities.

Generated from `pn.ecore` by `make regenerate`; edits are lost.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from functools import partial
from typing import Any, ClassVar, Never

import pyecore.ecore as Ecore

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

name = "pn"
nsURI = "http://dineros.org/pn/1.0"
nsPrefix = "pn"

eClass = Ecore.EPackage(name=name, nsURI=nsURI, nsPrefix=nsPrefix)
eClassifiers: dict[str, Any] = {}
getEClassifier = partial(Ecore.getEClassifier, searchspace=eClassifiers)
eSubpackages: list[Any] = []
eSuperPackage = None

__all__ = [
    "Arc",
    "ArcKind",
    "Element",
    "Graphics",
    "Label",
    "LabelKind",
    "Net",
    "Node",
    "Page",
    "PageObject",
    "Place",
    "PlaceNode",
    "Point",
    "ReferencePlace",
    "ReferenceTransition",
    "Suppression",
    "TimeInterval",
    "ToolInfo",
    "Transition",
    "TransitionNode",
]


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

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: Graphics | None = None,
        labels: Iterable[Label] | None = None,
        toolInfos: Iterable[ToolInfo] | None = None,
        suppressions: Iterable[Suppression] | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class Point(EObject, metaclass=MetaEClass):
    """A point or an offset in the plane, in the editor's units."""

    x: float = Ecore.EAttribute(eType=Ecore.EDouble, lower=1, required=True)
    """To the right."""
    y: float = Ecore.EAttribute(eType=Ecore.EDouble, lower=1, required=True)
    """Downwards."""

    def __init__(self, *, x: float | None = None, y: float | None = None, **unknown: Never) -> None:
        super(EObject, self).__init__()
        initialise(locals())


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

    def __init__(
        self,
        *,
        positions: Iterable[Point] | None = None,
        offset: Point | None = None,
        dimension: Point | None = None,
        style: str | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class Label(EObject, metaclass=MetaEClass):
    """Layout of one text label of an element."""

    kind: LabelKind = Ecore.EAttribute(eType=LabelKind, default_value=LabelKind.elementName)
    """Which label."""
    graphics: Graphics | None = reference("Graphics", containment=True)
    """Its layout."""
    toolInfos: ModelList[ToolInfo] = reference("ToolInfo", containment=True, upper=-1)
    """Blocks of other tools inside the label."""

    def __init__(
        self,
        *,
        kind: LabelKind | str | None = None,
        graphics: Graphics | None = None,
        toolInfos: Iterable[ToolInfo] | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class ToolInfo(EObject, metaclass=MetaEClass):
    """A block of another tool (ISO/IEC 15909-2, toolspecific), kept through loading and saving."""

    tool: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Name of the tool."""
    version: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Version of the tool."""
    content: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """The whole block as XML text."""

    def __init__(
        self,
        *,
        tool: str | None = None,
        version: str | None = None,
        content: str | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class Suppression(EObject, metaclass=MetaEClass):
    """A finding of a check that was accepted: it is reported as suppressed and does not fail the check."""

    rule: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """The rule of the finding, such as queue-overflow."""
    reason: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Why it is accepted; shown in every report."""
    until: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """The last day on which it is accepted, such as 2027-03-31; always where it is absent."""

    def __init__(
        self,
        *,
        rule: str | None = None,
        reason: str | None = None,
        until: str | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


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

    def __init__(
        self,
        *,
        earliest: float | None = None,
        latest: float | None = None,
        earliestExcluded: bool | None = None,
        latestExcluded: bool | None = None,
        source: str | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class Net(Element):
    """A Petri net: pages with places, transitions and arcs."""

    pages: ModelList[Page] = reference("Page", opposite="net", containment=True, upper=-1)
    """Top-level pages, in order."""

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: Graphics | None = None,
        labels: Iterable[Label] | None = None,
        toolInfos: Iterable[ToolInfo] | None = None,
        suppressions: Iterable[Suppression] | None = None,
        pages: Iterable[Page] | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


@Ecore.abstract
class PageObject(Element):
    """What a page may hold besides arcs."""

    page: Page | None = reference("Page")
    """The page it is on."""

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: Graphics | None = None,
        labels: Iterable[Label] | None = None,
        toolInfos: Iterable[ToolInfo] | None = None,
        suppressions: Iterable[Suppression] | None = None,
        page: Page | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class Arc(Element):
    """Joins a place and a transition (or references to them) of the same page."""

    page: Page | None = reference("Page", opposite="arcs")
    """The page it is on."""
    source: Node = reference("Node", opposite="outgoing", lower=1, required=True)
    """Where it starts."""
    target: Node = reference("Node", opposite="incoming", lower=1, required=True)
    """Where it ends."""
    weight: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=1)
    """1 or more."""
    kind: ArcKind = Ecore.EAttribute(eType=ArcKind, default_value=ArcKind.normal)
    """What it asks and does."""

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: Graphics | None = None,
        labels: Iterable[Label] | None = None,
        toolInfos: Iterable[ToolInfo] | None = None,
        suppressions: Iterable[Suppression] | None = None,
        page: Page | None = None,
        source: Node | None = None,
        target: Node | None = None,
        weight: int | None = None,
        kind: ArcKind | str | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class Page(PageObject):
    """Part of a net; pages nest and add no semantics."""

    net: Net | None = reference("Net")
    """The net, for a top-level page."""
    objects: ModelList[PageObject] = reference("PageObject", opposite="page", containment=True, upper=-1)
    """Nodes and nested pages, in order."""
    arcs: ModelList[Arc] = reference("Arc", containment=True, upper=-1)
    """Arcs between nodes of this page, in order."""

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: Graphics | None = None,
        labels: Iterable[Label] | None = None,
        toolInfos: Iterable[ToolInfo] | None = None,
        suppressions: Iterable[Suppression] | None = None,
        page: Page | None = None,
        net: Net | None = None,
        objects: Iterable[PageObject] | None = None,
        arcs: Iterable[Arc] | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


@Ecore.abstract
class Node(PageObject):
    """Place, transition, or a reference to one."""

    outgoing: ModelList[Arc] = reference("Arc", upper=-1, transient=True)
    """Arcs that start here."""
    incoming: ModelList[Arc] = reference("Arc", upper=-1, transient=True)
    """Arcs that end here."""

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: Graphics | None = None,
        labels: Iterable[Label] | None = None,
        toolInfos: Iterable[ToolInfo] | None = None,
        suppressions: Iterable[Suppression] | None = None,
        page: Page | None = None,
        outgoing: Iterable[Arc] | None = None,
        incoming: Iterable[Arc] | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


@Ecore.abstract
class PlaceNode(Node):
    """Place or reference place."""

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: Graphics | None = None,
        labels: Iterable[Label] | None = None,
        toolInfos: Iterable[ToolInfo] | None = None,
        suppressions: Iterable[Suppression] | None = None,
        page: Page | None = None,
        outgoing: Iterable[Arc] | None = None,
        incoming: Iterable[Arc] | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


@Ecore.abstract
class TransitionNode(Node):
    """Transition or reference transition."""

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: Graphics | None = None,
        labels: Iterable[Label] | None = None,
        toolInfos: Iterable[ToolInfo] | None = None,
        suppressions: Iterable[Suppression] | None = None,
        page: Page | None = None,
        outgoing: Iterable[Arc] | None = None,
        incoming: Iterable[Arc] | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class Place(PlaceNode):
    """Holds tokens."""

    tokens: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=0)
    """Tokens in the initial marking, 0 or more."""
    capacity: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    """Largest number of tokens that it may hold, 1 or more; absent: any."""

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: Graphics | None = None,
        labels: Iterable[Label] | None = None,
        toolInfos: Iterable[ToolInfo] | None = None,
        suppressions: Iterable[Suppression] | None = None,
        page: Page | None = None,
        outgoing: Iterable[Arc] | None = None,
        incoming: Iterable[Arc] | None = None,
        tokens: int | None = None,
        capacity: int | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class Transition(TransitionNode):
    """Changes the marking when it fires."""

    interval: TimeInterval | None = reference("TimeInterval", containment=True)
    """Earliest and latest firing time since it became enabled."""
    overrides: ModelList[Transition] = reference("Transition", upper=-1)
    """Transitions of lower priority: they may not fire while this one is enabled."""

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: Graphics | None = None,
        labels: Iterable[Label] | None = None,
        toolInfos: Iterable[ToolInfo] | None = None,
        suppressions: Iterable[Suppression] | None = None,
        page: Page | None = None,
        outgoing: Iterable[Arc] | None = None,
        incoming: Iterable[Arc] | None = None,
        interval: TimeInterval | None = None,
        overrides: Iterable[Transition] | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class ReferencePlace(PlaceNode):
    """Stands for a place of another page."""

    target: PlaceNode = reference("PlaceNode", lower=1, required=True)
    """The place, or a reference to it."""

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: Graphics | None = None,
        labels: Iterable[Label] | None = None,
        toolInfos: Iterable[ToolInfo] | None = None,
        suppressions: Iterable[Suppression] | None = None,
        page: Page | None = None,
        outgoing: Iterable[Arc] | None = None,
        incoming: Iterable[Arc] | None = None,
        target: PlaceNode | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class ReferenceTransition(TransitionNode):
    """Stands for a transition of another page."""

    target: TransitionNode = reference("TransitionNode", lower=1, required=True)
    """The transition, or a reference to it."""

    def __init__(
        self,
        *,
        id: str | None = None,
        name: str | None = None,
        sourceLine: str | None = None,
        graphics: Graphics | None = None,
        labels: Iterable[Label] | None = None,
        toolInfos: Iterable[ToolInfo] | None = None,
        suppressions: Iterable[Suppression] | None = None,
        page: Page | None = None,
        outgoing: Iterable[Arc] | None = None,
        incoming: Iterable[Arc] | None = None,
        target: TransitionNode | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


complete(sys.modules[__name__])
