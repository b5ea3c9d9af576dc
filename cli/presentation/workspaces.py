"""Prints files written for node nets: changes of a workspace, and run-time models."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dineros.cli.console import note, say, say_json, summarise
from dineros.metamodel.errors import counted

if TYPE_CHECKING:
    from dineros.generators import Comparison
    from dineros.metamodel import rtm


def say_comparison(workspace: Path, comparison: Comparison, check: bool) -> None:
    """Print written files, or those to be written, and notices for developers."""
    new = [change for change in comparison.changes if change.what == "new"]
    plain = ("new", "changed")
    others = [change for change in comparison.changes if change.what not in plain]
    would = {"new": "is missing", "restored": "is missing", "removed": "is left over"}
    for change in comparison.changes if check else others:
        detail = f": {change.detail}" if change.detail else ""
        if check:
            say(f"{workspace / change.path}: {would.get(change.what, 'is stale')}{detail}")
        else:
            say(f"{workspace / change.path}: {change.what}{detail}")
    if not check:
        for change in comparison.changes:
            if change.what in plain:
                note(f"{workspace / change.path}: {change.what}")
    for edit in comparison.edits:
        say(f"{workspace / edit.path}: {edit.message}")
    for notice in comparison.notices:
        say(f"{workspace}/{notice}")
    if check:
        stale = len(comparison.changes) + len(comparison.edits)
        waiting = sum(notice.stays for notice in comparison.notices)
        counts = f"{counted(stale, 'stale file')}, {counted(waiting, 'handwritten part')} to revise"
        summarise(f"{workspace}: {counts}" if stale or waiting else f"{workspace}: up to date")
    elif comparison.changes:
        changed = len(comparison.changes) - len(new)
        summarise(f"{workspace}: {counted(len(new), 'new file')}, {changed} changed")
    else:
        summarise(f"{workspace}: up to date")


def say_parts(model: Path, written: Mapping[Path, rtm.RuntimeModel], as_json: bool) -> None:
    """Print the written files and their content."""
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
    from dineros.metamodel.elements import places, transitions

    held = [place for place in places(part) if isinstance(place, rtm.Place)]
    return {
        "node": part.node.id,
        "file": str(path),
        "places": len(held),
        "transitions": len(transitions(part)),
        "ports": sum(len(place.ports) for place in held),
        "signals": len(part.node.signals),
    }
