"""Compares a workspace with its plan: files to write, notices, and edits that prevent writing.

Nothing is written here. For each file, three questions are answered: is it up to date, was a generated file
edited, and does handwritten code refer to elements that the model no longer has?
"""

from __future__ import annotations

import difflib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from dineros.generators.workspace import handwritten
from dineros.generators.workspace.manifest import DeveloperEntry, Manifest, StubEntry, hash_of
from dineros.generators.workspace.notices import Change, Edit, Notice
from dineros.generators.workspace.plan import DeveloperFile, Plan
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.confined import ConfinedFolder


class WorkspaceError(DinerosError):
    """The folder of a workspace cannot be used."""


@dataclass(frozen=True)
class Comparison:
    """The differences between a workspace and its plan.

    Attributes
    ----------
    changes, notices, edits : tuple
        Files to write, notices for developers, edits that prevent writing.
    manifest : Manifest
        The manifest after all changes.
    """

    changes: tuple[Change, ...]
    notices: tuple[Notice, ...]
    edits: tuple[Edit, ...]
    manifest: Manifest

    @property
    def is_stale(self) -> bool:
        """Whether a file is outdated or edited, or a notice waits for the developer."""
        waiting = any(notice.stays for notice in self.notices)
        return bool(self.changes or self.edits or waiting)

    def to_dict(self) -> dict[str, Any]:
        """Return changes, edits and notices for JSON."""
        return {
            "changes": [
                {"file": change.path, "what": change.what, "detail": change.detail} for change in self.changes
            ],
            "edits": [
                {"file": edit.path, "message": edit.message, "difference": edit.difference}
                for edit in self.edits
            ],
            "notices": [vars(notice) for notice in self.notices],
        }


def compare(workspace: Path, plan: Plan, known: Manifest | None) -> Comparison:
    """Compare a workspace with its plan.

    Parameters
    ----------
    workspace : Path
        The folder; it need not exist.
    plan : Plan
        The intended content.
    known : Manifest or None
        Its current manifest.

    Raises
    ------
    ModelFileError
        A file cannot be read, or a symbolic link leads out of the workspace.
    DeveloperFileError
        A developer's file is not Python.
    """
    before = known or Manifest()
    changes: list[Change] = []
    notices: list[Notice] = []
    edits: list[Edit] = []
    for path, content in plan.generated.items():
        present = ConfinedFolder(workspace).read(path)
        if present is None:
            changes.append(Change(path, "restored" if path in before.generated else "new", content=content))
        elif present != content:
            if before.is_ours(path, present):
                changes.append(Change(path, "changed", content=content))
            else:
                edits.append(_edit(path, content, present, path in before.generated))
    for path in before.generated:
        if path not in plan.generated:
            _remove(workspace, path, before, plan, changes, notices)
    developer = _compare_developers(workspace, plan, before, changes, notices)
    manifest = replace(
        plan.manifest,
        generated={path: hash_of(content) for path, content in plan.generated.items()},
        developer=developer,
    )
    notices.extend(handwritten.token_notices(workspace, before, manifest))
    order = {"new": 0, "restored": 0, "changed": 0, "extended": 1, "removed": 2}
    changes.sort(key=lambda change: order[change.what])
    return Comparison(tuple(changes), tuple(notices), tuple(edits), manifest)


def _remove(
    workspace: Path,
    path: str,
    before: Manifest,
    plan: Plan,
    changes: list[Change],
    notices: list[Notice],
) -> None:
    """Remove a file that is no longer generated, unless it was edited."""
    present = ConfinedFolder(workspace).read(path)
    if present is None or path in plan.developer:
        return
    if before.is_ours(path, present):
        changes.append(Change(path, "removed"))
    else:
        message = "is not generated any more, but was edited; file kept"
        notices.append(Notice("kept", path, message, "copy the parts that you need, then remove it"))


def _compare_developers(
    workspace: Path, plan: Plan, before: Manifest, changes: list[Change], notices: list[Notice]
) -> dict[str, DeveloperEntry]:
    entries = {}
    for path, file in plan.developer.items():
        known = before.developer.get(path)
        present = ConfinedFolder(workspace).read(path)
        if present is None:
            changes.append(Change(path, "restored" if known else "new", content=file.content))
            entries[path] = DeveloperEntry(file.node, hash_of(file.content), _stubs(file))
        else:
            entries[path] = _extend(workspace, path, file, known, present, changes)
            notices.extend(handwritten.handler_notices(workspace / path, path, file, known, plan, present))
    for path, entry in before.developer.items():
        present = ConfinedFolder(workspace).read(path)
        if path in plan.developer or present is None:
            continue
        if hash_of(present) == entry.written:
            changes.append(Change(path, "removed", "it had not been edited"))
        else:
            entries[path] = entry
            notices.append(handwritten.left_over(path, entry, plan))
    return entries


def _stubs(file: DeveloperFile) -> dict[str, StubEntry]:
    return {
        transition.id: StubEntry(tuple(map(str, transition.inputs)), tuple(map(str, transition.outputs)))
        for transition in file.transitions
    }


def _extend(
    workspace: Path,
    path: str,
    file: DeveloperFile,
    known: DeveloperEntry | None,
    present: bytes,
    changes: list[Change],
) -> DeveloperEntry:
    """Append stubs for transitions that never had one to the file."""
    had = known.stubs if known else {}
    new = [transition for transition in file.transitions if transition.id not in had]
    content, added = handwritten.with_stubs(workspace / path, file, new, present)
    if added:
        changes.append(Change(path, "extended", f"stub for {', '.join(added)}", content))
    untouched = known is not None and hash_of(present) == known.written
    written = hash_of(content) if untouched else (known.written if known else "")
    return DeveloperEntry(file.node, written, _stubs(file))


def _edit(path: str, content: bytes, present: bytes, was_generated: bool) -> Edit:
    message = "was edited" if was_generated else "already exists, and DiNeROS did not write it"
    try:
        old, new = (part.decode().splitlines(keepends=True) for part in (content, present))
    except UnicodeDecodeError:
        return Edit(path, message, "")
    lines = difflib.unified_diff(old, new, f"{path} (generated)", f"{path} (yours)")
    difference = "".join(line if line.endswith("\n") else f"{line}\n" for line in lines)
    return Edit(path, message, difference)
