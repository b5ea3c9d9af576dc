"""The plan of a workspace: its generated files, and the first versions of the developers' files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from dineros.generators.application.application import Transition
from dineros.generators.templates.filters import Name, Written
from dineros.generators.workspace.manifest import Manifest

WriteStub = Callable[[Transition, Name, Name], Written]
"""Writes a stub, given its transition, the function's name, and the module's name for ``firings``."""


@dataclass(frozen=True)
class DeveloperFile:
    """A file that is written once.

    Attributes
    ----------
    content : bytes
        Its first content.
    node, package : str or None
        The node net and the package to which it belongs.
    transitions : tuple of Transition
        The transitions with a stub in it; only for a module of handlers.
    write_stub : callable, optional
        Writes a stub for another transition.
    """

    content: bytes
    node: str | None = None
    package: str = ""
    transitions: tuple[Transition, ...] = ()
    write_stub: WriteStub | None = None


@dataclass(frozen=True)
class Plan:
    """The intended content of a workspace.

    Attributes
    ----------
    manifest : Manifest
        The manifest without hashes and developers' files.
    generated : dict of str to bytes
        Generated files, by their path in the workspace.
    developer : dict of str to DeveloperFile
        Developers' files, by their path in the workspace.
    instances : dict of str to dict of str to int
        For each node net, the number of copies of each of its transitions.
    """

    manifest: Manifest
    generated: dict[str, bytes] = field(default_factory=dict)
    developer: dict[str, DeveloperFile] = field(default_factory=dict)
    instances: dict[str, dict[str, int]] = field(default_factory=dict)
