"""How messages name elements: ``place 'Ready'``, ``client port 'c1' of service channel 'Pick'``."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from functools import cache

from dineros.metamodel import pn, pnm, rtm, sym
from dineros.metamodel.base import EObject

# The features that distinguish the parts of one element, for classes without an id.
_KEYS: dict[type[EObject], Callable[..., object]] = {
    pn.Suppression: lambda suppression: suppression.rule,
    sym.TokenField: lambda field: field.name,
    sym.FieldMapping: lambda mapping: mapping.messageField,
    sym.TopicPort: lambda port: port.place and port.place.id,
    sym.Dispatcher: lambda dispatcher: dispatcher.node and dispatcher.node.id,
    sym.ClientPort: lambda port: port.client,
    sym.ActionClientPort: lambda port: port.client,
    sym.BalloonToken: lambda balloon: list(balloon.eContainer().balloons).index(balloon) + 1,
    sym.Literal: lambda literal: literal.signal and literal.signal.id,
    rtm.PublisherPort: lambda port: port.topic,
    rtm.SubscriberPort: lambda port: port.topic,
    rtm.ClientPort: lambda port: port.client,
    rtm.ServerPort: lambda port: port.service,
    rtm.ActionClientPort: lambda port: port.client,
    rtm.ActionServerPort: lambda port: port.action,
    pnm.PlaceInvariant: lambda invariant: invariant.name,
}


def describe(element: EObject) -> str:
    """Name an element with its kind and id; a part without id with the element it belongs to."""
    kind = kind_of(element)
    if isinstance(element, pn.Element):
        return f"{kind} {element.id!r}" if element.id else f"{kind} without id"
    container = element.eContainer()
    owner = f" of {describe(container)}" if container is not None else ""
    identify = next((key for known, key in _KEYS.items() if isinstance(element, known)), None)
    identity = identify(element) if identify and container is not None else None
    return f"{kind} {identity!r}{owner}" if identity else f"{kind}{owner}"


def listed(elements: Iterable[EObject]) -> str:
    """Name several elements, joined by ``and``."""
    return " and ".join(describe(element) for element in elements)


def kind_of(element: EObject) -> str:
    """Return the class of an element in words, such as ``reference place``."""
    return words_for(type(element))


def words_for(cls: type[EObject]) -> str:
    """Return the name of a class in words."""
    return _words("element" if cls is EObject else cls.__name__)


@cache
def _words(name: str) -> str:
    return re.sub(r"(?<!^)(?=[A-Z])", " ", name).lower()
