"""Finds callbacks that no executor runs: none that spins gets their callback group."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from dineros.analysis.witnesses.findings import Fault, Finding
from dineros.sources.facts import ALONE, PERHAPS_ALONE, UNSPUN, Entity, NodeFact
from dineros.sources.places import Place

UNRUN = Fault(
    "code-never-runs",
    "error",
    "No executor that spins gets the callback group of a callback, so that it never runs.",
    "{what} {words}",
)
_CALLED = ("subscriptions", "timers", "services", "clients", "action_servers", "action_clients")


def unrun(node: NodeFact) -> Iterator[tuple[Place, Finding]]:
    """Yield a node or its callback groups with callbacks, if no executor that spins gets them."""
    called = [each for kind in _CALLED for each in node.of(kind) if each.is_enabled and each.callbacks]
    if node.executor == UNSPUN and called:
        words = f"is in no executor that begins to spin: the callbacks of {_names(called)} never run"
        yield node.at, UNRUN.found(node.name, what=f"node {node.name}", words=words)
        return
    for group in node.of("groups"):
        executor = group.details.get("executor", "")
        held = [each for kind in _CALLED for each in node.of(kind) if each.group is group and each.is_enabled]
        if not held or executor not in (ALONE, PERHAPS_ALONE, UNSPUN):
            continue
        names = _names(held)
        what = (
            f"callback group {group.port} of {node.name} does not go with its node "
            "(automatically_add_to_executor_with_node = false), and"
        )
        is_certain = executor != PERHAPS_ALONE
        words = f"no executor gets it: the callbacks of {names} never run"
        if executor == UNSPUN:
            words = f"the executor that gets it never spins: the callbacks of {names} never run"
        elif not is_certain:
            words = f"no code is found that gives it to an executor: the callbacks of {names} may never run"
        found = UNRUN.found(node.name, group.port, what=what, words=words)
        yield group.at, found if is_certain else replace(found, severity="warning")


def _names(entities: list[Entity]) -> str:
    return ", ".join(dict.fromkeys(f"{each.name or each.port} (line {each.at.line})" for each in entities))
