"""Finds programs that wait forever while they start.

A node that waits for a server in its constructor creates its own servers later, after that wait. If the other
node waits in the same way for one of these servers, neither node ever starts. A node that calls a service
before an executor runs it never processes the response.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from dineros.analysis.witnesses.findings import Fault, Finding
from dineros.sources.facts import NO_SPIN, STARTING, Effect, Entity, NodeFact, is_open
from dineros.sources.places import Place
from dineros.sources.resolving import full_name_of

STARTS = Fault(
    "code-never-starts",
    "error",
    "Nodes wait for servers while they start, and create what others wait for only afterwards.",
    "{who} never starts: it waits for {what}{why}",
)
UNSPUN = Fault(
    "code-waits-unspun",
    "error",
    "A program waits for a response or a rate before an executor runs the node.",
    "{who} {words}",
)

FAULTS = (STARTS, UNSPUN)

_SERVERS = {"wait_for_service": ("services", "service"), "wait_for_server": ("action_servers", "action")}
"""What each wait waits for: the kind of the entity, and its name for people."""


@dataclass(frozen=True)
class _Wait:
    """A wait without time-out of the thread that starts a program, or one that a loop repeats."""

    node: NodeFact
    callback: str
    effect: Effect
    name: str


def starts(nodes: Iterable[NodeFact]) -> Iterator[tuple[NodeFact, Place, Finding]]:
    """Yield the findings of starts, each with its node and line.

    `nodes`: all nodes that run together.
    """
    every = list(nodes)
    waits = [each for node in every for each in _waits(node)]
    stuck = _stuck(waits, every)
    for wait in stuck:
        kind, words = _SERVERS[wait.effect.do]
        servers = [node for node, _ in _servers(wait.name, kind, every)]
        names = sorted({node.name for node in servers})
        before = [each.name for each in stuck if each.node in servers and each is not wait]
        why = f", which {_one_of(names)} creates only later"
        if before:
            why += f", after it has waited for {_one_of(list(dict.fromkeys(before)))}"
        elif wait.node in servers:
            why += ", after this wait"
        what = f"{words} {wait.name}"
        found = STARTS.found(wait.node.name, wait.callback, who=wait.node.name, what=what, why=why)
        yield wait.node, wait.effect.at, found
    for node in every:
        yield from ((node, *each) for each in _unspun(node))
        yield from _of_helper(node, every)


def _one_of(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} or {names[-1]}"


def _waits(node: NodeFact) -> Iterator[_Wait]:
    """Yield the waits of a node that certainly come while its program starts, in their order."""
    for callback in node.callbacks:
        for effect in callback.effects:
            entity = effect.entity
            if effect.do not in _SERVERS or not effect.order or entity is None:
                continue
            name = full_name_of(entity, node)
            if is_open(name):
                continue
            is_endless = effect.is_repeated or (effect.timeout is None and effect.how == "without time-out")
            is_certain = effect.when == "always" or effect.is_repeated
            if entity in node.entities and is_endless and is_certain:
                yield _Wait(node, callback.name, effect, name)


def _servers(name: str, kind: str, nodes: Iterable[NodeFact]) -> list[tuple[NodeFact, Entity]]:
    return [
        (node, each)
        for node in nodes
        for each in node.of(kind)
        if is_open(served := full_name_of(each, node)) or served == name
    ]


def _stuck(waits: list[_Wait], nodes: list[NodeFact]) -> list[_Wait]:
    """Return the waits that never end: each server waited for is created after another one of them.

    A wait for a server that no node of the code creates may end, as other nodes may create it.
    """
    stuck = list(waits)
    while True:
        left = [
            each
            for each in stuck
            if (servers := _servers(each.name, _SERVERS[each.effect.do][0], nodes))
            and all(any(_precedes(wait, *server) for wait in stuck) for server in servers)
        ]
        if len(left) == len(stuck):
            return left
        stuck = left


def _precedes(wait: _Wait, node: NodeFact, server: Entity) -> bool:
    """Return whether the thread that waits creates a server only after that wait."""
    return wait.node.is_beside(node) and 0 < wait.effect.order < server.order


def _unspun(node: NodeFact) -> Iterator[tuple[Place, Finding]]:
    """Yield calls of the thread that starts a node, before it begins to run its callbacks."""
    is_lent = node.is_lent or bool(node.lent_to)
    if not node.spun and (is_lent or node.threads != "not spun"):
        return
    for callback in node.callbacks:
        for effect in callback.effects if callback.kind in STARTING else ():
            words = _waits_unspun(effect, node)
            if words and 0 < effect.order < (node.spun or effect.order + 1):
                who = f"{callback.name} of {node.name}"
                yield effect.at, UNSPUN.found(node.name, callback.name, who=who, words=words)


def _of_helper(helper: NodeFact, nodes: list[NodeFact]) -> Iterator[tuple[NodeFact, Place, Finding]]:
    """Yield the calls of other nodes through a client of a node that no executor ever runs.

    In C++, a spin in code that is not in the folder is possible.
    """
    is_known = helper.threads == "not spun"
    if helper.spun or helper.is_lent or helper.lent_to or not (is_known or helper.executor == NO_SPIN):
        return
    around = [node for node in nodes if node is not helper and node.is_beside(helper)]
    every = [(node, each) for node in around for each in node.callbacks]
    if any(effect.do.startswith("spin") for _, each in every for effect in each.effects):
        return
    for node, callback in every:
        for effect in callback.effects:
            is_endless = effect.how == "blocks, without time-out"
            if effect.do != "call" or not is_endless or effect.entity not in helper.entities:
                continue
            what = effect.entity.name or effect.entity.port
            words = (
                f"waits for the response of {what} through a client of {helper.name}: forever, "
                f"as no executor runs {helper.name}"
            )
            who = f"{callback.name} of {node.name}"
            found = UNSPUN.found(node.name, callback.name, who=who, words=words)
            is_certain = is_known and effect.when != "conditional"
            yield node, effect.at, found if is_certain else replace(found, severity="warning")


def _waits_unspun(effect: Effect, node: NodeFact) -> str:
    """Return in words why a wait never ends without an executor of the node; empty: it may end."""
    when = "before an executor runs the node" if node.spun else "and no executor runs the node"
    entity = effect.entity
    if effect.do == "call" and entity in node.entities and effect.when != "conditional":
        what = entity.name or entity.port
        is_endless = effect.how == "blocks, without time-out"
        words = f"waits for the response of {what} {when}: forever, as nothing processes the response"
        return words if is_endless else ""
    if (effect.do, effect.how) == ("sleep", "rate") and effect.at.file.endswith(".py"):
        return f"sleeps on a rate {when}: forever, as nothing runs the timer of the rate"
    is_loop = effect.do == "loop" and effect.how and effect.when == "always"
    if is_loop and any(node.of(kind) for kind in _SERVING):
        return f"never leaves a loop ({effect.what}) {when}: its callbacks never run"
    return ""


_SERVING = ("subscriptions", "timers", "services", "action_servers")
"""Entities whose callbacks an executor runs."""
