"""Finds callbacks that wait for something that only blocked callbacks can do, such as themselves."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import replace

from dineros.analysis.witnesses.findings import Fault, Finding, Severity
from dineros.observation.findings.losing import said
from dineros.observation.findings.serving import (
    CALLED,
    common_group,
    group_of_callback,
    if_one_thread,
    may_have_one_thread,
    overlaps_itself,
    starters_of,
)
from dineros.sources.facts import AWAITED, BARRIER, HELD, NEVER_SET, CallbackFact, Effect, NodeFact, is_open
from dineros.sources.places import Place

OWN = Fault(
    "code-waits-for-itself",
    "error",
    "A callback waits for something that only blocked callbacks can do, or no code.",
    "{who} {words}",
)


def own_waits(
    callback: CallbackFact,
    node: NodeFact,
    nodes: Iterable[NodeFact],
    modelled: Collection[Effect],
) -> Iterator[tuple[Place, Finding]]:
    """Yield waits of a callback for an event or a rate that its own thread or group would have to serve.

    Waits that the model has are left to it.
    """
    who = said(callback, node)
    for effect in (each for each in callback.effects if each not in modelled):
        is_rate = (effect.do, effect.how) == ("sleep", "rate") and effect.at.file.endswith(".py")
        if is_rate and may_have_one_thread(node):  # in C++, a rate needs no timer
            words = "sleeps on a rate, whose timer needs the only thread, and never wakes up"
            found = OWN.found(node.name, callback.name, who=who, words=f"{words}{if_one_thread(node)}")
            yield effect.at, found if node.is_single else replace(found, severity="warning")
        elif is_rate and isinstance(node.threads, int) and _sleepers(node, nodes) >= node.threads:
            words = (
                f"sleeps on a rate, whose timer needs one of {node.threads} threads: such sleeps can hold all"
            )
            found = OWN.found(node.name, callback.name, who=who, words=words)
            is_certain = _sleepers(node, nodes) < MANY
            yield effect.at, found if is_certain else replace(found, severity="warning")
        elif effect.do == "lock" and effect.how == HELD:
            words = f"locks {effect.what}, which it already holds: it waits for itself forever"
            found = OWN.found(node.name, callback.name, who=who, words=words)
            yield effect.at, found if effect.when == "always" else replace(found, severity="warning")
        elif _blocks_outside(effect, callback) and may_have_one_thread(node):
            what = (
                f"{_GOALS[effect.do]} of a goal" if effect.do in _GOALS else f"the response of {effect.what}"
            )
            words = f"waits for {what}, which needs the only thread, and never ends"
            found = OWN.found(node.name, callback.name, who=who, words=f"{words}{if_one_thread(node)}")
            is_certain = node.is_single and effect.when == "always"
            yield effect.at, found if is_certain else replace(found, severity="warning")
        elif effect.do == "cancel_goal" and effect.how.startswith("blocks"):
            words = "waits for the answer to its request to cancel a goal"
            group = None if effect.entity is None else common_group([effect.entity], node)
            if may_have_one_thread(node):
                words += f", which needs the only thread, and never ends{if_one_thread(node)}"
            elif group is not None and group == group_of_callback(callback, node):
                words += f", which needs the callback group that {callback.name} itself holds, and never ends"
            else:
                continue
            found = OWN.found(node.name, callback.name, who=who, words=words)
            yield effect.at, replace(found, severity="warning") if is_open(node.threads) else found
        elif effect.do == "wait" and effect.how.endswith(NEVER_SET):
            yield effect.at, never_set(callback, node, effect, who)
        elif effect.do == "wait" and (why := _never_meanwhile(callback, node, effect, nodes)):
            found = OWN.found(node.name, callback.name, who=who, words=f"waits for {effect.what}, {why}")
            ends = f": it waits {effect.timeout:g} s in vain" if effect.timeout is not None else ": forever"
            is_certain = effect.timeout is None and "open" not in effect.how and "if the executor" not in why
            severity: Severity = "error" if is_certain else "warning"
            message = f"{found.message}{ends}, if that is not set before"
            yield effect.at, replace(found, severity=severity, message=message)


def never_set(callback: CallbackFact, node: NodeFact, wait: Effect, who: str) -> Finding:
    """Return the finding of a wait for an event that no code sets."""
    words = f"waits for {wait.what}, which no code sets: forever"
    return OWN.found(node.name, callback.name, who=who, words=words)


MANY = 1000
"""Number of runs of callbacks that may overlap without limit."""


def _sleepers(node: NodeFact, nodes: Iterable[NodeFact]) -> int:
    """Return how many callbacks on an executor can sleep on a rate of rclpy at once."""
    groups: set[object] = set()
    for other in nodes:
        for each in (
            other.callbacks if other is node or (other.is_beside(node) and other.pool == node.pool) else ()
        ):
            if each.kind in (*CALLED, "execute") and any(
                (effect.do, effect.how) == ("sleep", "rate") for effect in each.effects
            ):
                if overlaps_itself(each, other):
                    return MANY
                group = group_of_callback(each, other)
                groups.add(id(each) if group is None else (other.name, group))
    return len(groups)


_GOALS = {"send_goal": "the acceptance", "get_result": "the result"}


def _blocks_outside(effect: Effect, callback: CallbackFact) -> bool:
    """Return whether a done callback or a task blocks for what the model does not make it wait for."""
    kinds = ("done callback", "task") if effect.do in _GOALS else ("task",)
    if callback.kind not in kinds or effect.do not in (*_GOALS, "call"):
        return False
    return effect.how.startswith(("blocks", "polled")) and effect.timeout is None and "open" not in effect.how


def _never_meanwhile(
    callback: CallbackFact, node: NodeFact, wait: Effect, nodes: Iterable[NodeFact]
) -> str | None:
    """Return why a wait of a callback cannot end while it lasts; None: it may, or no setter is known."""
    is_suspended = wait.how == AWAITED
    if is_suspended and callback.kind == "execute":
        return None  # a task, which holds no group
    setters = [
        (each, other)
        for other in nodes
        if other.is_beside(node)
        for each in other.callbacks
        if each.is_open or any(_ends(done, wait, is_own=each is callback) for done in each.effects)
    ]
    is_own = all(
        other is node and each is not callback and each.kind in CALLED and not each.is_open
        for each, other in setters
    )
    if not setters or not is_own:
        return None
    names = ", ".join(dict.fromkeys(each.name for each, _ in setters))
    if may_have_one_thread(node) and not is_suspended:
        return f"which only {names} sets: the only thread is here{if_one_thread(node)}"
    group = group_of_callback(callback, node)
    if group is None or any(common_group(starters_of(each, node), node) != group for each, _ in setters):
        return None
    return f"which only {names} sets, in the callback group that {callback.name} itself holds"


def _ends(done: Effect, wait: Effect, *, is_own: bool) -> bool:
    """Return whether an effect of the waiting callback, or of another one, ends a wait."""
    return (done.do, done.what) == ("notify", wait.what) and not (is_own and done.how == BARRIER)
