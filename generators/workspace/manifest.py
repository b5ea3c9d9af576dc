"""The manifest of a workspace, ``.dineros/manifest.json``: its generated files and their hashes.

It belongs into version control with the files: a generated file with another hash was edited.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from dineros.generators.workspace.manifest_schema import (
    MANIFEST,
    OPTIONAL,
    SIZE_LIMIT,
    ManifestError,
    record_of,
)
from dineros.metamodel.errors import Location, ModelFileError
from dineros.metamodel.files.confined import ConfinedFolder
from dineros.metamodel.json_text import JsonTextError, decode_json

__all__ = [
    "PLACE",
    "DeveloperEntry",
    "Manifest",
    "ManifestError",
    "NodeEntry",
    "StubEntry",
    "hash_of",
    "manifest_bytes",
    "read_manifest",
    "write_manifest",
]

PLACE = ".dineros/manifest.json"
SCHEMA = 1


@dataclass(frozen=True)
class NodeEntry:
    """A node of the workspace, with the data needed to start it."""

    node: str
    """Id of the node net."""
    package: str
    executable: str
    """`package`, `executable`: arguments of ``ros2 run``."""
    module: str
    """Argument of ``python -m``."""
    name: str
    namespace: str
    """`name`, `namespace`: name and namespace of the ROS node."""


@dataclass(frozen=True)
class StubEntry:
    """A stub that was written, with the arcs of its transition at that time."""

    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


@dataclass(frozen=True)
class DeveloperEntry:
    """A file that was written once and then belongs to its developer."""

    node: str | None = None
    """Id of the node net in whose package it is."""
    written: str = ""
    """Hash of the last content written by the generator while the file was unedited; it identifies unedited
    files.
    """
    stubs: dict[str, StubEntry] = field(default_factory=dict)
    """Stubs that were written into it, by transition."""


@dataclass(frozen=True)
class Manifest:
    """The recorded state of a workspace."""

    generator: str = ""
    model: str = ""
    source: str = ""
    """`generator`, `model`, `source`: the generator that wrote it, the id of the model, and the name of its
    file.
    """
    settings: tuple[str, ...] = ()
    """Settings that changed the model by ``--set``."""
    options: dict[str, Any] = field(default_factory=dict)
    """Options of the generation, used again if no others are given."""
    interfaces: str = ""
    bringup: str = ""
    """`interfaces`, `bringup`: names of these packages."""
    token: dict[str, str] = field(default_factory=dict)
    """The token's fields and their kinds."""
    nodes: tuple[NodeEntry, ...] = ()
    generated: dict[str, str] = field(default_factory=dict)
    """Hash of each generated file, by its path in the workspace."""
    pending: dict[str, str] = field(default_factory=dict)
    """Hashes of files that are about to be written; empty after they are written."""
    developer: dict[str, DeveloperEntry] = field(default_factory=dict)
    """The developers' files."""

    def is_ours(self, path: str, content: bytes) -> bool:
        """Return whether a file has the content that was generated."""
        return hash_of(content) in (self.generated.get(path), self.pending.get(path))


def hash_of(content: bytes) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(content).hexdigest()


def read_manifest(workspace: Path) -> Manifest | None:
    """Return the manifest of a workspace; None: there is none.

    Raises
    ------
    ManifestError
        The file cannot be read, is not a manifest, or has a newer version.
    """
    try:
        content = ConfinedFolder(workspace).read(PLACE, SIZE_LIMIT)
    except ModelFileError as error:
        raise ManifestError(error.message, location=error.location, hint=error.hint) from error
    if content is None:
        return None
    location, hint = Location(workspace / PLACE), "restore it from version control"
    try:
        values = decode_json(content)
        schema = values.pop("schema", None) if isinstance(values, dict) else None
        if type(schema) is not int or schema < 1:
            raise ManifestError("has no schema")
        if schema > SCHEMA:
            raise ManifestError(
                f"has the schema {schema}; the newest supported one is {SCHEMA}",
                location=location,
                hint="use a later version of DiNeROS",
            )
        return _manifest(record_of(MANIFEST, OPTIONAL)(values, ""))
    except (JsonTextError, ManifestError) as error:
        if error.location is not None:
            raise
        said = f"is not a manifest: {error.message}"
        raise ManifestError(said, location=location, hint=error.hint or hint) from error


def write_manifest(workspace: Path, manifest: Manifest) -> None:
    """Write the manifest of a workspace."""
    ConfinedFolder(workspace).write(PLACE, manifest_bytes(manifest))


def manifest_bytes(manifest: Manifest) -> bytes:
    """Return the bytes of a manifest; equal manifests have equal bytes."""
    values = {"schema": SCHEMA, **asdict(manifest)}
    for name in ("generated", "pending", "developer"):
        values[name] = dict(sorted(values[name].items()))
    if not manifest.pending:
        del values["pending"]
    return (json.dumps(values, indent=2, ensure_ascii=False) + "\n").encode(errors="replace")


def _manifest(values: dict[str, Any]) -> Manifest:
    """Return a manifest from checked values."""
    developer = {
        path: DeveloperEntry(
            entry["node"],
            entry["written"],
            {name: StubEntry(**stub) for name, stub in entry["stubs"].items()},
        )
        for path, entry in values.pop("developer").items()
    }
    nodes = tuple(NodeEntry(**node) for node in values.pop("nodes"))
    return Manifest(**values, nodes=nodes, developer=developer)
