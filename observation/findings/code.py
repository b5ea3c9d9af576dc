"""Faults in code that models of callbacks do not show: sleeps, unbounded waits, spins, loops."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import replace

from dineros.analysis.witnesses.findings import Fault, Finding
from dineros.observation.findings.locks import HOLDS, lock_waits
from dineros.observation.findings.losing import FAULTS as OF_LOSSES
from dineros.observation.findings.losing import losses, said
from dineros.observation.findings.own_waits import OWN, never_set, own_waits
from dineros.observation.findings.serving import CALLED, group_of_callback
from dineros.observation.findings.sleeping import LONG, sleeps_of
from dineros.observation.findings.starting import FAULTS as OF_STARTS
from dineros.observation.findings.starting import starts
from dineros.observation.findings.transforms import FAULTS as OF_TRANSFORMS
from dineros.observation.findings.transforms import lookups
from dineros.observation.findings.unrun import UNRUN, unrun
from dineros.sources.facts import (
    MAY_TAKE_AWAY,
    NEVER_SET,
    SPINS_OTHERS,
    TAKES_AWAY,
    CallbackFact,
    Effect,
    Facts,
    NodeFact,
)
from dineros.sources.places import Place, located
from dineros.sources.unknown_ends import ONE_VALUE

SLEEPS = Fault("code-sleeps", "warning", "A callback sleeps a second or more.", "{who} {words}")
WAITS = Fault("code-waits", "warning", "A callback waits without time-out.", "{who} {words}")
SPINS = Fault(
    "code-spins",
    "error",
    "A spin takes a node from its executor.",
    "{who} {words}",
)
LOOPS = Fault("code-never-ends", "warning", "A loop in a callback may have no way out.", "{who} {words}")
GIVES = Fault(
    "code-gives-none",
    "error",
    "A callback does not return what rclpy needs: a response, a result.",
    "{who} {words}",
)
FORGETS = Fault(
    "code-never-awaits",
    "warning",
    "A callback calls a coroutine and does not await it, or is a generator: nothing of it runs.",
    "{who} {words}: nothing of it runs",
)
IGNORES = Fault("code-ignores", "note", "The result of a goal is ignored.", "{who} {words}")
MAKES = Fault("code-makes-clients", "note", "A callback creates a client in each run.", "{who} {words}")

FAULTS = {
    fault.rule: fault
    for fault in (
        SLEEPS,
        WAITS,
        SPINS,
        LOOPS,
        HOLDS,
        OWN,
        GIVES,
        FORGETS,
        IGNORES,
        MAKES,
        *OF_LOSSES,
        *OF_STARTS,
        *OF_TRANSFORMS,
        UNRUN,
    )
}
"""All of them, by name."""

_THROWS = "rclcpp throws an exception, as the node is in an executor already"
_SPINS = (
    "rclpy before July 2024 (ros2/rclpy#1316) removes the node from its executor permanently; "
    "later ones still never run what is in the callback's own group"
)


def code_findings(
    read: Iterable[tuple[str, Facts]], modelled: Collection[Effect] = frozenset()
) -> list[Finding]:
    """Return the findings in the code of folders, in the order of the code.

    The elements of a finding are the names of node and callback. What a callback does at several lines is one
    finding with these lines.

    Parameters
    ----------
    read : iterable of (str, Facts)
        Each folder, with its facts.
    modelled : collection of Effect
        Waits that the model has: it shows whether they end.
    """
    found: list[tuple[str, int, Finding]] = []
    read = list(read)
    folders = {id(node): folder for folder, facts in read for node in facts.nodes}
    for node, place, finding in starts(node for _, facts in read for node in facts.nodes):
        found.append(_at(place, folders[id(node)], finding))
    for folder, facts in read:
        for node in facts.nodes:
            for callback in node.callbacks:
                inside = [*_endless(callback, node), *_gives(callback, node), *_taken(callback, node)]
                if _holds_others_up(callback, node) or callback.kind == "constructor":
                    inside += lookups(callback, node, said(callback, node), group_of_callback)
                if _holds_others_up(callback, node):
                    inside += _of_callback(callback, node)
                    inside += own_waits(callback, node, facts.nodes, modelled)
                found += [_at(place, folder, finding) for place, finding in inside]
            waits = ((wait.at, finding) for wait, finding in lock_waits(node, facts.nodes))
            found += [_at(place, folder, finding) for place, finding in (*waits, *unrun(node))]
        found += [_at(place, folder, finding) for place, finding in losses(facts.nodes)]
    unique: dict[Finding, dict[str, None]] = {}
    for _, _, finding in sorted(found, key=lambda each: each[:2]):
        unique.setdefault(replace(finding, lines=()), {}).update(dict.fromkeys(finding.lines))
    return [replace(finding, lines=tuple(lines)) for finding, lines in unique.items()]


def _at(place: Place, folder: str, finding: Finding) -> tuple[str, int, Finding]:
    return place.file, place.line, replace(finding, lines=(located(place, folder),))


def _holds_others_up(callback: CallbackFact, node: NodeFact) -> bool:
    """Return whether other callbacks wait while one runs; work on goals has no group, but needs a thread."""
    if node.threads == "not spun":
        return False
    return callback.kind in CALLED or (
        callback.kind == "execute" and node.is_single and not callback.is_apart
    )


def _of_callback(callback: CallbackFact, node: NodeFact) -> Iterator[tuple[Place, Finding]]:
    who = said(callback, node)
    if callback.kind == "execute":
        who = f"callback {callback.name} of {node.name}, which works on goals,"

    def finding(fault: Fault, effect: Effect, words: str) -> tuple[Place, Finding]:
        return effect.at, fault.found(node.name, callback.name, who=who, words=words)

    is_asked = False
    for effect in callback.effects:
        where = " in a loop" if effect.when == "in a loop" else ""
        if effect.do == "sleep" and (effect.timeout or 0) >= LONG:
            words = f"sleeps {effect.timeout:g} s{where}, and delays everything that waits for it"
            yield finding(SLEEPS, effect, words)
        elif effect.do in ("wait_for_service", "wait_for_server") and (
            effect.is_repeated or "without time-out" in effect.how
        ):
            what = "service" if effect.do.endswith("service") else "action server"
            words = f"waits without time-out for the {what} of {effect.what}: forever, if it is missing"
            yield finding(WAITS, effect, words)
        elif effect.do == "wait_for_message" and effect.how == "without time-out":
            words = f"waits without time-out for {effect.what}: forever, if none comes"
            if node.is_single:
                words += ", or if only callbacks of its own executor publish it"
            yield finding(WAITS, effect, words)
        elif effect.do.startswith("spin") and effect.how.startswith(SPINS_OTHERS):
            if "without time-out" in effect.how:
                words = "waits without time-out, by an executor of its own: forever, if no response comes"
                yield finding(WAITS, effect, words)
        elif effect.do in ("spin", "spin_once", "spin_until"):
            outcome = _SPINS if effect.at.file.endswith(".py") else _THROWS
            words = f"spins ({effect.do}{where}) while its executor runs it: {outcome}"
            yield finding(SPINS, effect, words)
        elif effect.do == "loop" and effect.how:
            yield effect.at, _loop(effect, callback, node, who)
        elif effect.do == "forgets":
            words = f"calls the coroutine {effect.what} and does not await it"
            if effect.how == "generator":
                words = "has yield, so a call only makes a generator, and rclpy asks it for nothing"
            yield finding(FORGETS, effect, words)
        elif effect.do == "input" and not is_asked:
            is_asked = True
            yield finding(WAITS, effect, "waits for keyboard input")
        elif effect.do == "send_goal" and effect.how == "async and ignored":
            yield finding(IGNORES, effect, f"ignores the result of its goal of {effect.what}")
        elif (effect.do, effect.what) == ("create", "client") and not _destroys(callback):
            yield finding(MAKES, effect, "creates a client in each run, and destroys none")
    sleeps, total = sleeps_of(callback.body or ())
    if total >= LONG and all((each.timeout or 0) < LONG for each in callback.effects if each.do == "sleep"):
        words = f"sleeps {total:g} s in all, and delays everything that waits for it"
        yield finding(SLEEPS, sleeps[0], words)


def _loop(effect: Effect, callback: CallbackFact, node: NodeFact, who: str) -> Finding:
    """Return the finding of a loop without end: an error if what its test asks has one value."""
    is_certain = effect.how.startswith(ONE_VALUE)
    words = f"{'loops' if is_certain else 'may loop'} forever ({effect.what}): {effect.how}"
    found = LOOPS.found(node.name, callback.name, who=who, words=words)
    return replace(found, severity="error") if is_certain and effect.when != "conditional" else found


def _endless(callback: CallbackFact, node: NodeFact) -> Iterator[tuple[Place, Finding]]:
    """Yield waits of work on a goal in a thread of its own, which circles of callbacks cannot show."""
    if callback.kind == "execute" and not _holds_others_up(callback, node):
        who = f"callback {callback.name} of {node.name}, which works on goals,"
        for effect in callback.effects:
            if effect.do == "loop" and effect.how.startswith(ONE_VALUE):
                yield effect.at, _loop(effect, callback, node, who)
            elif effect.do == "wait" and effect.how.endswith(NEVER_SET):
                yield effect.at, never_set(callback, node, effect, who)
    for effect in callback.effects if callback.is_apart else ():
        if effect.do == "call" and effect.how == "blocks, without time-out":
            who = f"the work on goals of {node.name} ({callback.name})"
            words = f"waits without time-out for {effect.what}: without a response, the goal never ends"
            yield effect.at, WAITS.found(node.name, callback.name, who=who, words=words)


def _taken(callback: CallbackFact, node: NodeFact) -> Iterator[tuple[Place, Finding]]:
    """Yield spins outside of callbacks that take the node out of its executor."""
    for effect in callback.effects:
        if TAKES_AWAY in effect.how or MAY_TAKE_AWAY in effect.how:
            words = (
                f"spins ({effect.do}) by a function of rclpy after the node was added to an executor: this "
                "removes the node from its executor permanently, and no callback of it runs any more"
            )
            who = f"{callback.name} of {node.name}"
            found = SPINS.found(node.name, callback.name, who=who, words=words)
            yield effect.at, found if TAKES_AWAY in effect.how else replace(found, severity="warning")


_NEEDS = {
    "service": ("response", "the program ends with TypeError, and the client waits forever"),
    "execute": ("result", "the client never gets one"),
    "goal": ("GoalResponse", "every such goal is rejected"),
    "cancel": ("CancelResponse", "every such request is rejected"),
}
"""What callbacks of rclpy return, and what happens otherwise."""


def _gives(callback: CallbackFact, node: NodeFact) -> Iterator[tuple[Place, Finding]]:
    """Yield callbacks that do not return what rclpy needs; those that may not are warnings."""
    if callback.lacks and not callback.at.file.endswith(".py"):
        if callback.lacks == "always":
            words = (
                "gets no response to fill, and no code sends one by send_response: the client waits forever"
            )
            yield callback.at, GIVES.found(node.name, callback.name, who=said(callback, node), words=words)
    elif callback.lacks:
        what, then = _NEEDS[callback.kind]
        verb = "returns" if callback.lacks == "always" else "may return"
        words = f"{verb} no {what}: {then}"
        found = GIVES.found(node.name, callback.name, who=said(callback, node), words=words)
        is_certain = callback.lacks == "always" and callback.kind in ("service", "execute")
        yield callback.at, found if is_certain else replace(found, severity="warning")


def _destroys(callback: CallbackFact) -> bool:
    return any(each.do == "destroy" for each in callback.effects)
