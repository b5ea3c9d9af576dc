"""Finds callbacks that no executor runs, as no executor gets their callback group."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from dineros.analysis.witnesses.findings import Fault, Finding
from dineros.sources.facts import NodeFact
from dineros.sources.places import Place

UNRUN = Fault(
    "code-never-runs",
    "error",
    "No executor gets the callback group of a callback, so that it never runs.",
    "callback group {group} of {node} does not go with its node "
    "(automatically_add_to_executor_with_node = false), "
    "and {words}",
)
_CALLED = ("subscriptions", "timers", "services", "clients", "action_servers", "action_clients")


def unrun(node: NodeFact) -> Iterator[tuple[Place, Finding]]:
    """Yield the callback groups of a node with callbacks that no executor gets."""
    for group in node.of("groups"):
        executor = group.details.get("executor", "")
        held = [each for kind in _CALLED for each in node.of(kind) if each.group is group and each.is_enabled]
        if not held or not executor.startswith("none"):
            continue
        names = ", ".join(dict.fromkeys(f"{each.name or each.port} (line {each.at.line})" for each in held))
        is_certain = executor == "none"
        words = f"no executor gets it: the callbacks of {names} never run"
        if not is_certain:
            words = f"no code is found that gives it to an executor: the callbacks of {names} may never run"
        found = UNRUN.found(node.name, group.port, group=group.port, node=node.name, words=words)
        yield group.at, found if is_certain else replace(found, severity="warning")
