"""Runtime model (RTM): one ROS node, ports as information on its places (paper, Sect. 5.4).

Generated from `rtm.ecore` by `make regenerate`; edits are lost.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from functools import partial
from typing import Any, Never

import pyecore.ecore as Ecore
from pyecore.resources import global_registry

from dineros.metamodel import pn, sym
from dineros.metamodel.base import (
    EObject,
    MetaEClass,
    ModelList,
    initialise,
    notify_listeners,
    refuse_unknown,
    resolve_references,
    show,
)

name = "rtm"
nsURI = "http://dineros.org/rtm/1.0"
nsPrefix = "rtm"

eClass = Ecore.EPackage(name=name, nsURI=nsURI, nsPrefix=nsPrefix)
eClassifiers: dict[str, Any] = {}
getEClassifier = partial(Ecore.getEClassifier, searchspace=eClassifiers)
eSubpackages: list[Any] = []
eSuperPackage = None

__all__ = [
    "ActionClientPort",
    "ActionServerPort",
    "ClientPort",
    "Place",
    "PlacePort",
    "PublisherPort",
    "RuntimeModel",
    "ServerPort",
    "SubscriberPort",
]


@Ecore.abstract
class PlacePort(EObject, metaclass=MetaEClass):
    """What is sent from or received on a place.

    Attributes
    ----------
    channel : str
        Id of the channel in the system model.
    type : str | None
        ROS interface; absent: generated from the token type.
    mappings : ModelList[sym.FieldMapping]
        How fields of an existing ROS interface map to token fields.
    """

    channel: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    type: str | None = Ecore.EAttribute(eType=Ecore.EString)
    mappings: ModelList[sym.FieldMapping] = Ecore.EReference(containment=True, upper=-1)

    __setattr__ = refuse_unknown
    notify = notify_listeners
    __repr__ = show

    def __init__(
        self,
        *,
        channel: str | None = None,
        type: str | None = None,
        mappings: Iterable[sym.FieldMapping] | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class PublisherPort(PlacePort):
    """Tokens are published on a topic.

    Attributes
    ----------
    topic : str
        Topic name.
    limit : int
        QoS depth.
    qos : sym.QualityOfService | None
        Quality of service.
    """

    topic: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    limit: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=10)
    qos: sym.QualityOfService | None = Ecore.EReference(containment=True)

    def __init__(
        self,
        *,
        channel: str | None = None,
        type: str | None = None,
        mappings: Iterable[sym.FieldMapping] | None = None,
        topic: str | None = None,
        limit: int | None = None,
        qos: sym.QualityOfService | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class SubscriberPort(PlacePort):
    """Messages of a topic become tokens.

    Attributes
    ----------
    topic : str
        Topic name.
    limit : int
        QoS depth.
    dispatcherLimit : int
        Capacity of the node's dispatcher queue.
    inHand : int | None
        Messages that the node takes before it has worked on them, -1 for any number; absent: as many as
        one transition takes.
    missed : sym.Place | None
        Gets a token when the node has taken no message for the deadline; absent: nothing does.
    qos : sym.QualityOfService | None
        Quality of service.
    """

    topic: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    limit: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=10)
    dispatcherLimit: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=16)
    inHand: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    missed: sym.Place | None = Ecore.EReference()
    qos: sym.QualityOfService | None = Ecore.EReference(containment=True)

    def __init__(
        self,
        *,
        channel: str | None = None,
        type: str | None = None,
        mappings: Iterable[sym.FieldMapping] | None = None,
        topic: str | None = None,
        limit: int | None = None,
        dispatcherLimit: int | None = None,
        inHand: int | None = None,
        missed: sym.Place | None = None,
        qos: sym.QualityOfService | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class ClientPort(PlacePort):
    """Tokens are requests of a service.

    Attributes
    ----------
    service : str
        Service name.
    client : str
        Id of the client.
    response : sym.Place
        Receives the responses.
    outstanding : int
        Requests that the client has under way at most, -1 for any number.
    timeout : float | None
        Seconds until the client gives up; absent: it waits forever.
    timedOut : sym.Place | None
        Gets a token when the client gives up; absent: it is ready to ask again.
    """

    service: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    client: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    response: sym.Place = Ecore.EReference(lower=1, required=True)
    outstanding: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=1)
    timeout: float | None = Ecore.EAttribute(eType=Ecore.EDoubleObject)
    timedOut: sym.Place | None = Ecore.EReference()

    def __init__(
        self,
        *,
        channel: str | None = None,
        type: str | None = None,
        mappings: Iterable[sym.FieldMapping] | None = None,
        service: str | None = None,
        client: str | None = None,
        response: sym.Place | None = None,
        outstanding: int | None = None,
        timeout: float | None = None,
        timedOut: sym.Place | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class ServerPort(PlacePort):
    """Requests of a service become tokens.

    Attributes
    ----------
    service : str
        Service name.
    exit : sym.Place
        Holds the responses.
    page : pn.Page
        The server page.
    instances : int
        Number of server instances.
    depth : int
        Requests that wait for the server at most, under the rules of ROS 2.
    outstanding : int
        Requests that one of its clients has under way at most, -1 for any number.
    """

    service: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    exit: sym.Place = Ecore.EReference(lower=1, required=True)
    page: pn.Page = Ecore.EReference(lower=1, required=True)
    instances: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=1)
    depth: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=10)
    outstanding: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=1)

    def __init__(
        self,
        *,
        channel: str | None = None,
        type: str | None = None,
        mappings: Iterable[sym.FieldMapping] | None = None,
        service: str | None = None,
        exit: sym.Place | None = None,
        page: pn.Page | None = None,
        instances: int | None = None,
        depth: int | None = None,
        outstanding: int | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class ActionClientPort(PlacePort):
    """Tokens are goals of an action.

    Attributes
    ----------
    action : str
        Action name.
    client : str
        Id of the client.
    succeeded : sym.Place | None
        Receives results of goals that succeeded; absent: no client fetches them.
    aborted : sym.Place | None
        Receives results of goals that were aborted; absent: no client fetches them.
    canceled : sym.Place | None
        Receives results of goals that were canceled; absent: no client fetches them.
    accepted : sym.Place | None
        Gets a token when the client learns that the server has accepted a goal; absent: it does not ask.
    rejected : sym.Place | None
        Gets a token when the server refuses a goal.
    cancel : sym.Place | None
        A token here asks the server to cancel the goal.
    feedback : sym.Place | None
        Receives feedback.
    outstanding : int
        Goals that the client has under way at most, 1 or more.
    depth : int
        QoS depth of the feedback.
    """

    action: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    client: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    succeeded: sym.Place | None = Ecore.EReference()
    aborted: sym.Place | None = Ecore.EReference()
    canceled: sym.Place | None = Ecore.EReference()
    accepted: sym.Place | None = Ecore.EReference()
    rejected: sym.Place | None = Ecore.EReference()
    cancel: sym.Place | None = Ecore.EReference()
    feedback: sym.Place | None = Ecore.EReference()
    outstanding: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=1)
    depth: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=10)

    def __init__(
        self,
        *,
        channel: str | None = None,
        type: str | None = None,
        mappings: Iterable[sym.FieldMapping] | None = None,
        action: str | None = None,
        client: str | None = None,
        succeeded: sym.Place | None = None,
        aborted: sym.Place | None = None,
        canceled: sym.Place | None = None,
        accepted: sym.Place | None = None,
        rejected: sym.Place | None = None,
        cancel: sym.Place | None = None,
        feedback: sym.Place | None = None,
        outstanding: int | None = None,
        depth: int | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class ActionServerPort(PlacePort):
    """Goals of an action that are accepted become tokens.

    Attributes
    ----------
    action : str
        Action name.
    page : pn.Page
        What works on a goal.
    succeeded : sym.Place | None
        Holds results of goals that succeed; absent: none does.
    aborted : sym.Place | None
        Holds results of goals that are aborted; absent: none is.
    canceled : sym.Place | None
        Holds results of goals that are canceled; absent: none is.
    cancel : sym.Place | None
        Gets a token when the goal is to be canceled; absent: all requests to cancel are refused.
    feedback : sym.Place | None
        Holds feedback for the client whose goal it is; absent: it gives none.
    mayReject : bool
        Whether the server may refuse a goal.
    instances : int
        Number of goals that it works on at once.
    depth : int
        QoS depth of the feedback.
    """

    action: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    page: pn.Page = Ecore.EReference(lower=1, required=True)
    succeeded: sym.Place | None = Ecore.EReference()
    aborted: sym.Place | None = Ecore.EReference()
    canceled: sym.Place | None = Ecore.EReference()
    cancel: sym.Place | None = Ecore.EReference()
    feedback: sym.Place | None = Ecore.EReference()
    mayReject: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    instances: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=1)
    depth: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=10)

    def __init__(
        self,
        *,
        channel: str | None = None,
        type: str | None = None,
        mappings: Iterable[sym.FieldMapping] | None = None,
        action: str | None = None,
        page: pn.Page | None = None,
        succeeded: sym.Place | None = None,
        aborted: sym.Place | None = None,
        canceled: sym.Place | None = None,
        cancel: sym.Place | None = None,
        feedback: sym.Place | None = None,
        mayReject: bool | None = None,
        instances: int | None = None,
        depth: int | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class RuntimeModel(pn.Net):
    """The part of a system model that one ROS node runs.

    Attributes
    ----------
    node : sym.NodeNet
        The node net, on one of the pages.
    tokenType : sym.TokenType | None
        What tokens carry in places that name no other type.
    otherTokenTypes : ModelList[sym.TokenType]
        Further token types, which its places name.
    systemModel : str
        Id of the system model it was split from.
    middleware : sym.Middleware
        Whose queues its topics have.
    """

    node: sym.NodeNet = Ecore.EReference(lower=1, required=True)
    tokenType: sym.TokenType | None = Ecore.EReference(containment=True)
    otherTokenTypes: ModelList[sym.TokenType] = Ecore.EReference(containment=True, upper=-1)
    systemModel: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    middleware: sym.Middleware = Ecore.EAttribute(eType=sym.Middleware, default_value=sym.Middleware.ros1)

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
        node: sym.NodeNet | None = None,
        tokenType: sym.TokenType | None = None,
        otherTokenTypes: Iterable[sym.TokenType] | None = None,
        systemModel: str | None = None,
        middleware: sym.Middleware | str | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


class Place(sym.Place):
    """A place with the ports it serves.

    Attributes
    ----------
    ports : ModelList[PlacePort]
        Its ports.
    """

    ports: ModelList[PlacePort] = Ecore.EReference(containment=True, upper=-1)

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
        outgoing: Iterable[pn.Arc] | None = None,
        incoming: Iterable[pn.Arc] | None = None,
        tokens: int | None = None,
        capacity: int | None = None,
        balloons: Iterable[sym.BalloonToken] | None = None,
        kind: sym.PlaceKind | str | None = None,
        tokenType: sym.TokenType | None = None,
        ports: Iterable[PlacePort] | None = None,
        **unknown: Never,
    ) -> None:
        super(EObject, self).__init__()
        initialise(locals())


resolve_references(
    types=[
        (PlacePort.mappings, sym.FieldMapping),
        (PublisherPort.qos, sym.QualityOfService),
        (SubscriberPort.missed, sym.Place),
        (SubscriberPort.qos, sym.QualityOfService),
        (ClientPort.response, sym.Place),
        (ClientPort.timedOut, sym.Place),
        (ServerPort.exit, sym.Place),
        (ServerPort.page, pn.Page),
        (ActionClientPort.succeeded, sym.Place),
        (ActionClientPort.aborted, sym.Place),
        (ActionClientPort.canceled, sym.Place),
        (ActionClientPort.accepted, sym.Place),
        (ActionClientPort.rejected, sym.Place),
        (ActionClientPort.cancel, sym.Place),
        (ActionClientPort.feedback, sym.Place),
        (ActionServerPort.page, pn.Page),
        (ActionServerPort.succeeded, sym.Place),
        (ActionServerPort.aborted, sym.Place),
        (ActionServerPort.canceled, sym.Place),
        (ActionServerPort.cancel, sym.Place),
        (ActionServerPort.feedback, sym.Place),
        (RuntimeModel.node, sym.NodeNet),
        (RuntimeModel.tokenType, sym.TokenType),
        (RuntimeModel.otherTokenTypes, sym.TokenType),
        (Place.ports, PlacePort),
    ],
    opposites=[],
)

global_registry[nsURI] = sys.modules[__name__]
