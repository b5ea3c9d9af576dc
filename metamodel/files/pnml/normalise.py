"""Bringing a file's records into the shape of the metamodel.

Files of the DiNeROS extension may keep all elements on one page and name node net and subnet of each, and may
keep arcs on other pages than their ends. In the metamodel a node net is a page, and an arc is on the page
of both its ends.
"""

from __future__ import annotations

from collections import Counter
from typing import TypeAlias

from dineros.metamodel.errors import ModelFileError, near_matches
from dineros.metamodel.files.pnml.records import (
    ArcRecord,
    NetRecord,
    NodeRecord,
    PageRecord,
    move,
)
from dineros.metamodel.files.pnml.source import Source

Ends: TypeAlias = dict[ArcRecord, tuple[NodeRecord, NodeRecord]]
Moves: TypeAlias = list[tuple[PageRecord | NodeRecord, PageRecord]]


def normalise(net: NetRecord, source: Source) -> None:
    """Join read arcs, make node nets and subnets pages, and put every arc where its ends are.

    Raises
    ------
    ModelFileError
        An arc has no source or target, or an element names another node than the node page it is on.
    """
    _join_read_arcs(net)
    ends = _ends(net, source)
    source.refuse_errors()
    _group_nodes(net, ends, source)
    _group_subnets(net)
    _place_arcs(net, ends)


def _join_read_arcs(net: NetRecord) -> None:
    """Make one read arc of two normal ones that our own blocks mark as its halves."""
    joined = set()
    for half in net.arcs:
        arc = net.ids.get(half.extension.mark("half") or "")
        if not isinstance(arc, ArcRecord) or arc.extension.mark("kind") != "read":
            continue
        if (arc.source, arc.target, arc.weight) == (half.target, half.source, half.weight):
            arc.kind = "read"
            joined.add(half)
    net.arcs = [arc for arc in net.arcs if arc not in joined]
    for half in joined:
        del net.ids[half.id]


def _ends(net: NetRecord, source: Source) -> Ends:
    """Return the nodes that each arc joins, and complain about ends that are not there."""
    ends: Ends = {}
    for arc in net.arcs:
        try:
            ends[arc] = _end(arc, arc.source, net, source), _end(arc, arc.target, net, source)
        except ModelFileError as error:
            source.errors.append(error)
    return ends


def _end(arc: ArcRecord, id: str, net: NetRecord, source: Source) -> NodeRecord:
    node = net.ids.get(id)
    if not isinstance(node, NodeRecord):
        what = "which does not exist" if node is None else "which is not a place or transition"
        hint = near_matches(id, [each.id for each in net.root.nodes()])
        raise source.error(f"arc {arc.id!r} ends at {id!r}, {what}", arc.xml, id=arc.id, hint=hint)
    if node.is_channel:
        hint = "a channel is joined to node nets by the places that its ports name"
        raise source.error(f"arc {arc.id!r} ends at the {node.kind} {id!r}", arc.xml, id=arc.id, hint=hint)
    return node


# ---------------------------------------------------------------------------------- node nets and subnets


def _group_nodes(net: NetRecord, ends: Ends, source: Source) -> None:
    """Gather the elements that name a node but are not on a node page."""
    members: dict[str, list[NodeRecord]] = {}
    unnamed: set[NodeRecord] = set()
    for node in net.root.nodes():
        name = node.extension.text("node")
        around = _page(node).node_net
        if node.is_channel:
            continue
        if around is not None:
            _check_node(node, name, around, source)
        elif name is not None:
            members.setdefault(name, []).append(node)
        elif node.ref is not None:
            unnamed.add(node)
    if unnamed and members:
        _follow_arcs(unnamed, members, ends)
    totals = _totals(net.root)
    known: dict[str, PageRecord] = {}
    for page in [page for page in net.root.pages() if page.kind == "node"]:
        known.setdefault(page.label, page)
        known.setdefault(page.id, page)
    moves: Moves = []
    for name, nodes in members.items():
        page = known.get(name) or _page_of_node(name, nodes, totals, net)
        moves += _gather(nodes, page, totals, net)
    move(moves)


def _totals(root: PageRecord) -> Counter[PageRecord]:
    """Count the nodes on every page and the pages inside it, without channels."""
    return Counter(page for node in root.nodes() if not node.is_channel for page in _page(node).around())


def _check_node(node: NodeRecord, name: str | None, around: PageRecord, source: Source) -> None:
    if name is not None and not around.is_called(name):
        where = node.extension.fields["node"]
        hint = f"it is on the node page {around.id!r}; move it or change its <node>"
        raise source.error(f"{node.id!r} names the node {name!r}", where, id=node.id, hint=hint)


def _follow_arcs(unnamed: set[NodeRecord], members: dict[str, list[NodeRecord]], ends: Ends) -> None:
    """Let a reference that names no node belong to the one node whose elements it is joined to."""
    node_of = {node: name for name, nodes in members.items() for node in nodes}
    joined: dict[NodeRecord, set[str]] = {}
    for start, end in ends.values():
        for node, other in ((start, end), (end, start)):
            if node in unnamed and other in node_of:
                joined.setdefault(node, set()).add(node_of[other])
    for node, names in joined.items():
        if len(names) == 1:
            members[names.pop()].append(node)


