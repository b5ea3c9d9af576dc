"""Two models in one picture, with added, removed and changed elements."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TypeVar

from dineros.views.nets.contents.building import finished
from dineros.views.nets.contents.model import Box, Caption, Edge, Node, ViewModel
from dineros.views.nets.differences.aligning import align

Item = TypeVar("Item", Box, Node, Edge)

_SAID = {
    Node: ("kind", "label", "box", "captions", "tokens", "target", "detail"),
    Box: ("kind", "title", "subtitle", "parent", "signals", "detail"),
    Edge: ("kind", "source", "target", "label", "weight"),
}
_WORDS = {"label": "name", "title": "name", "box": "page", "parent": "page", "subtitle": "kind"}


def compare(before: ViewModel, after: ViewModel) -> ViewModel:
    """Return one view of two models; elements are matched by id.

    Elements of only one model are marked as added or removed; different elements are shown in their new form,
    marked as changed, with notes about the old form.

    Parameters
    ----------
    before, after : ViewModel
        The views of the two models; they stay as they are.
    """
    view = ViewModel(
        after.id,
        after.title if after.title == before.title else f"{before.title} → {after.title}",
        after.kind,
        _union(before.boxes, after.boxes),
        _union(before.nodes, after.nodes),
        _union(before.edges, after.edges),
        compared=True,
    )
    _keep_ends(view)
    return align(before, finished(view))


def differences(view: ViewModel) -> dict[str, list[str]]:
    """Return the ids of added, removed and changed elements of a comparison."""
    found: dict[str, list[str]] = {"added": [], "removed": [], "changed": []}
    for item in view.elements():
        if item.change is not None:
            found[item.change].append(item.id)
    return found


def _union(before: Sequence[Item], after: Sequence[Item]) -> list[Item]:
    old = {item.id: item for item in before}
    result: list[Item] = []
    for item in after:
        was = old.pop(item.id, None)
        if was is None:
            result.append(dataclasses.replace(item, change="added"))
        else:
            notes = _notes(was, item)
            result.append(dataclasses.replace(item, change="changed", notes=notes) if notes else item)
    return result + [dataclasses.replace(item, change="removed") for item in old.values()]


def _notes(was: Item, now: Item) -> list[str]:
    """Describe the differences."""
    notes = []
    for name in _SAID[type(now)]:
        one, other = getattr(was, name), getattr(now, name)
        if one == other:
            continue
        if name == "detail":
            keys = [key for key in {**one, **other} if one.get(key) != other.get(key)]
            notes += [f"{key}: {_text(one.get(key))} → {_text(other.get(key))}" for key in keys]
        elif name == "captions":
            notes.append(f"text: {_captions(one)} → {_captions(other)}")
        elif name == "label" and type(now) is Edge:
            notes.append(f"{_text(one)} → {_text(other)}")
        else:
            notes.append(f"{_WORDS.get(name, name)}: {_text(one)} → {_text(other)}")
    return notes


def _captions(captions: Sequence[Caption]) -> str:
    return ", ".join(caption.text for caption in captions) or "none"


def _text(value: object) -> str:
    if isinstance(value, list):
        return ", ".join(f"{one.label}{' (true)' if one.initial else ''}" for one in value) or "none"
    return "none" if value in (None, "") else str(value)


def _keep_ends(view: ViewModel) -> None:
    """Drop lines without ends; put boxes after those that contain them."""
    nodes = {node.id for node in view.nodes}
    view.edges = [edge for edge in view.edges if edge.source in nodes and edge.target in nodes]
    by_id = {box.id: box for box in view.boxes}
    sorted_boxes: dict[str, Box] = {}

    def put(box: Box) -> None:
        if box.id in sorted_boxes:
            return
        if box.parent in by_id:
            put(by_id[box.parent])
        sorted_boxes[box.id] = box

    for box in view.boxes:
        put(box)
    view.boxes = list(sorted_boxes.values())
