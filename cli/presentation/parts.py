"""What a system model was split into: the run-time model of each node net, and how large it is."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dineros.cli.console import say, say_json, summarise
from dineros.metamodel.elements import places, transitions
from dineros.metamodel.errors import counted

if TYPE_CHECKING:
    from dineros.metamodel import rtm


def say_parts(model: Path, written: Mapping[Path, rtm.RuntimeModel], as_json: bool) -> None:
    """Print which files were written, and what is in them."""
    rows = [_counts(path, part) for path, part in written.items()]
    if as_json:
        say_json({"model": str(model), "nodes": rows})
        return
    for row in rows:
        counts = ", ".join(
            counted(row[f"{what}s"], what) for what in ("place", "transition", "port", "signal")
        )
        say(f"{row['node']} -> {row['file']}: {counts}")
    summarise(f"{model}: {counted(len(rows), 'node net')}")


def _counts(path: Path, part: rtm.RuntimeModel) -> dict[str, Any]:
    from dineros.metamodel import rtm

    held = [place for place in places(part) if isinstance(place, rtm.Place)]
    return {
        "node": part.node.id,
        "file": str(path),
        "places": len(held),
        "transitions": len(transitions(part)),
        "ports": sum(len(place.ports) for place in held),
        "signals": len(part.node.signals),
    }
