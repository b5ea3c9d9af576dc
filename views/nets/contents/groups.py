"""Groups in flattened nets, which have no pages: elements with a common prefix of ids form a group."""

from __future__ import annotations

from dineros.views.nets.contents.model import Box, ViewModel

SMALLEST = 3
"""Least number of elements of a group."""


def group_by_name(view: ViewModel) -> None:
    """Put nodes with equal ids before the last dot into a box, and nest these boxes.

    ``LeftCellObjects.publisher.SortRed.Load`` is in the group ``publisher.SortRed`` of the group
    ``LeftCellObjects``.
    """
    paths = {node.id: tuple(node.id.split(".")[:-1]) for node in view.nodes if node.box is None}
    sizes: dict[tuple[str, ...], int] = {}
    for path in paths.values():
        for length in range(1, len(path) + 1):
            sizes[path[:length]] = sizes.get(path[:length], 0) + 1
    direct = set(paths.values())
    kept: dict[tuple[str, ...], Box] = {}
    for path, size in sizes.items():  # outer before inner, since a path's start is met first
        outer = next((path[:length] for length in range(len(path) - 1, 0, -1) if path[:length] in kept), ())
        holds_nodes = len(path) == 1 or path in direct
        if size >= SMALLEST and size != sizes.get(outer) and holds_nodes:
            name = ".".join(path[len(outer) :])
            parent = kept[outer].id if outer else None
            kept[path] = Box(_id(path), "group", name, "", parent)
    view.boxes = list(kept.values())
    for node in view.nodes:
        path = paths.get(node.id, ())
        home = next((path[:length] for length in range(len(path), 0, -1) if path[:length] in kept), None)
        if home is not None:
            node.box = kept[home].id
            node.captions[0].text = node.label.removeprefix(".".join(home) + ".")


def _id(path: tuple[str, ...]) -> str:
    return f"group {'.'.join(path)}"
