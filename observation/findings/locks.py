"""Finds callbacks that wait while they hold a lock that another callback needs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from dineros.analysis.witnesses.findings import Fault, Finding
from dineros.observation.findings.serving import group_of_callback, overlaps_itself
from dineros.observation.findings.sleeping import LONG
from dineros.sources.facts import CallbackFact, Effect, Facts, NodeFact
from dineros.sources.places import located
from dineros.sources.programs.running import NO_PROGRAM

HOLDS = Fault(
    "code-holds-lock",
    "warning",
    "A callback waits while it holds a lock that another callback needs.",
    "{who} waits ({does}) while it holds {lock}, which {others} also needs",
)
_User = tuple[CallbackFact, NodeFact]


def not_modelled(read: Iterable[tuple[str, Facts]]) -> list[str]:
    """Return a line for each wait under a lock: a model without locks does not show that it may never end.

    `read`: each folder, with its facts.
    """
    found: dict[str, str] = {}
    for folder, facts in read:
        for node in facts.nodes:
            for effect, finding in lock_waits(node, facts.nodes):
                if effect.do != "sleep":  # it ends
                    found.setdefault(finding.message, located(effect.at, folder))
    return [f"{line}: {message}; the model has no locks" for message, line in found.items()]


def lock_waits(node: NodeFact, nodes: Sequence[NodeFact]) -> Iterator[tuple[Effect, Finding]]:
    """Yield waits of a node under a lock that another callback of its program also needs."""
    users: dict[str, list[_User]] = {}
    orders: dict[tuple[str, str], list[_User]] = {}
    for each in nodes:
        for callback in each.callbacks if each is node or _shares_locks(each, node) else ():
            for effect in callback.effects:
                if effect.do == "lock":
                    users.setdefault(effect.what, []).append((callback, each))
                    for lock in effect.holding:
                        orders.setdefault((lock, effect.what), []).append((callback, each))
    for callback in node.callbacks:
        this = callback, node
        for effect in callback.effects:
            waits = (
                (effect.do == "call" and effect.how.startswith(("blocks", "spin", "waits", "polled")))
                or effect.do
                in ("wait_for_message", "wait_for_service", "wait_for_server", "spin_until", "spin")
                or (effect.do == "sleep" and (effect.timeout or 0) >= LONG)
            )
            for lock in effect.holding:
                others = [each for each in users.get(lock, ()) if each[0] is not callback]
                does = effect.do
                if effect.do == "wait" and effect.timeout is None:
                    others = [each for each in others if _ends(each[0], effect) and _meet(this, each)]
                    does = f"for {effect.what}"
                elif waits:
                    others = [each for each in others if _meet(this, each)]
                elif effect.do == "lock" and lock != effect.what:
                    # A fault if another callback, or another run of this one, has the other order.
                    others = [
                        each
                        for each in orders.get((effect.what, lock), ())
                        if (
                            overlaps_itself(callback, node)
                            if each[0] is callback
                            else _meet(this, each) and _differ(this, each)
                        )
                    ]
                    does = f"for {effect.what}"
                else:
                    continue
                yield from _held(effect, this, does, lock, others)


def _shares_locks(node: NodeFact, other: NodeFact) -> bool:
    """Return whether a main function creates both nodes, so that equal names of locks are one lock."""
    return node.is_beside(other) and not node.plugin and not other.plugin and node.program != NO_PROGRAM


def _meet(one: _User, other: _User) -> bool:
    """Return whether two callbacks can run at once, whatever their groups."""
    (callback, node), (another, beside) = one, other
    if any(each.kind == "thread" for each in (callback, another)):
        return True
    if "not spun" in (node.threads, beside.threads):
        return False
    if node is beside:
        return not node.is_single
    return not (node.is_single and beside.is_single and node.pool == beside.pool != 0)


def _differ(one: _User, other: _User) -> bool:
    """Return whether two callbacks are in no common mutually exclusive group."""
    group = group_of_callback(*one)
    return one[1] is not other[1] or group is None or group_of_callback(*other) != group


def _ends(callback: CallbackFact, wait: Effect) -> bool:
    return any((each.do, each.what) == ("notify", wait.what) for each in callback.effects)


def _held(
    effect: Effect, this: _User, does: str, lock: str, others: list[_User]
) -> Iterator[tuple[Effect, Finding]]:
    """Yield the finding that a callback waits under a lock, if others need it."""
    if others:
        callback, node = this
        who = f"{callback.name} of {node.name}"
        words = [each.name if beside is node else f"{each.name} of {beside.name}" for each, beside in others]
        names = ", ".join(sorted(set(words)))
        if effect.do == "lock":
            names += f" (holding {effect.what})"
        yield (
            effect,
            HOLDS.found(node.name, callback.name, who=who, does=does, lock=lock, others=names),
        )
