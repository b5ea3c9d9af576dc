"""Walking a model: its nodes, arcs and pages in model order, node nets, references, and look-up by id."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeVar, overload

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.errors import DinerosError, UnknownElementError, near_matches

E = TypeVar("E", bound=pn.Element)
C = TypeVar("C", bound=sym.Channel)


class ReferenceCycleError(DinerosError):
    """Reference places or transitions that refer to each other in a circle."""


def pages(net: pn.Net) -> Iterator[pn.Page]:
    """Yield all pages of a net, outer before inner, in model order."""
    stack = list(net.pages)[::-1]
    while stack:
        page = stack.pop()
        yield page
        stack.extend([inner for inner in page.objects if isinstance(inner, pn.Page)][::-1])


def system_model_of(element: EObject | None) -> sym.SystemModel | None:
    """Return the system model that an element is in, itself included."""
    while element is not None and not isinstance(element, sym.SystemModel):
        element = element.eContainer()
    return element


def nodes(net: pn.Net) -> Iterator[pn.Node]:
    """Yield all places, transitions and references of a net, page by page."""
    for page in pages(net):
        for node in page.objects:
            if isinstance(node, pn.Node):
                yield node


def places(net: pn.Net) -> list[pn.Place]:
    """Return all places of a net, in model order."""
    return [node for node in nodes(net) if isinstance(node, pn.Place)]


def transitions(net: pn.Net) -> list[pn.Transition]:
    """Return all transitions of a net, in model order."""
    return [node for node in nodes(net) if isinstance(node, pn.Transition)]


def arcs(net: pn.Net) -> Iterator[pn.Arc]:
    """Yield all arcs of a net, page by page."""
    for page in pages(net):
        yield from page.arcs


def node_nets(net: pn.Net) -> list[sym.NodeNet]:
    """Return the node nets of a model, in model order."""
    return [page for page in pages(net) if isinstance(page, sym.NodeNet)]


def channels(net: pn.Net | None, kind: type[C]) -> list[C]:
    """Return the channels of a kind of a model, in model order; only system models have any."""
    found = net.channels if isinstance(net, sym.SystemModel) else ()
    return [channel for channel in found if isinstance(channel, kind)]


def elements(net: pn.Net) -> Iterator[pn.Element]:
    """Yield all that has an id: net, pages, nodes, arcs, signals, callback groups, channels, token types."""
    yield net
    for page in pages(net):
        yield page
        for node in page.objects:
            if isinstance(node, pn.Node):
                yield node
        yield from page.arcs
        if isinstance(page, sym.NodeNet):
            yield from page.signals
            yield from page.callbackGroups
    if isinstance(net, sym.SystemModel):
        yield from net.channels
    yield from token_types(net)


def named_elements(net: pn.Net) -> Iterator[pn.Element]:
    """Yield all that people can name: `elements`, and the properties and assumptions of a system model."""
    yield from elements(net)
    if isinstance(net, sym.SystemModel):
        yield from net.properties
        yield from net.assumptions


def token_types(net: pn.Net) -> list[sym.TokenType]:
    """Return the token types of a model, the first one first; of run-time models, too."""
    first: sym.TokenType | None = getattr(net, "tokenType", None)
    others: list[sym.TokenType] = list(getattr(net, "otherTokenTypes", ()))
    return [first, *others] if first is not None else others


@overload
def find(net: pn.Net, id: str) -> pn.Element: ...
@overload
def find(net: pn.Net, id: str, kind: type[E]) -> E: ...
def find(net: pn.Net, id: str, kind: type[pn.Element] = pn.Element) -> pn.Element:
    """Return the element with this id.

    Raises
    ------
    UnknownElementError
        No element of that kind has the id; the hint names near matches.
    """
    for element in elements(net):
        if element.id == id and isinstance(element, kind):
            return element
    known = [element.id for element in elements(net) if isinstance(element, kind) and element.id]
    raise UnknownElementError(f"no {kind.__name__} has the id {id!r}", hint=near_matches(id, known))


def node_net_of(element: EObject | None) -> sym.NodeNet | None:
    """Return the node net an element is in, itself included, or None outside of all node nets."""
    while element is not None and not isinstance(element, sym.NodeNet):
        element = element.eContainer()
    return element


def is_unseen(node: sym.NodeNet | None) -> bool:
    """Return whether a node net was not seen, and stands for what has the other end of a channel."""
    return node is not None and "node" in (node.assumed or "").split()


def resolve(node: pn.Node) -> pn.Place | pn.Transition:
    """Follow references until a place or transition.

    Raises
    ------
    ReferenceCycleError
        The references run in a circle; the message names its elements.
    DinerosError
        A reference has no target.
    """
    chain: list[pn.Node] = []
    while isinstance(node, (pn.ReferencePlace, pn.ReferenceTransition)):
        if node in chain:
            circle = " -> ".join(str(reference.id) for reference in [*chain[chain.index(node) :], node])
            raise ReferenceCycleError(f"references run in a circle: {circle}", element=node.id)
        chain.append(node)
        if node.target is None:
            raise DinerosError(f"reference {node.id!r} has no target", element=node.id)
        node = node.target
    assert isinstance(node, (pn.Place, pn.Transition))
    return node


def label(element: pn.Element) -> str:
    """Return what people read: the name, or the id where there is none."""
    return element.name or element.id


def fresh_id(id: str, taken: set[str]) -> str:
    """Return an unused id; the second ``a-b`` becomes ``a-b~2``."""
    found, number = id, 1
    while found in taken:
        number += 1
        found = f"{id}~{number}"
    taken.add(found)
    return found


def ports_in(model: rtm.RuntimeModel) -> Iterator[tuple[rtm.Place, rtm.PlacePort]]:
    """Yield the places with ports, and each port with it."""
    for place in places(model):
        if isinstance(place, rtm.Place):
            for port in place.ports:
                yield place, port


def is_within(element: EObject | None, root: EObject) -> bool:
    """Return whether an object is another one, or part of it."""
    while element is not None and element is not root:
        element = element.eContainer()
    return element is root
