"""What must hold for every laid-out net, whatever laid it out."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import TypeAlias

from dineros.views.nets.placement.picture import Picture, PlacedEdge, PlacedShape

Area: TypeAlias = tuple[float, float, float, float]
"""Left, top, right, bottom."""
SLACK = 1.0


def box_area(box: PlacedShape) -> Area:
    return box["x"], box["y"], box["x"] + box["width"], box["y"] + box["height"]


def node_area(node: PlacedShape) -> Area:
    """Return what a node covers, with its captions."""
    left, top, right, bottom = shape_area(node)
    (wide, down), (x, y) = node.get("room", (0, 0)), node.get("captionAt", (0, 0))
    middle = node["x"] + x
    return (
        min(left, middle - wide / 2),
        min(top, bottom + y),
        max(right, middle + wide / 2),
        max(bottom, bottom + y + down),
    )


def shape_area(node: PlacedShape) -> Area:
    side, half = node["width"] / 2, node["height"] / 2
    return node["x"] - side, node["y"] - half, node["x"] + side, node["y"] + half


def label_area(edge: PlacedEdge) -> Area:
    (x, y), (wide, high) = edge["labelAt"], edge["room"]
    return x - wide / 2, y - high / 2, x + wide / 2, y + high / 2


def overlap(one: Area, other: Area) -> bool:
    across = min(one[2], other[2]) - max(one[0], other[0])
    along = min(one[3], other[3]) - max(one[1], other[1])
    return across > SLACK and along > SLACK


def within(inner: Area, outer: Area) -> bool:
    return (
        inner[0] >= outer[0] - SLACK
        and inner[1] >= outer[1] - SLACK
        and inner[2] <= outer[2] + SLACK
        and inner[3] <= outer[3] + SLACK
    )


def faults(picture: Picture) -> Iterator[str]:
    """Yield what is wrong with a layout: overlaps, things outside of their boxes, lines that end nowhere."""
    whole: Area = (0, 0, picture["width"], picture["height"])
    boxes = {box["id"]: box for box in picture["boxes"]}
    nodes = {node["id"]: node for node in picture["nodes"]}
    siblings: dict[str | None, list[tuple[str, Area]]] = {}
    for id, box in boxes.items():
        siblings.setdefault(box.get("parent"), []).append((id, box_area(box)))
    for id, node in nodes.items():
        siblings.setdefault(node.get("box"), []).append((id, node_area(node)))
    for parent, children in siblings.items():
        around = whole if parent is None else box_area(boxes[parent])
        for id, area in children:
            if not within(area, around):
                yield f"{id} stands out of {parent or 'the picture'}"
        for (id, area), (other_id, other) in itertools.combinations(children, 2):
            if overlap(area, other):
                yield f"{id} and {other_id} overlap"
    for box in boxes.values():
        if not box.get("collapsed"):
            header = (box["x"], box["y"], box["x"] + box["header"][0], box["y"] + box["header"][1])
            if not within(header, box_area(box)):
                yield f"the title of {box['id']} stands out of it"
            for id, area in siblings.get(box["id"], ()):
                if overlap(area, header):
                    yield f"{id} covers the title of {box['id']}"
    for edge in picture["edges"]:
        yield from line_faults(edge, nodes, boxes, whole)


def line_faults(
    edge: PlacedEdge, nodes: dict[str, PlacedShape], boxes: dict[str, PlacedShape], whole: Area
) -> Iterator[str]:
    points = edge["points"]
    if len(points) < 2:
        yield f"{edge['id']} is not a line"
        return
    for point, end in ((points[0], edge["source"]), (points[-1], edge["target"])):
        area = shape_area(nodes[end]) if end in nodes else box_area(boxes[end])
        x, y = point
        if not within((x, y, x, y), area):
            yield f"{edge['id']} does not reach {end}"
        if end in nodes and nodes[end]["kind"].startswith("place"):
            distance = ((x - nodes[end]["x"]) ** 2 + (y - nodes[end]["y"]) ** 2) ** 0.5
            if abs(distance - nodes[end]["width"] / 2) > SLACK:
                yield f"{edge['id']} ends {distance:.1f} from the middle of {end}"
    for x, y in points:
        if not within((x, y, x, y), whole):
            yield f"{edge['id']} leaves the picture"
    if edge.get("label"):
        if "labelAt" not in edge:
            yield f"the label of {edge['id']} is missing"
        elif not within(label_area(edge), whole):
            yield f"the label of {edge['id']} leaves the picture"
        else:
            for node in nodes.values():
                if overlap(label_area(edge), node_area(node)):
                    yield f"the label of {edge['id']} covers {node['id']}"


def label_overlaps(picture: Picture) -> list[str]:
    """Return the pairs of labels of lines that cover each other."""
    labelled = [edge for edge in picture["edges"] if edge.get("label")]
    return [
        f"{one['id']} and {other['id']}"
        for one, other in itertools.combinations(labelled, 2)
        if overlap(label_area(one), label_area(other))
    ]


def crossed(picture: Picture) -> Iterator[str]:
    """Yield the lines that run through something else than what they join."""
    nodes = {node["id"]: shape_area(node) for node in picture["nodes"]}
    nodes |= {box["id"]: box_area(box) for box in picture["boxes"] if box.get("collapsed")}
    for edge in picture["edges"]:
        for id, area in nodes.items():
            if id in (edge["source"], edge["target"]):
                continue
            for one, other in itertools.pairwise(edge["points"]):
                if enters(one, other, area):
                    yield f"{edge['id']} runs through {id}"
                    break


def enters(one: list[float], other: list[float], area: Area) -> bool:
    """Tell whether a piece of a line is inside of an area for more than a moment."""
    enters, leaves = 0.0, 1.0
    for axis in (0, 1):
        start, way = one[axis], other[axis] - one[axis]
        low, high = area[axis] + SLACK, area[axis + 2] - SLACK
        if abs(way) < 1e-9:
            if not low < start < high:
                return False
            continue
        first, second = sorted(((low - start) / way, (high - start) / way))
        enters, leaves = max(enters, first), min(leaves, second)
    return leaves - enters > 1e-6
