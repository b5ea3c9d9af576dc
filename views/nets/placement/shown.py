"""The visible part of a view: collapsed boxes hide their content. On pages `static/net/shown.js` does so."""

from __future__ import annotations

from typing import Any


def visible(view: dict[str, Any]) -> dict[str, Any]:
    """Return the view without what collapsed boxes hide; their lines end at the boxes.

    Parameters
    ----------
    view : dict
        What `ViewModel.to_json` returns.

    Returns
    -------
    dict
        A view; lines that stand for others name those in `stands`.
    """
    boxes = {box["id"]: box for box in view["boxes"]}

    def stand_in(id: str | None) -> str | None:
        """Return the outermost collapsed box around a box, itself included."""
        if id is None:
            return None
        box = boxes[id]
        return stand_in(box.get("parent")) or (id if box.get("collapsed") else None)

    home = {node["id"]: stand_in(node.get("box")) or node["id"] for node in view["nodes"]}
    edges: list[dict[str, Any]] = []
    merged: dict[tuple[str, str, str, str], dict[str, Any]] = {}
    for edge in view["edges"]:
        source, target = home.get(edge["source"]), home.get(edge["target"])
        if source is None or target is None:
            continue
        if source == edge["source"] and target == edge["target"]:
            edges.append(edge)
        elif source != target:
            key = (edge["kind"], source, target, edge.get("change", ""))
            if key in merged:
                known = merged[key]
                known["stands"].append(edge["id"])
                if known.get("label") != edge.get("label"):
                    known |= {"label": "", "room": [0, 0]}
            else:
                made = {name: value for name, value in edge.items() if name != "bends"}
                merged[key] = made | {"source": source, "target": target, "stands": [edge["id"]]}
                edges.append(merged[key])
    return {
        **view,
        "boxes": [box for box in view["boxes"] if not stand_in(box.get("parent"))],
        "nodes": [node for node in view["nodes"] if not stand_in(node.get("box"))],
        "edges": edges,
    }
