"""Builds the view of a model: drawn elements and their summaries."""

from __future__ import annotations

from collections.abc import Iterator

from dineros.metamodel import elements, pn, pnm, rtm, sym
from dineros.metamodel.clauses import start_value
from dineros.metamodel.elements import label
from dineros.metamodel.lifecycles.states import STATES
from dineros.views.nets.contents.channels import draw_channels, draw_ports
from dineros.views.nets.contents.glyphs import finish_box, finish_edge_label, finish_node
from dineros.views.nets.contents.groups import group_by_name
from dineros.views.nets.contents.model import (
    Box,
    BoxKind,
    Caption,
    Edge,
    EdgeKind,
    Node,
    NodeKind,
    Signal,
    ViewModel,
)
from dineros.views.nets.contents.positions import of_page, points_of, position_of
from dineros.views.nets.contents.times import interval_words

_KINDS = {
    sym.SystemModel: "system model",
    rtm.RuntimeModel: "runtime model",
    pnm.PetriNetModel: "Petri-net model",
}
_ARCS: dict[str, EdgeKind] = {"normal": "normal", "read": "read", "inhibitor": "inhibitor"}
_CALLBACKS: dict[str, tuple[BoxKind, str]] = {
    "timer": ("timer", "timer callback"),
    "subscriber": ("subscriber", "subscriber callback"),
    "client": ("subscriber", "response callback"),
    "goal": ("server", "callback that works on goals"),
    "server": ("server", "server callback"),
}


def view_of(model: pn.Net) -> ViewModel:
    """Return the view of a system model, run-time model, Petri-net model or plain net.

    Everything of the model is in it; `dineros.views.nets.contents.operations` shows less of it. Two opposite
    arcs of one weight are one edge, a read arc. A page that holds everything is left out.

    Parameters
    ----------
    model : pn.Net
        The model; it is not changed, and need not be valid.
    """
    view = ViewModel(model.id, label(model), _KINDS.get(type(model), "Petri net"))
    outer = _only_page(model)
    for page in elements.pages(model):
        if page is not outer:
            view.boxes.append(_box(page, outer))
    for node in elements.nodes(model):
        view.nodes.append(_node(node, outer))
    view.edges = list(_edges(model))
    for reference in elements.nodes(model):
        if (
            isinstance(reference, (pn.ReferencePlace, pn.ReferenceTransition))
            and reference.target is not None
        ):
            target = reference.target
            view.edges.append(Edge(f"{reference.id} => {target.id}", target.id, reference.id, "reference"))
    if isinstance(model, sym.SystemModel):
        draw_channels(model, view)
    elif isinstance(model, rtm.RuntimeModel):
        draw_ports(model, view)
    elif isinstance(model, pnm.PetriNetModel) and not any(node.position for node in view.nodes):
        group_by_name(view)  # what an editor arranged stays as it is
    return finished(view)


def finished(view: ViewModel) -> ViewModel:
    """Set sizes, glyphs and summaries; call it whenever texts of a view have changed."""
    for node in view.nodes:
        finish_node(node)
    inner = _inner_boxes(view)
    for box in view.boxes:
        box.summary = _summary(view, inner[box.id])
        finish_box(box)
    for edge in view.edges:
        edge.room = finish_edge_label(edge.label)
    return view


def _only_page(model: pn.Net) -> pn.Page | None:
    """Return the page that contains everything, if it has no content of its own."""
    pages = list(model.pages)
    if len(pages) == 1 and not isinstance(pages[0], (sym.NodeNet, sym.CallbackPage)):
        return pages[0]
    return None


def _box_of(element: pn.PageObject, outer: pn.Page | None) -> str | None:
    page = element.page
    return None if page is None or page is outer else page.id


def _box(page: pn.Page, outer: pn.Page | None) -> Box:
    box = Box(page.id, "page", label(page), "page", _box_of(page, outer))
    box.position, box.frame = of_page(page)
    if isinstance(page, sym.NodeNet):
        box.kind = "node"
        threads = f", {page.threads} threads" if page.executor == sym.Executor.multi else ""
        box.subtitle = f"{'managed ' if page.lifecycle is not None else ''}ROS node{threads}"
        box.states = list(STATES) if page.lifecycle is not None else []
        box.signals = [
            Signal(each.id, label(each), bool(each.initial), str(start_value(each)) if each.values else None)
            for each in page.signals
        ]
        box.detail = {"ROS package": page.package or label(page)}
        if page.namespace:
            box.detail["Namespace"] = page.namespace
        if page.reaction is not None:
            box.subtitle += f", reacts in {interval_words(page.reaction)}"
    elif isinstance(page, sym.CallbackPage):
        box.kind, box.subtitle = _CALLBACKS[str(page.kind)]
        if page.timer is not None:
            box.subtitle += f" every {page.timer:g} s"
        if page.duration is not None:
            box.subtitle += f", takes {interval_words(page.duration)}"
        if page.awaits:
            box.subtitle += ", awaits"
        if page.offset is not None:
            box.detail["First strike"] = f"after {interval_words(page.offset)}"
        if page.jitter:
            box.detail["Jitter"] = interval_words(pn.TimeInterval(latest=page.jitter))
        if page.group is not None:
            box.detail["Callback group"] = f"{label(page.group)} ({page.group.kind})"
        if page.priority:
            box.detail["Priority"] = str(page.priority)
    return box