def _page_of_node(
    name: str, nodes: list[NodeRecord], totals: Counter[PageRecord], net: NetRecord
) -> PageRecord:
    """Turn the page that holds just the elements of a node into its node page, or insert one."""
    host = _smallest_page(nodes)
    if host.kind == "page" and totals[host] == len(nodes) and host.name in (None, name):
        host.kind = "node"
        host.name = name if host.id != name else host.name
        return host
    return _insert_page(name, "node", host, net)


def _group_subnets(net: NetRecord) -> None:
    """Gather the elements of a node net that name a subnet but are not on a page of that name."""
    totals = _totals(net.root)
    for node_net in [page for page in net.root.pages() if page.kind == "node"]:
        members: dict[str, list[NodeRecord]] = {}
        for node in node_net.nodes():
            subnet = node.extension.text("subnet")
            if subnet is None or node.is_channel or _page(node).node_net is not node_net:
                continue
            # Flat files may use the node's own name for what is in no real subnet.
            around = [*_inside(_page(node), node_net), node_net]
            if not any(page.is_called(subnet) for page in around):
                members.setdefault(subnet, []).append(node)
        known: dict[str, PageRecord] = {}
        for page in [page for page in node_net.pages() if page is not node_net] if members else ():
            known.setdefault(page.label, page)
            known.setdefault(page.id, page)
        moves: Moves = []
        for subnet, nodes in members.items():
            page = known.get(subnet) or _insert_page(subnet, "page", _smallest_page(nodes), net)
            moves += _gather(nodes, page, totals, net)
        move(moves)


def _inside(page: PageRecord, outer: PageRecord) -> list[PageRecord]:
    """Return the page and the pages around it up to, but without, an outer page."""
    result = []
    for each in page.around():
        if each is outer:
            break
        result.append(each)
    return result


def _insert_page(name: str, kind: str, host: PageRecord, net: NetRecord) -> PageRecord:
    id = net.unique(name)
    page = PageRecord(id, None, host, name=None if id == name else name, kind=kind)
    net.insert(page)
    return page


def _smallest_page(nodes: list[NodeRecord]) -> PageRecord:
    """Return the innermost page (or the net) around all of these nodes."""
    common = list(_page(nodes[0]).around())
    for page in {_page(node) for node in nodes}:
        around = set(page.around())
        common = [each for each in common if each in around]
    return common[0]


def _gather(nodes: list[NodeRecord], into: PageRecord, totals: Counter[PageRecord], net: NetRecord) -> Moves:
    """Return how to move nodes to a page so that the pages they are on are kept inside it.

    A page whose nodes all move is moved itself; one that is shared stays, and has a copy inside the new page.
    """
    host = _smallest_page(nodes)
    if into in host.around():  # the nodes stand inside already
        return []
    moving = Counter(page for node in nodes for page in _inside(_page(node), host))
    around = set(into.around())
    copies: dict[PageRecord, PageRecord] = {}
    moves: Moves = []
    whole: set[PageRecord] = set()
    for node in nodes:
        target = into
        for page in reversed(_inside(_page(node), host)):
            if page in whole:
                break
            if page in around:
                continue
            if moving[page] == totals[page]:
                whole.add(page)
                moves.append((page, target))
                break
            target = _copy(page, target, copies, net)
        else:
            moves.append((node, target))
    return moves


def _copy(
    page: PageRecord, target: PageRecord, copies: dict[PageRecord, PageRecord], net: NetRecord
) -> PageRecord:
    if page not in copies:
        id = net.unique(f"{page.id}.{target.label}")
        copies[page] = PageRecord(id, None, target, name=page.label)
        net.insert(copies[page])
    return copies[page]


# --------------------------------------------------------------------------------------------------- arcs


def _place_arcs(net: NetRecord, ends: Ends) -> None:
    """Put arcs on the page of their ends; within a node net, insert a reference place where those differ."""
    references: dict[tuple[str, PageRecord], NodeRecord] = {}
    for node in net.root.nodes():
        if node.is_place and node.ref is not None:
            references.setdefault((node.ref, _page(node)), node)
    for arc, (start, end) in ends.items():
        if start.page is end.page:
            arc.page = end.page
        elif start.is_place != end.is_place and _page(start).node_net is _page(end).node_net:
            place, transition = (start, end) if start.is_place else (end, start)
            reference = _reference(place, _page(transition), references, net)
            arc.page = reference.page
            if start.is_place:
                arc.source = reference.id
            else:
                arc.target = reference.id


def _reference(
    place: NodeRecord,
    page: PageRecord,
    references: dict[tuple[str, PageRecord], NodeRecord],
    net: NetRecord,
) -> NodeRecord:
    reference = references.get((place.id, page))
    if reference is None:
        id = net.unique(f"{place.id}.{page.id}")
        reference = references[place.id, page] = NodeRecord(
            id, None, page, kind="referencePlace", ref=place.id
        )
        net.insert(reference)
    return reference


def _page(node: NodeRecord) -> PageRecord:
    assert node.page is not None
    return node.page
