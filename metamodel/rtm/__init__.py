"""Runtime model (RTM): one ROS node, ports as information on its places (paper, Sect. 5.4).

Generated from `rtm.ecore` by `make regenerate`; edits are lost.
"""

from __future__ import annotations

import sys
from functools import partial
from typing import Any

import pyecore.ecore as Ecore

from dineros.metamodel import pn, sym
from dineros.metamodel.base import Choice, EObject, Mandatory, MetaEClass, ModelList, complete, reference

name = "rtm"
nsURI = "http://dineros.org/rtm/1.0"
nsPrefix = "rtm"

eClass = Ecore.EPackage(name=name, nsURI=nsURI, nsPrefix=nsPrefix)
eClassifiers: dict[str, Any] = {}
getEClassifier = partial(Ecore.getEClassifier, searchspace=eClassifiers)
eSubpackages: list[Any] = []
eSuperPackage = None


@Ecore.abstract
class PlacePort(EObject, metaclass=MetaEClass):
    """What is sent from or received on a place."""

    channel: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Id of the channel in the system model."""
    type: str | None = Ecore.EAttribute(eType=Ecore.EString)
    """ROS interface; absent: generated from the token type."""
    mappings: ModelList[sym.FieldMapping] = reference("sym.FieldMapping", containment=True, upper=-1)
    """How fields of an existing ROS interface map to token fields."""


class PublisherPort(PlacePort):
    """Tokens are published on a topic."""

    topic: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Topic name."""
    limit: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=10)
    """QoS depth."""
    qos: sym.QualityOfService | None = reference("sym.QualityOfService", containment=True)
    """Quality of service."""


class SubscriberPort(PlacePort):
    """Messages of a topic become tokens."""

    topic: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Topic name."""
    limit: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=10)
    """QoS depth."""
    dispatcherLimit: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=16)
    """Capacity of the node's dispatcher queue."""
    inHand: int | None = Ecore.EAttribute(eType=Ecore.EIntegerObject)
    """Messages that the node takes before it has worked on them, -1 for any number; absent: as many as one
    transition takes.
    """
    missed: sym.Place | None = reference("sym.Place")
    """Gets a token when the node has taken no message for the deadline; absent: nothing does."""
    qos: sym.QualityOfService | None = reference("sym.QualityOfService", containment=True)
    """Quality of service."""


class ClientPort(PlacePort):
    """Tokens are requests of a service."""

    service: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Service name."""
    client: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Id of the client."""
    response: Mandatory[sym.Place] = reference("sym.Place", lower=1, required=True)
    """Receives the responses."""
    outstanding: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=1)
    """Requests that the client has under way at most, -1 for any number."""
    timeout: float | None = Ecore.EAttribute(eType=Ecore.EDoubleObject)
    """Seconds until the client gives up; absent: it waits forever."""
    timedOut: sym.Place | None = reference("sym.Place")
    """Gets a token when the client gives up; absent: it is ready to ask again."""


class ServerPort(PlacePort):
    """Requests of a service become tokens."""

    service: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Service name."""
    exit: Mandatory[sym.Place] = reference("sym.Place", lower=1, required=True)
    """Holds the responses."""
    page: Mandatory[pn.Page] = reference("pn.Page", lower=1, required=True)
    """The server page."""
    instances: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=1)
    """Number of server instances."""
    depth: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=10)
    """Requests that wait for the server at most, under the rules of ROS 2."""
    outstanding: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=1)
    """Requests that one of its clients has under way at most, -1 for any number."""


class ActionClientPort(PlacePort):
    """Tokens are goals of an action."""

    action: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Action name."""
    client: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Id of the client."""
    succeeded: sym.Place | None = reference("sym.Place")
    """Receives results of goals that succeeded; absent: no client fetches them."""
    aborted: sym.Place | None = reference("sym.Place")
    """Receives results of goals that were aborted; absent: no client fetches them."""
    canceled: sym.Place | None = reference("sym.Place")
    """Receives results of goals that were canceled; absent: no client fetches them."""
    accepted: sym.Place | None = reference("sym.Place")
    """Gets a token when the client learns that the server has accepted a goal; absent: it does not ask."""
    rejected: sym.Place | None = reference("sym.Place")
    """Gets a token when the server refuses a goal."""
    cancel: sym.Place | None = reference("sym.Place")
    """A token here asks the server to cancel the goal."""
    feedback: sym.Place | None = reference("sym.Place")
    """Receives feedback."""
    outstanding: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=1)
    """Goals that the client has under way at most, 1 or more."""
    depth: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=10)
    """QoS depth of the feedback."""


class ActionServerPort(PlacePort):
    """Goals of an action that are accepted become tokens."""

    action: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Action name."""
    page: Mandatory[pn.Page] = reference("pn.Page", lower=1, required=True)
    """What works on a goal."""
    succeeded: sym.Place | None = reference("sym.Place")
    """Holds results of goals that succeed; absent: none does."""
    aborted: sym.Place | None = reference("sym.Place")
    """Holds results of goals that are aborted; absent: none is."""
    canceled: sym.Place | None = reference("sym.Place")
    """Holds results of goals that are canceled; absent: none is."""
    cancel: sym.Place | None = reference("sym.Place")
    """Gets a token when the goal is to be canceled; absent: all requests to cancel are refused."""
    feedback: sym.Place | None = reference("sym.Place")
    """Holds feedback for the client whose goal it is; absent: it gives none."""
    mayReject: bool = Ecore.EAttribute(eType=Ecore.EBoolean, default_value=False)
    """Whether the server may refuse a goal."""
    instances: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=1)
    """Number of goals that it works on at once."""
    depth: int = Ecore.EAttribute(eType=Ecore.EInt, default_value=10)
    """QoS depth of the feedback."""


class RuntimeModel(pn.Net):
    """The part of a system model that one ROS node runs."""

    node: Mandatory[sym.NodeNet] = reference("sym.NodeNet", lower=1, required=True)
    """The node net, on one of the pages."""
    tokenType: sym.TokenType | None = reference("sym.TokenType", containment=True)
    """What tokens carry in places that name no other type."""
    otherTokenTypes: ModelList[sym.TokenType] = reference("sym.TokenType", containment=True, upper=-1)
    """Further token types, which its places name."""
    systemModel: str = Ecore.EAttribute(eType=Ecore.EString, lower=1, required=True)
    """Id of the system model it was split from."""
    middleware: Choice[sym.Middleware] = Ecore.EAttribute(
        eType=sym.Middleware, default_value=sym.Middleware.ros1
    )
    """Whose queues its topics have."""


class Place(sym.Place):
    """A place with the ports it serves."""

    ports: ModelList[PlacePort] = reference("PlacePort", containment=True, upper=-1)
    """Its ports."""


complete(sys.modules[__name__])