def _node(element: pn.Node, outer: pn.Page | None) -> Node:
    kind: NodeKind
    node = Node(element.id, "place", label(element), _box_of(element, outer))
    node.position = position_of(element)
    node.captions = [Caption(node.label)]
    if isinstance(element, pn.Place):
        node.tokens = element.tokens
        if isinstance(element, sym.Place):
            _describe_place(element, node)
    elif isinstance(element, pn.Transition):
        node.kind = "transition"
        _describe_transition(element, node)
    else:
        kind = "place-reference" if isinstance(element, pn.ReferencePlace) else "transition-reference"
        node.kind = kind
        target = element.target if isinstance(element, (pn.ReferencePlace, pn.ReferenceTransition)) else None
        if target is not None:
            node.detail["Reference to"] = target.id
            node.target = _end_of_references(target)
    return node


def _end_of_references(node: pn.Node) -> str:
    """Return the id of the end of a chain of references, or of the first one that repeats."""
    met: list[pn.Node] = []
    following: pn.Node | None = node
    while following is not None and following not in met:
        node = following
        met.append(node)
        is_reference = isinstance(node, (pn.ReferencePlace, pn.ReferenceTransition))
        following = getattr(node, "target", None) if is_reference else None
    return str((following or node).id)


def _describe_place(place: sym.Place, node: Node) -> None:
    if place.kind != sym.PlaceKind.ordinary:
        node.captions.append(Caption(f"{place.kind} place", "note"))
    if place.tokenType is not None:
        node.detail["Token type"] = label(place.tokenType)
    data = [balloon.data for balloon in place.balloons]
    if data:
        more = f" and {len(data) - 3} more" if len(data) > 3 else ""
        node.detail["Token data"] = ", ".join(data[:3]) + more


def _describe_transition(transition: pn.Transition, node: Node) -> None:
    interval = transition.interval
    if interval is not None:
        is_open_above = interval.latest is None or interval.latestExcluded
        left, right = "]" if interval.earliestExcluded else "[", "[" if is_open_above else "]"
        latest = "∞" if interval.latest is None else f"{interval.latest:g}"
        unit = " s" if isinstance(transition, sym.Transition) else ""
        node.captions.append(Caption(f"{left}{interval.earliest:g}, {latest}{right}{unit}", "note"))
    if transition.overrides:
        node.detail["Goes before"] = ", ".join(lower.id for lower in transition.overrides)
    if isinstance(transition, sym.Transition):
        if transition.kind not in (sym.TransitionKind.discrete, sym.TransitionKind.timed):
            node.captions.append(Caption(f"{transition.kind} transition", "note"))
        if transition.duration is not None:
            node.captions.append(Caption(f"takes {interval_words(transition.duration)}", "note"))
        clause = transition.clause
        if clause is not None:
            node.captions.append(Caption(clause.text, "clause"))
            node.detail["Input clause"] = f"{clause.name}: {clause.text}" if clause.name else clause.text
        if transition.guard:
            node.captions.append(Caption(f"[{transition.guard}]", "clause"))
        if transition.assigns:
            node.captions.append(Caption(transition.assigns, "clause"))


def _edges(model: pn.Net) -> Iterator[Edge]:
    """Yield the arcs, a pair of opposite ones as one read arc."""
    for page in elements.pages(model):
        arcs = {(arc.source, arc.target): arc for arc in page.arcs if arc.kind == pn.ArcKind.normal}
        paired: set[pn.Arc] = set()
        for arc in page.arcs:
            source, target = (getattr(end, "id", None) for end in (arc.source, arc.target))
            if arc in paired or source is None or target is None:
                continue
            edge = Edge(arc.id, source, target, _ARCS[str(arc.kind)], weight=arc.weight)
            edge.label = str(arc.weight) if arc.weight != 1 else ""
            edge.bends = points_of(arc)
            back = arcs.get((arc.target, arc.source))
            if back is not None and arcs.get((arc.source, arc.target)) is arc and back.weight == arc.weight:
                paired.add(back)
                edge.kind, edge.also = "read", back.id
                if isinstance(arc.source, pn.TransitionNode):
                    edge.source, edge.target = edge.target, edge.source
                    edge.bends.reverse()
            yield edge


def _inner_boxes(view: ViewModel) -> dict[str, set[str]]:
    """Return for each box the box itself and all nested boxes."""
    inner = {box.id: {box.id} for box in view.boxes}
    parents = {box.id: box.parent for box in view.boxes}
    for box in view.boxes:
        parent = box.parent
        while parent is not None:
            inner[parent].add(box.id)
            parent = parents[parent]
    return inner


def _summary(view: ViewModel, boxes: set[str]) -> str:
    kinds = [node.kind for node in view.nodes if node.box in boxes]
    counts = [
        _count(kinds.count("place"), "place"),
        _count(kinds.count("transition"), "transition"),
        _count(len(boxes) - 1, "page"),
        _count(sum(node.change is not None for node in view.nodes if node.box in boxes), "difference"),
    ]
    return ", ".join(filter(None, counts)) or "empty"


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}" if number else ""
