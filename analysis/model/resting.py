"""Where tokens of an application rest: final places, unused instances, nodes that are shut down."""

from __future__ import annotations

from dineros.analysis.model.subject import Subject
from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.groups import callback_page_of
from dineros.metamodel.calls import Served
from dineros.metamodel.elements import node_net_of


def not_final(subject: Subject) -> dict[int, sym.NodeNet | None]:
    """Return the places that are not of the kind `end`, in nodes that have such places, with their nodes.

    Where a callback ends, its page says; that is not a place of the node's own.
    """
    found: dict[int, sym.NodeNet | None] = {}
    ended: set[sym.NodeNet | None] = set()
    for link in subject.links():
        place = link.sources[0] if link.sources and link.meaning is None else None
        if not isinstance(place, sym.Place) or not isinstance(link.target, pn.Place):
            continue
        if callback_page_of(place) is None:
            node = node_net_of(place)
            if place.kind == sym.PlaceKind.end:
                ended.add(node)
            else:
                found[subject.place_index[link.target.id]] = node
    return {place: node for place, node in sorted(found.items()) if node in ended}


def unused_marks(subject: Subject) -> dict[int, int]:
    """Return, by transition of a server instance, the place that is marked while the instance is not used."""
    pages: dict[object, tuple[str, int | None]] = {}
    marks: dict[tuple[str, int | None], int] = {}
    for link in subject.links():
        if link.meaning is not None and link.meaning.part in ("inactive", "idle slot"):
            channel = next(each for each in link.sources if isinstance(each, Served))
            marks[channel.id, link.index] = subject.place_index[link.target.id]
            pages.update(
                ((part, link.index), (channel.id, link.index))
                for part in channel.server.page.eAllContents()
                if isinstance(part, sym.Transition)
            )
    return {
        subject.transition_index[link.target.id]: marks[pages[source, link.index]]
        for link in subject.links()
        for source in link.sources  # a step of a callback with a duration has the page before it
        if (source, link.index) in pages and isinstance(link.target, pn.Transition)
    }


def shut_down_marks(subject: Subject) -> dict[sym.NodeNet, int]:
    """Return, by managed node, the place that is marked once it is shut down, which it is forever."""
    return {
        node: subject.place_index[link.target.id]
        for link in subject.links()
        if link.rule == "L1" and link.role == "finalized"
        for node in link.sources
        if isinstance(node, sym.NodeNet)
    }


def doers(subject: Subject) -> dict[int, sym.NodeNet]:
    """Return the managed nodes of transitions: of their own, and of what their clients do."""
    found: dict[int, sym.NodeNet] = {}
    for link in subject.links():
        if not isinstance(link.target, pn.Transition):
            continue
        step = None if link.meaning is None else link.meaning.step
        elements: list[pn.Node]
        if step is None:
            elements = [each for each in link.sources if isinstance(each, sym.Transition)]
        elif step.declared.end == "client":
            elements = [
                each.request if isinstance(each, sym.ClientPort) else each.goal
                for each in link.sources
                if isinstance(each, (sym.ClientPort, sym.ActionClientPort))
            ]
        else:
            continue
        nodes = {node_net_of(each) for each in elements}
        if len(nodes) == 1 and (node := nodes.pop()) is not None and node.lifecycle is not None:
            found[subject.transition_index[link.target.id]] = node
    return found
