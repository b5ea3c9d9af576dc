"""Place/transition nets with pages and references (ISO/IEC 15909-1 and -2), inhibitor and read arcs, time
intervals and priorities.

Generated from `pn.ecore` by `make regenerate`; edits are lost.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Never

import pyecore.ecore as Ecore
from pyecore.resources import global_registry

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

if TYPE_CHECKING:

    class ArcKind(EnumLiteral):
        """What an arc asks of and does to its place."""

        normal: ClassVar[ArcKind]
        """Takes or puts as many tokens as its weight."""
        inhibitor: ClassVar[ArcKind]
        """From a place to a transition: enabled while the place holds fewer tokens than the weight."""
        read: ClassVar[ArcKind]
        """From a place to a transition: enabled while the place holds at least as many tokens as the weight; takes none."""

    class LabelKind(EnumLiteral):
        """Which text label of an element a layout belongs to."""

        elementName: ClassVar[LabelKind]
        """The name of an element."""
        initialMarking: ClassVar[LabelKind]
        """The token count of a place."""
        inscription: ClassVar[LabelKind]
        """The weight of an arc."""

else:
    ArcKind = enumeration(
        "ArcKind",
        [
            "normal",
            "inhibitor",
            "read",
        ],
    )
    LabelKind = enumeration(
        "LabelKind",
        [
            "elementName",
            "initialMarking",
            "inscription",
        ],
    )


@Ecore.abstract
class Element(EObject, metaclass=MetaEClass):
    """Anything with an identity in a net.

    Attributes
    ----------
    id : str
        Unique in the file; what references and the command line use.
    name : str | None
        What people read; the id where it is absent.
    sourceLine : str | None
        Line of the source code that the element stands for, as `file:line`; absent where no code was
        read.
    graphics : Graphics | None
        Where a net editor draws the element.
    labels : ModelList[Label]
        Layout of the element's text labels.
    toolInfos : ModelList[ToolInfo]
        Blocks of other tools, kept as they are.
    suppressions : ModelList[Suppression]
        Findings about the element, or about what it contains, that were accepted.
    """

    id: str = Ecore.EAttribute(eType=Ecore.EString, iD=True, lower=1, required=True)
    name: str | None = Ecore.EAttribute(eType=Ecore.EString)
    sourceLine: str | None = Ecore.EAttribute(eType=Ecore.EString)
    graphics: Graphics | None = Ecore.EReference(containment=True)
    labels: ModelList[Label] = Ecore.EReference(containment=True, upper=-1)
    toolInfos: ModelList[ToolInfo] = Ecore.EReference(containment=True, upper=-1)
    suppressions: ModelList[Suppression] = Ecore.EReference(containment=True, upper=-1)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

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
    """A point or an offset in the plane, in the editor's units.

    Attributes
    ----------
    x : float
        To the right.
    y : float
        Downwards.
    """

    x: float = Ecore.EAttribute(eType=Ecore.EDouble, lower=1, required=True)
    y: float = Ecore.EAttribute(eType=Ecore.EDouble, lower=1, required=True)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

    def __init__(self, *, x: float | None = None, y: float | None = None, **unknown: Never) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class Graphics(EObject, metaclass=MetaEClass):
    """Layout of an element (ISO/IEC 15909-2, clause 7.1.1).

    Attributes
    ----------
    positions : ModelList[Point]
        One point for a node, the bend points for an arc.
    offset : Point | None
        Offset of a label from its element.
    dimension : Point | None
        Width (x) and height (y).
    style : str | None
        The PNML elements fill, line and font, as XML text.
    """

    positions: ModelList[Point] = Ecore.EReference(containment=True, upper=-1)
    offset: Point | None = Ecore.EReference(containment=True)
    dimension: Point | None = Ecore.EReference(containment=True)
    style: str | None = Ecore.EAttribute(eType=Ecore.EString)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

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
    """Layout of one text label of an element.

    Attributes
    ----------
    kind : LabelKind
        Which label.
    graphics : Graphics | None
        Its layout.
    toolInfos : ModelList[ToolInfo]
        Blocks of other tools inside the label.
    """

    kind: LabelKind = Ecore.EAttribute(eType=LabelKind, default_value=LabelKind.elementName)
    graphics: Graphics | None = Ecore.EReference(containment=True)
    toolInfos: ModelList[ToolInfo] = Ecore.EReference(containment=True, upper=-1)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

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
    """A block of another tool (ISO/IEC 15909-2, toolspecific), kept through loading and saving.

    Attributes
    ----------
    tool : str
        Name of the tool.
    version : str
        Version of the tool.
    content : str | None
        The whole block as XML text.
    """

    tool: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    version: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    content: str | None = Ecore.EAttribute(eType=Ecore.EString)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

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
    """A finding of a check that was accepted: it is reported as suppressed and does not fail the check.

    Attributes
    ----------
    rule : str
        The rule of the finding, such as queue-overflow.
    reason : str
        Why it is accepted; shown in every report.
    until : str | None
        The last day on which it is accepted, such as 2027-03-31; always where it is absent.
    """

    rule: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    reason: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    until: str | None = Ecore.EAttribute(eType=Ecore.EString)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

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
    """Firing interval of a time Petri net (Merlin).

    Attributes
    ----------
    earliest : float
        Earliest firing time.
    latest : float | None
        Latest firing time; absent: unbounded.
    earliestExcluded : bool
        The interval is open at its start.
    latestExcluded : bool
        The interval is open at its end.
    source : str | None
        Where a measured interval comes from: the recording, the number of times and their quantiles.
    """

    earliest: float = Ecore.EAttribute(eType=Ecore.EDouble, default_value=0.0)
    latest: float | None = Ecore.EAttribute(eType=Ecore.EDoubleObject)
    earliestExcluded: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    latestExcluded: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    source: str | None = Ecore.EAttribute(eType=Ecore.EString)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

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
    """A Petri net: pages with places, transitions and arcs.

    Attributes
    ----------
    pages : ModelList[Page]
        Top-level pages, in order.
    """

    pages: ModelList[Page] = Ecore.EReference(containment=True, upper=-1)

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
    """What a page may hold besides arcs.

    Attributes
    ----------
    page : Page | None
        The page it stands on.
    """

    page: Page | None = Ecore.EReference()

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
    """Joins a place and a transition (or references to them) of the same page.

    Attributes
    ----------
    page : Page | None
        The page it stands on.
    source : Node
        Where it starts.
    target : Node
        Where it ends.
    weight : int
        1 or more.
    kind : ArcKind
        What it asks and does.
    """

    page: Page | None = Ecore.EReference()
    source: Node = Ecore.EReference(lower=1, required=True)
    target: Node = Ecore.EReference(lower=1, required=True)
    weight: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=1)
    kind: ArcKind = Ecore.EAttribute(eType=ArcKind, default_value=ArcKind.normal)

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
    """Part of a net; pages nest and add no semantics.

    Attributes
    ----------
    net : Net | None
        The net, for a top-level page.
    objects : ModelList[PageObject]
        Nodes and nested pages, in order.
    arcs : ModelList[Arc]
        Arcs between nodes of this page, in order.
    """

    net: Net | None = Ecore.EReference()
    objects: ModelList[PageObject] = Ecore.EReference(containment=True, upper=-1)
    arcs: ModelList[Arc] = Ecore.EReference(containment=True, upper=-1)

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
    """Place, transition, or a reference to one.

    Attributes
    ----------
    outgoing : ModelList[Arc]
        Arcs that start here.
    incoming : ModelList[Arc]
        Arcs that end here.
    """

    outgoing: ModelList[Arc] = Ecore.EReference(upper=-1, transient=True)
    incoming: ModelList[Arc] = Ecore.EReference(upper=-1, transient=True)

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
    """Holds tokens.

    Attributes
    ----------
    tokens : int
        Tokens in the initial marking, 0 or more.
    capacity : int | None
        Largest number of tokens that it may hold, 1 or more; absent: any.
    """

    tokens: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=0)
    capacity: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)

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
    """Changes the marking when it fires.

    Attributes
    ----------
    interval : TimeInterval | None
        Earliest and latest firing time since it became enabled.
    overrides : ModelList[Transition]
        Transitions of lower priority: they may not fire while this one is enabled.
    """

    interval: TimeInterval | None = Ecore.EReference(containment=True)
    overrides: ModelList[Transition] = Ecore.EReference(upper=-1)

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
    """Stands for a place of another page.

    Attributes
    ----------
    target : PlaceNode
        The place, or a reference to it.
    """

    target: PlaceNode = Ecore.EReference(lower=1, required=True)

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
    """Stands for a transition of another page.

    Attributes
    ----------
    target : TransitionNode
        The transition, or a reference to it.
    """

    target: TransitionNode = Ecore.EReference(lower=1, required=True)

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


resolve_references(
    types=[
        (Element.graphics, Graphics),
        (Element.labels, Label),
        (Element.toolInfos, ToolInfo),
        (Element.suppressions, Suppression),
        (Graphics.positions, Point),
        (Graphics.offset, Point),
        (Graphics.dimension, Point),
        (Label.graphics, Graphics),
        (Label.toolInfos, ToolInfo),
        (Net.pages, Page),
        (PageObject.page, Page),
        (Arc.page, Page),
        (Arc.source, Node),
        (Arc.target, Node),
        (Page.net, Net),
        (Page.objects, PageObject),
        (Page.arcs, Arc),
        (Node.outgoing, Arc),
        (Node.incoming, Arc),
        (Transition.interval, TimeInterval),
        (Transition.overrides, Transition),
        (ReferencePlace.target, PlaceNode),
        (ReferenceTransition.target, TransitionNode),
    ],
    opposites=[
        (Net.pages, Page.net),
        (Arc.page, Page.arcs),
        (Arc.source, Node.outgoing),
        (Arc.target, Node.incoming),
        (Page.objects, PageObject.page),
    ],
)

for _enumeration in (
    ArcKind,
    LabelKind,
):
    eClassifiers[_enumeration.name] = _enumeration
    eClass.eClassifiers.append(_enumeration)
global_registry[nsURI] = sys.modules[__name__]
