"""Finds lookups of transforms that wait in vain: the listener needs the thread or group of the caller."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from dineros.analysis.witnesses.findings import Fault, Finding
from dineros.sources.facts import TRANSFORM, CallbackFact, Effect, Entity, NodeFact, is_open
from dineros.sources.places import Place

LOOKUP = Fault(
    "code-looks-up-in-vain",
    "error",
    "A lookup waits for a transform that cannot be received meanwhile.",
    "{who} waits for a transform, which the TransformListener of the node can only receive {when}: {ends}, "
    "if the transform is not there before",
)

FAULTS = (LOOKUP,)

Grouped = Callable[[CallbackFact, NodeFact], str | None]
"""Returns the mutually exclusive group of a callback; None: it is in none, or unknown."""


def lookups(
    callback: CallbackFact, node: NodeFact, who: str, group: Grouped
) -> Iterator[tuple[Place, Finding]]:
    """Yield lookups that wait in vain, each with its line."""
    listeners = [
        each for each in node.of("subscriptions") if "TransformListener" in str(each.details.get("via"))
    ]
    if not listeners or any("thread" in each.details for each in listeners):
        return
    for effect in callback.effects:
        if effect.do == "wait" and effect.what == TRANSFORM:
            why = _why(effect, callback, node, listeners, group)
            if why is not None:
                ends = "it waits forever" if effect.is_repeated else f"it waits {_limit(effect)} in vain"
                found = LOOKUP.found(node.name, callback.name, who=who, when=why, ends=ends)
                is_certain = effect.is_repeated and effect.when != "conditional" and "if the" not in why
                yield effect.at, found if is_certain else replace(found, severity="warning")


def _limit(effect: Effect) -> str:
    return "until its time-out" if effect.timeout is None else f"{effect.timeout:g} s"


def _why(
    effect: Effect, callback: CallbackFact, node: NodeFact, listeners: list[Entity], group: Grouped
) -> str | None:
    """Return when the listener can receive transforms; None: meanwhile, or it is unknown."""
    if callback.kind == "constructor":
        return "once an executor runs the node" if effect.is_repeated else None
    if node.threads == 1:
        return "on the only thread, which waits here"
    if is_open(node.threads):
        return f"on the only thread, which waits here, if the executor has one ({node.threads})"
    own = group(callback, node)
    if own == "default" and all(
        each.group is None and "default" in str(each.details.get("group")) for each in listeners
    ):
        return "in the default callback group, which the caller holds"
    return None
