"""Finds types that code uses and that neither the folders nor installed packages define."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from dineros.analysis.witnesses.findings import Fault, Finding
from dineros.sources.facts import Entity, Facts, NodeFact, is_open
from dineros.sources.interfaces import Interfaces
from dineros.sources.places import located

MISSING = Fault(
    "code-type-missing",
    "warning",
    "A port has a type that its package does not define.",
    "{port} of {node} has the type {type}: {why}",
)


def missing_types(read: Sequence[tuple[str, Facts]]) -> list[Finding]:
    """Return a finding for each type that is not among those of its package, at the line of its first port.

    The elements of a finding are the names of node and type.

    `read`: each folder, with its facts; all folders can use each other's interfaces.
    """
    known = _together(read)
    found: dict[str, Finding] = {}
    for folder, node, entity in _typed(read):
        if entity.type not in found and known.is_missing(entity.type):
            finding = MISSING.found(
                *(node.name, entity.type),
                port=entity.name,
                node=node.name,
                type=entity.type,
                why=known.doubt(entity.type) or "",
            )
            found[entity.type] = replace(finding, lines=(located(entity.at, folder),))
    return list(found.values())


def unchecked_types(read: Sequence[tuple[str, Facts]]) -> list[str]:
    """Return a line for each type that no file and no installed package defines: it is not checked."""
    known = _together(read)
    found: dict[str, str] = {}
    for folder, _, entity in _typed(read):
        why = known.doubt(entity.type)
        if why is not None and not known.is_missing(entity.type):
            found.setdefault(
                entity.type, f"{located(entity.at, folder)}: {entity.type} is not checked: {why}"
            )
    return [found[type] for type in sorted(found)]


def _together(read: Iterable[tuple[str, Facts]]) -> Interfaces:
    known = Interfaces()
    for _, facts in read:
        known.add(facts.interfaces)
    return known


def _typed(read: Iterable[tuple[str, Facts]]) -> Iterator[tuple[str, NodeFact, Entity]]:
    """Yield the ports with a known type, each with its folder and node."""
    for folder, facts in read:
        for node in facts.nodes:
            for entity in node.entities:
                if entity.type.count("/") == 2 and not is_open(entity.type):
                    yield folder, node, entity
