"""Generates a ROS 2 workspace from a system model: planning, comparing, writing.

Example
-------
>>> from pathlib import Path
>>> from dineros.generators import Options, generate
>>> from dineros.metamodel.files import load
>>> model = load("case_study/sorting.sym.xmi")                            # doctest: +SKIP
>>> comparison = generate(model, Path("workspace"), Options(source="sorting.sym.xmi"))   # doctest: +SKIP
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from dineros.generators.workspace.comparison import Comparison, WorkspaceError, compare
from dineros.generators.workspace.manifest import PLACE, Manifest, read_manifest, write_manifest
from dineros.generators.workspace.notices import Edit
from dineros.generators.workspace.planning import Options, plan
from dineros.metamodel import sym
from dineros.metamodel.errors import Location
from dineros.metamodel.files.confined import ConfinedFolder
from dineros.metamodel.files.whole_folders import whole_folder


class EditedError(WorkspaceError):
    """Generated files were edited by hand.

    Attributes
    ----------
    edits : tuple of Edit
        The edited files, with their differences.
    """

    def __init__(self, edits: tuple[Edit, ...], workspace: Path) -> None:
        first, others = edits[0], len(edits) - 1
        more = f"; and {others} more" if others else ""
        super().__init__(
            f"{first.message}{more}: nothing is written",
            location=Location(workspace / first.path),
            hint="move your change to a developer's file or to a template of your own, then remove the file",
        )
        self.edits = edits


def generate(model: sym.SystemModel, workspace: Path, options: Options) -> Comparison:
    """Generate or update a workspace; developers' files are only appended to.

    Parameters
    ----------
    model : sym.SystemModel
        A valid system model.
    workspace : Path
        The folder; created if it does not exist.
    options : Options
        Options of the generation.

    Returns
    -------
    Comparison
        The changes, and the notices for developers.

    Raises
    ------
    EditedError
        Generated files were edited; nothing is written.
    DinerosError
        The model's names collide in ROS, a template has an error, or a developer's file is not Python;
        nothing is written.
    ModelFileError
        A file cannot be written. A new workspace is then not there; an existing one has old and new files,
        each complete, and the next generation completes it.
    """
    known = read_manifest(workspace)
    comparison = compare(workspace, plan(model, workspace, options, known), known)
    if comparison.edits:
        raise EditedError(comparison.edits, workspace)
    with whole_folder(workspace) as folder:
        _write(folder, comparison, known)
    return comparison


def check(model: sym.SystemModel, workspace: Path, options: Options) -> Comparison:
    """Compare a workspace with the result of `generate`; nothing is written.

    Raises
    ------
    DinerosError
        As for `generate`; but edited files are reported in the comparison.
    """
    known = read_manifest(workspace)
    return compare(workspace, plan(model, workspace, options, known), known)


def _write(workspace: Path, comparison: Comparison, known: Manifest | None) -> None:
    """Write the changes; the manifest announces them first, so that a crash does not look like an edit."""
    folder = ConfinedFolder(workspace)
    _take_away_leftovers(folder, [comparison.manifest, known or comparison.manifest])
    if comparison.changes:
        pending = {
            path: digest
            for path, digest in comparison.manifest.generated.items()
            if any(change.path == path for change in comparison.changes)
        }
        write_manifest(workspace, replace(known or comparison.manifest, pending=pending))
    for change in comparison.changes:
        if change.content is None:
            folder.remove(change.path)
        else:
            folder.write(change.path, change.content)
    if comparison.changes or comparison.manifest != known:
        write_manifest(workspace, comparison.manifest)


def _take_away_leftovers(folder: ConfinedFolder, manifests: Iterable[Manifest]) -> None:
    """Remove temporary files of killed runs from all folders with generated files, present or former."""
    paths = {PLACE}
    for manifest in manifests:
        paths.update(manifest.generated, manifest.pending, manifest.developer)
    for path in sorted({path.rpartition("/")[0] for path in paths}):
        folder.take_away_leftovers(path)
