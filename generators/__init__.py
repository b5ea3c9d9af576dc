"""Generates ROS 2 packages from runtime models with templates; developers extend and keep the packages.

>>> from dineros.generators import Options, generate   # writes a workspace, or brings it up to date
>>> from dineros.generators import check               # says what that would change
"""

from dineros.generators.workspace.comparison import Comparison, WorkspaceError
from dineros.generators.workspace.generating import EditedError, check, generate
from dineros.generators.workspace.manifest import Manifest, read_manifest
from dineros.generators.workspace.notices import Change, Edit, Notice
from dineros.generators.workspace.planning import Options

__all__ = [
    "Change",
    "Comparison",
    "Edit",
    "EditedError",
    "Manifest",
    "Notice",
    "Options",
    "WorkspaceError",
    "check",
    "generate",
    "read_manifest",
]
