"""How a workspace differs, or differed, from what is generated."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.console import note, say, summarise
from dineros.metamodel.errors import counted

if TYPE_CHECKING:
    from dineros.generators import Comparison


def say_comparison(workspace: Path, comparison: Comparison, check: bool) -> None:
    """Print what was written, or what would be, and what developers should know."""
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
