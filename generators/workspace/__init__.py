"""A ROS 2 workspace: planning, comparing, writing and building."""

from dineros.generators.workspace.generating import EditedError, check, generate
from dineros.generators.workspace.planning import Options, plan

__all__ = ["EditedError", "Options", "check", "generate", "plan"]
