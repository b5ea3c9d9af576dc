"""What a workspace should hold: generated files, and the first version of the developers' files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from dineros.generators.application.application import Transition
from dineros.generators.templates.filters import Name, Written
from dineros.generators.workspace.manifest import Manifest

WriteStub = Callable[[Transition, Name, Name], Written]
"""Writes a stub, given its transition, its function's name and what the module calls ``firings``."""


@dataclass(frozen=True)
class DeveloperFile:
    """A file that is written once.

    Attributes
    ----------
    content : bytes
        What it holds at first.
    node, package : str or None
        The node net, and the package, that it belongs to.
    transitions : tuple of Transition
        What has a stub in it; for a module of handlers only.
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
    """What a workspace should hold.

    Attributes
    ----------
    manifest : Manifest
        All of it but hashes and developers' files.
    generated : dict of str to bytes
        Generated files, by their path in the workspace.
    developer : dict of str to DeveloperFile
        Developers' files, by their path in the workspace.
    instances : dict of str to dict of str to int
        For each node net, how often each of its transitions exists there.
    """

    manifest: Manifest
    generated: dict[str, bytes] = field(default_factory=dict)
    developer: dict[str, DeveloperFile] = field(default_factory=dict)
    instances: dict[str, dict[str, int]] = field(default_factory=dict)
