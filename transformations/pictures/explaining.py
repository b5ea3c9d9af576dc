"""Explains elements by the trace of a flattening: how an element was made, and its results, by id."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.constraints.wording import kind_of
from dineros.metamodel.elements import elements
from dineros.metamodel.errors import UnknownElementError, near_matches
from dineros.transformations.flattening.flatten import KEPT
from dineros.transformations.flattening.traces import Link, Trace
from dineros.transformations.rules.catalogue import name_of


@dataclass(frozen=True)
class Explanation:
    """The trace entries for an id."""

    origin: Link | None
    """How the element of the flattened net with this id was made; None if the net has no such element."""
    source: pn.Element | None
    """The element of the system model with this id."""
    results: list[Link]
    """The elements made from `source` or from its parts."""


def explain(id: str, model: sym.SystemModel, trace: Trace) -> Explanation:
    """Explain how the element with an id was made, and what was made from it, in both models.

    Raises
    ------
    UnknownElementError
        Neither model has an element with this id.
    """
    origin = next((link for link in trace if link.target.id == id), None)
    source = next((element for element in elements(model) if element.id == id), None)
    if origin is None and source is None:
        known = {**dict.fromkeys(e.id for e in elements(model)), **dict.fromkeys(k.target.id for k in trace)}
        raise UnknownElementError(
            f"no element of either model has the id {id!r}", hint=near_matches(id, known)
        )
    return Explanation(origin, source, [] if source is None else list(_results(source, trace)))


def _results(source: pn.Element, trace: Trace) -> Iterator[Link]:
    """Yield the elements made from an element, its ports or its clause, each once."""
    causes: set[EObject] = {source}
    if isinstance(source, (sym.Channel, sym.Transition)):
        causes.update(source.eAllContents())
    for link in trace:
        if any(cause in causes for cause in link.sources):
            yield link


def told(element: EObject) -> str:
    """Return a name for an element of a system model, even if it has no id of its own."""
    kind = kind_of(element)
    if isinstance(element, (sym.ClientPort, sym.ActionClientPort)):
        return f"{kind} {element.client}"
    if isinstance(element, sym.TopicPort):
        return f"{kind} at {element.place.id}"
    identity = getattr(element, "id", None)
    if identity:
        return f"{kind} {identity}"
    container = element.eContainer()
    if container is None:
        return kind
    if isinstance(element, (sym.InputClause, sym.ServerPort, sym.ActionServerPort)):
        return f"{kind} of {told(container)}"
    feature = element.eContainmentFeature()
    number = f" {list(getattr(container, feature.name)).index(element) + 1}" if feature.many else ""
    return f"{kind}{number} of {told(container)}"


def origin_text(link: Link) -> str:
    """Describe on one line how an element was made."""
    kind = kind_of(link.target)
    sources = ", ".join(_told(source, link) for source in link.sources)
    instance = f", server instance {link.index}" if link.index is not None else ""
    if link.rule == KEPT:
        return f"{kind} kept from the system model"
    made = f"{kind} made by {name_of(link.rule)} as {link.role}"
    return f"{made} from {sources}{instance}" if sources else f"{made} from elements that other rules made"


def _told(source: EObject, link: Link) -> str:
    """Return a name for a source; a client on a server page with its instance."""
    if isinstance(source, sym.ClientPort) and link.client_index is not None:
        return f"{told(source)} of server instance {link.client_index}"
    return told(source)
