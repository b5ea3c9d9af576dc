"""Finds callbacks that wait while they hold a lock that another callback needs."""

from __future__ import annotations

from collections.abc import Iterator

from dineros.analysis.witnesses.findings import Fault, Finding
from dineros.observation.findings.serving import group_of_callback, overlaps_itself
from dineros.observation.findings.sleeping import LONG
from dineros.sources.facts import CallbackFact, Effect, NodeFact
from dineros.sources.places import Place

HOLDS = Fault(
    "code-holds-lock",
    "warning",
    "A callback waits while it holds a lock that another callback needs.",
    "{who} waits ({does}) while it holds {lock}, which {others} also needs",
)


def lock_waits(node: NodeFact) -> Iterator[tuple[Place, Finding]]:
    """Yield waits under a lock that another callback of the node also needs."""
    if (node.is_single or node.threads == "not spun") and not any(
        each.kind == "thread" for each in node.callbacks
    ):
        return  # no two callbacks run at once
    users: dict[str, list[CallbackFact]] = {}
    orders: dict[tuple[str, str], list[CallbackFact]] = {}
    for callback in node.callbacks:
        for effect in callback.effects:
            if effect.do == "lock":
                users.setdefault(effect.what, []).append(callback)
                for lock in effect.holding:
                    orders.setdefault((lock, effect.what), []).append(callback)
    for callback in node.callbacks:
        for effect in callback.effects:
            waits = (
                (effect.do == "call" and effect.how.startswith(("blocks", "spin", "waits", "polled")))
                or effect.do
                in ("wait_for_message", "wait_for_service", "wait_for_server", "spin_until", "spin")
                or (effect.do == "sleep" and (effect.timeout or 0) >= LONG)
            )
            for lock in effect.holding:
                if effect.do == "wait" and effect.timeout is None:
                    ends = {each.name for each in node.callbacks if _ends(each, effect)}
                    others = ends & {each.name for each in users.get(lock, ())} - {callback.name}
                    yield from _held(effect, callback, node, f"for {effect.what}", lock, others)
                elif waits:
                    others = {each.name for each in users.get(lock, ()) if each.name != callback.name}
                    yield from _held(effect, callback, node, effect.do, lock, others)
                elif effect.do == "lock" and lock != effect.what:
                    # A fault if another callback, or another run of this one, has the other order.
                    group = group_of_callback(callback, node)
                    others = {
                        each.name
                        for each in orders.get((effect.what, lock), ())
                        if (
                            overlaps_itself(callback, node)
                            if each is callback
                            else group is None or group_of_callback(each, node) != group
                        )
                    }
                    yield from _held(effect, callback, node, f"for {effect.what}", lock, others)


def _ends(callback: CallbackFact, wait: Effect) -> bool:
    return any((each.do, each.what) == ("notify", wait.what) for each in callback.effects)


def _held(
    effect: Effect, callback: CallbackFact, node: NodeFact, does: str, lock: str, others: set[str]
) -> Iterator[tuple[Place, Finding]]:
    """Yield the finding that a callback waits under a lock, if others need it."""
    if others:
        who, names = f"{callback.name} of {node.name}", ", ".join(sorted(others))
        if effect.do == "lock":
            names += f" (holding {effect.what})"
        yield (
            effect.at,
            HOLDS.found(node.name, callback.name, who=who, does=does, lock=lock, others=names),
        )
