"""The system model from which a workspace was generated, with settings applied, in its bringup package.

It makes a workspace self-contained: runs can be compared with the model, and drawn, without the original
file.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from dineros.generators.workspace.building import manifest_of
from dineros.generators.workspace.comparison import WorkspaceError
from dineros.metamodel.errors import Location
from dineros.metamodel.files.confined import ConfinedFolder
from dineros.metamodel.ros_names import snake_case

if TYPE_CHECKING:
    from dineros.metamodel import sym

SUFFIX = ".sym.xmi"


def file_name(model: str) -> str:
    """Return the file name of the copy, from the model's id."""
    return f"{snake_case(model)}{SUFFIX}"


def system_model_of(workspace: Path) -> sym.SystemModel:
    """Return the system model of a workspace.

    Raises
    ------
    WorkspaceError
        The folder is not a workspace, was generated without its model, or the model was edited since then.
    ModelFileError
        The file cannot be read.
    """
    from dineros.metamodel import sym
    from dineros.metamodel.files import load

    manifest = manifest_of(workspace)
    folder = f"src/{manifest.bringup}/model/"
    path = next((path for path in manifest.generated if path.startswith(folder)), None)
    content = ConfinedFolder(workspace).read(path) if path is not None else None
    if path is None or content is None:
        raise WorkspaceError(
            "does not hold its system model", location=Location(workspace), hint="generate it again"
        )
    if not manifest.is_ours(path, content):  # the nodes would run another model than the one shown
        raise WorkspaceError(
            "was edited, so it differs from the model from which the nodes were generated",
            location=Location(workspace / path),
            hint="change the model's own file, remove this one and generate the workspace again",
        )
    model = load(workspace / path)
    if not isinstance(model, sym.SystemModel):
        raise WorkspaceError("holds no system model", location=Location(workspace / path))
    return model
