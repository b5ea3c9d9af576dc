"""Finds lost and late messages in code: early messages, requests to a destroyed server, timers."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from dineros.analysis.witnesses.findings import Fault, Finding
from dineros.observation.importing.timing import stops_of
from dineros.sources.facts import CallbackFact, Effect, Entity, NodeFact, is_open
from dineros.sources.places import Place
from dineros.sources.resolving import full_name_of

EARLY = Fault(
    "code-publishes-early",
    "warning",
    "The only message of a publisher is published before a subscription can exist.",
    "{who} {words}",
)
LOSES = Fault(
    "code-loses-server",
    "warning",
    "A service is destroyed while clients may wait for its response without time-out.",
    "{who} {words}",
)
AGAIN = Fault(
    "code-asks-again",
    "warning",
    "A request is sent again while the server may still work on the first.",
    "{who} {words}",
)
LATE = Fault(
    "code-overruns",
    "warning",
    "The callback of a timer sleeps as long as its period, or for a time that is unknown from the code.",
    "{who} {words}",
)
BEHIND = Fault(
    "code-falls-behind",
    "error",
    "The callback of a subscription sleeps on a rate that is slower than its messages.",
    "{who} {words}",
)

FAULTS = (EARLY, LOSES, AGAIN, LATE, BEHIND)

_OUTSIDE = ("constructor", "main")
_RESTS = (
    *(
        "sleep",
        "spin",
        "spin_once",
        "spin_until",
        "wait",
        "wait_for_message",
        "wait_for_service",
        "wait_for_server",
    ),
    *("input", "loop"),
)
"""Effects after which a subscriber may exist."""


@dataclass(frozen=True)
class _Use:
    """An effect of a callback on a port."""

    node: NodeFact
    callback: CallbackFact
    effect: Effect


def losses(nodes: Iterable[NodeFact]) -> Iterator[tuple[Place, Finding]]:
    """Yield the findings of losses and delays, each with its line.

    `nodes`: all nodes of a folder.
    """
    every = list(nodes)
    uses = [
        _Use(node, each, effect)
        for node in every
        for each in node.callbacks
        for effect in each.effects
        if effect.entity is None or effect.entity in node.entities  # a main function belongs to many
    ]
    for use in uses:
        yield from _early(use, uses, every)
        yield from _loses(use, uses)
        yield from _again(use, every)
    for node in every:
        yield from _late(node)
        yield from _behind(node, every)


def said(callback: CallbackFact, node: NodeFact) -> str:
    """Return a callback in words."""
    kind = callback.kind if callback.kind.endswith("callback") else f"{callback.kind} callback"
    return f"{kind} {callback.name} of {node.name}"


def _who(use: _Use) -> str:
    if use.callback.kind in _OUTSIDE:
        return f"{use.callback.name} of {use.node.name}"
    return said(use.callback, use.node)


# -------------------------------------------------------------------------------------------------- messages


def _early(use: _Use, uses: list[_Use], nodes: list[NodeFact]) -> Iterator[tuple[Place, Finding]]:
    effect, entity = use.effect, use.effect.entity
    if effect.do != "publish" or use.callback.kind not in _OUTSIDE or effect.when == "in a loop":
        return
    if entity is None or entity not in use.node.entities or not _is_first(use):
        return
    if is_open(entity.name) or any(
        each.effect.entity is entity and each.effect is not effect for each in uses
    ):
        return  # what comes later makes up for it
    readers = [
        (node, _durability(entity, each))
        for node in nodes
        if node is not use.node  # another node, which may start later
        for each in node.of("subscriptions")
        if full_name_of(each, node) == full_name_of(entity, use.node)
    ]
    late = {node.name for node, durability in readers if durability == "volatile"}
    doubtful = {node.name: durability for node, durability in readers if is_open(durability)}
    names = ", ".join(sorted(late or doubtful))
    if not names:
        return
    unless = "" if late else f", unless the durability is transient local ({next(iter(doubtful.values()))})"
    words = (
        f"publishes the only message of {entity.name} at once: "
        f"{names} receives it only if its subscription already exists{unless}"
    )
    found = EARLY.found(use.node.name, use.callback.name, who=_who(use), words=words)
    yield effect.at, found if late else replace(found, severity="note")


def _durability(publisher: Entity, subscription: Entity) -> str:
    """Return the durability of what a subscription receives: transient local if both ends say so."""
    ends = [str(each.details.get("durability")) for each in (publisher, subscription)]
    if "volatile" in ends:
        return "volatile"
    return next((each for each in ends if is_open(each)), "transient_local")


def _is_first(use: _Use) -> bool:
    """Return whether a message is published before any effect that takes time."""
    effect = use.effect
    before = use.callback.effects[: use.callback.effects.index(effect)]
    if any(each.do in _RESTS for each in before):
        return False
    if use.callback.kind == "constructor" or effect.entity is None:
        return True
    made = effect.entity.at
    if effect.at.file != made.file or not 0 <= effect.at.line - made.line <= 5:
        return False
    spun = re.search(r"\(([^()]+):(\d+)\)", use.node.executor)
    return spun is None or spun[1] != effect.at.file or int(spun[2]) > effect.at.line


# -------------------------------------------------------------------------------------------------- requests


def _loses(use: _Use, uses: list[_Use]) -> Iterator[tuple[Place, Finding]]:
    effect, entity = use.effect, use.effect.entity
    if effect.do != "destroy" or entity is None or entity.kind != "services":
        return
    waiting = [
        each
        for each in uses
        if each.effect.do == "call"
        and each.effect.entity is not None
        and full_name_of(each.effect.entity, each.node) == full_name_of(entity, use.node)
        and not _is_bounded(each)
    ]
    if not waiting:
        return
    first = waiting[0]
    words = (
        f"destroys the service {entity.name}: {first.callback.name} of {first.node.name} "
        f"({first.effect.at}) never gets an answer to a request that is under way, or that comes before the "
        "service is made again"
    )
    yield effect.at, LOSES.found(use.node.name, use.callback.name, who=_who(use), words=words)


def _is_bounded(use: _Use) -> bool:
    """Return whether a call has a time-out."""
    if use.effect.timeout is not None:
        return True
    after = use.callback.effects[use.callback.effects.index(use.effect) :]
    return any(each.do in ("wait", "spin_until") and each.timeout is not None for each in after)


def _again(use: _Use, nodes: list[NodeFact]) -> Iterator[tuple[Place, Finding]]:
    effect, entity = use.effect, use.effect.entity
    if effect.do != "call" or effect.when != "in a loop" or entity is None:
        return
    patience: float | None = effect.timeout
    is_given_up = patience is not None
    if effect.how == "spin-until":
        after = use.callback.effects[use.callback.effects.index(effect) :]
        spin = next((each for each in after if each.do == "spin_until"), None)
        if spin is not None and "without" not in spin.how:
            is_given_up, patience = True, spin.timeout
    if not is_given_up:
        return
    for node in nodes:
        for service in node.of("services"):
            served = service.callbacks.get("callback")
            if served is None or full_name_of(service, node) != full_name_of(entity, use.node):
                continue
            for work in served.effects:
                if work.do == "sleep" and _may_last(work.timeout, patience):
                    seconds = "a time-out that is unknown from the code"
                    words = (
                        f"asks {entity.name} again after {seconds if patience is None else f'{patience:g} s'}"
                        f", while {served.name} of {node.name} ({work.at}) may still work at the first "
                        "request: it then does the work twice, and the second answer may be a refusal"
                    )
                    found = AGAIN.found(use.node.name, use.callback.name, who=_who(use), words=words)
                    yield effect.at, found
                    return


def _may_last(work: float | None, patience: float | None) -> bool:
    return work is None or patience is None or work >= patience


# ---------------------------------------------------------------------------------------------------- timers


def _late(node: NodeFact) -> Iterator[tuple[Place, Finding]]:
    """Yield sleeps in the callback of a timer that delay its ticks and other callbacks."""
    if node.threads == "not spun":
        return
    for timer in node.of("timers"):
        callback, period = timer.callbacks.get("callback"), timer.details.get("period")
        if callback is None or not isinstance(period, (int, float)) or not timer.is_enabled:
            continue
        sleeps = [
            each
            for each in callback.effects
            if (each.do, each.how, each.when) == ("sleep", "time.sleep", "always")
        ]
        total = sum(each.timeout or 0.0 for each in sleeps)
        unknown = [each for each in sleeps if each.timeout is None]
        others = [
            other.name
            for other in node.callbacks
            if other is not callback and other.kind in ("subscription", "timer", "service")
        ]
        if sleeps and period <= total < 1.0:
            words = f"sleeps {total:g} s, and its period is {period:g} s: its ticks come late"
        elif unknown and others:
            words = (
                f"sleeps for a time that the code does not show ({unknown[0].what}), and its period is "
                f"{period:g} s: if it sleeps as long, its ticks come late, and so does what it shares a "
                f"thread or a group with ({', '.join(dict.fromkeys(others))})"
            )
        else:
            continue
        at = (unknown or sleeps)[0].at
        yield at, LATE.found(node.name, callback.name, who=said(callback, node), words=words)


def _behind(node: NodeFact, nodes: Iterable[NodeFact]) -> Iterator[tuple[Place, Finding]]:
    """Yield sleeps on a rate by which a subscription takes fewer messages than a timer publishes.

    Runs that follow one another end at different ticks of the rate, so a period lies between two of them. A
    reader that keeps only the newest message, or does not ask for all, is meant to lose the others.
    """
    if not isinstance(node.threads, int) and node.threads != "processors":
        return
    for reader in node.of("subscriptions"):
        callback, depth = reader.callbacks.get("callback"), reader.details.get("depth")
        is_one_by_one = reader.group is None or reader.group.details.get("kind") == "exclusive"
        if callback is None or not reader.is_enabled or not is_one_by_one:
            continue
        if reader.details.get("reliability") != "reliable" or not isinstance(depth, int) or depth < 2:
            continue
        sleeps = [
            each
            for each in callback.effects
            if (each.do, each.how, each.when) == ("sleep", "rate", "always") and each.timeout is not None
        ]
        slowest = max(sleeps, key=lambda each: each.timeout or 0.0, default=None)
        if slowest is None or slowest.timeout is None or _never_wakes(slowest, node):
            continue
        for sender, other, period in _periods(reader, node, nodes):
            if period < slowest.timeout:
                topic, who = full_name_of(reader, node), said(callback, node)
                words = (
                    f"sleeps on a rate of {slowest.timeout:g} s, and {sender.name} of {other.name} publishes "
                    f"a message to {topic} each {period:g} s: a history of depth {depth} overflows"
                )
                yield slowest.at, BEHIND.found(node.name, callback.name, who=who, words=words)
                break


def _never_wakes(sleep: Effect, node: NodeFact) -> bool:
    """Return whether the timer of a rate of rclpy needs the only thread, on which the callback sleeps."""
    return node.threads == 1 and sleep.at.file.endswith(".py")


def _periods(
    reader: Entity, node: NodeFact, nodes: Iterable[NodeFact]
) -> Iterator[tuple[CallbackFact, NodeFact, float]]:
    """Yield timers of other nodes that publish a message for a subscription at each tick."""
    for other in nodes:
        if other is node or other.threads == "not spun" or other.managed:
            continue
        for timer in other.of("timers"):
            sender, period = timer.callbacks.get("callback"), timer.details.get("period")
            if sender is None or not timer.is_enabled or not isinstance(period, (int, float)):
                continue
            if stops_of(timer, other) is None and any(
                (each.do, each.when) == ("publish", "always")
                and each.entity is not None
                and full_name_of(each.entity, other) == full_name_of(reader, node)
                for each in sender.effects
            ):
                yield sender, other, period
