"""Faults in code that models of callbacks do not show: sleeps, unbounded waits, spins, loops."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from dineros.analysis.witnesses.findings import Fault, Finding, Severity
from dineros.observation.findings.losing import FAULTS as OF_LOSSES
from dineros.observation.findings.losing import losses, said
from dineros.observation.findings.sleeping import sleeps_of
from dineros.observation.findings.starting import FAULTS as OF_STARTS
from dineros.observation.findings.starting import starts
from dineros.observation.findings.transforms import FAULTS as OF_TRANSFORMS
from dineros.observation.findings.transforms import lookups
from dineros.observation.findings.unrun import UNRUN, unrun
from dineros.sources.facts import (
    AWAITED,
    BARRIER,
    HELD,
    MAY_TAKE_AWAY,
    SPINS_OTHERS,
    TAKES_AWAY,
    CallbackFact,
    Effect,
    Entity,
    Facts,
    NodeFact,
    is_open,
)
from dineros.sources.places import Place, located

LONG = 1.0
"""Least seconds of a sleep that is reported."""

SLEEPS = Fault("code-sleeps", "warning", "A callback sleeps a second or more.", "{who} {words}")
WAITS = Fault("code-waits", "warning", "A callback waits without time-out.", "{who} {words}")
SPINS = Fault(
    "code-spins",
    "error",
    "A spin takes a node from its executor.",
    "{who} {words}",
)
LOOPS = Fault("code-never-ends", "warning", "A loop in a callback may have no way out.", "{who} {words}")
HOLDS = Fault(
    "code-holds-lock",
    "warning",
    "A callback waits while it holds a lock that another callback needs.",
    "{who} waits ({does}) while it holds {lock}, which {others} also needs",
)
OWN = Fault(
    "code-waits-for-itself",
    "error",
    "A callback waits for something that only blocked callbacks can do.",
    "{who} {words}",
)
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

_CALLED = (
    *("subscription", "timer", "service", "goal", "cancel", "accepted", "done callback", "feedback"),
    *("transition", "parameters", "task"),
)
"""Kinds of callbacks that an executor runs in turn."""
_THROWS = "rclcpp throws an exception, as the node is in an executor already"
_SPINS = (
    "rclpy before July 2024 (ros2/rclpy#1316) removes the node from its executor permanently; "
    "later ones still never run what is in the callback's own group"
)


def code_findings(read: Iterable[tuple[str, Facts]]) -> list[Finding]:
    """Return the findings in the code of folders, in the order of the code.

    The elements of a finding are the names of node and callback. What a callback does at several lines is one
    finding with these lines.

    Parameters
    ----------
    read : iterable of (str, Facts)
        Each folder, with its facts.
    """
    found: list[tuple[str, int, Finding]] = []
    read = list(read)
    folders = {id(node): folder for folder, facts in read for node in facts.nodes}
    for node, place, finding in starts(node for _, facts in read for node in facts.nodes):
        found.append(_at(place, folders[id(node)], finding))
    for folder, facts in read:
        for node in facts.nodes:
            for callback in node.callbacks:
                found += [_at(place, folder, finding) for place, finding in _endless(callback, node)]
                found += [_at(place, folder, finding) for place, finding in _gives(callback, node)]
                found += [_at(place, folder, finding) for place, finding in _taken(callback, node)]
                if _holds_others_up(callback, node) or callback.kind == "constructor":
                    vain = lookups(callback, node, said(callback, node), _group)
                    found += [_at(place, folder, finding) for place, finding in vain]
                if _holds_others_up(callback, node):
                    of_callback = _of_callback(callback, node)
                    found += [_at(place, folder, finding) for place, finding in of_callback]
                    found += [
                        _at(place, folder, finding) for place, finding in _own(callback, node, facts.nodes)
                    ]
            found += [_at(place, folder, finding) for place, finding in (*_locks(node), *unrun(node))]
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
    return callback.kind in _CALLED or (
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
            yield finding(LOOPS, effect, f"may loop forever ({effect.what}): {effect.how}")
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


def _endless(callback: CallbackFact, node: NodeFact) -> Iterator[tuple[Place, Finding]]:
    """Yield waits of work on a goal in a thread of its own, which circles of callbacks cannot show."""
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
    if callback.lacks and callback.at.file.endswith(".py"):
        what, then = _NEEDS[callback.kind]
        verb = "returns" if callback.lacks == "always" else "may return"
        words = f"{verb} no {what}: {then}"
        found = GIVES.found(node.name, callback.name, who=said(callback, node), words=words)
        is_certain = callback.lacks == "always" and callback.kind in ("service", "execute")
        yield callback.at, found if is_certain else replace(found, severity="warning")


def _destroys(callback: CallbackFact) -> bool:
    return any(each.do == "destroy" for each in callback.effects)


def _locks(node: NodeFact) -> Iterator[tuple[Place, Finding]]:
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
                if waits:
                    others = {each.name for each in users.get(lock, ()) if each.name != callback.name}
                    yield from _held(effect, callback, node, effect.do, lock, others)
                elif effect.do == "lock" and lock != effect.what:
                    # A fault if another callback, or another run of this one, has the other order.
                    group = _group(callback, node)
                    others = {
                        each.name
                        for each in orders.get((effect.what, lock), ())
                        if (
                            _overlaps_itself(callback, node)
                            if each is callback
                            else group is None or _group(each, node) != group
                        )
                    }
                    yield from _held(effect, callback, node, f"for {effect.what}", lock, others)


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


def _own(
    callback: CallbackFact, node: NodeFact, nodes: Iterable[NodeFact]
) -> Iterator[tuple[Place, Finding]]:
    """Yield waits of a callback for an event or a rate that its own thread or group would have to serve."""
    who = said(callback, node)
    for effect in callback.effects:
        is_rate = (effect.do, effect.how) == ("sleep", "rate") and effect.at.file.endswith(".py")
        if is_rate and _may_be_one(node):  # in C++, a rate needs no timer
            words = "sleeps on a rate, whose timer needs the only thread, and never wakes up"
            found = OWN.found(node.name, callback.name, who=who, words=f"{words}{_if_one(node)}")
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
        elif _blocks_outside(effect, callback) and _may_be_one(node):
            what = (
                f"{_GOALS[effect.do]} of a goal" if effect.do in _GOALS else f"the response of {effect.what}"
            )
            words = f"waits for {what}, which needs the only thread, and never ends"
            found = OWN.found(node.name, callback.name, who=who, words=f"{words}{_if_one(node)}")
            is_certain = node.is_single and effect.when == "always"
            yield effect.at, found if is_certain else replace(found, severity="warning")
        elif effect.do == "cancel_goal" and effect.how.startswith("blocks"):
            words = "waits for the answer to its request to cancel a goal"
            group = None if effect.entity is None else _common_group([effect.entity], node)
            if _may_be_one(node):
                words += f", which needs the only thread, and never ends{_if_one(node)}"
            elif group is not None and group == _group(callback, node):
                words += f", which needs the callback group that {callback.name} itself holds, and never ends"
            else:
                continue
            found = OWN.found(node.name, callback.name, who=who, words=words)
            yield effect.at, replace(found, severity="warning") if is_open(node.threads) else found
        elif effect.do == "wait" and (why := _never_meanwhile(callback, node, effect, nodes)):
            found = OWN.found(node.name, callback.name, who=who, words=f"waits for {effect.what}, {why}")
            ends = f": it waits {effect.timeout:g} s in vain" if effect.timeout is not None else ": forever"
            is_certain = effect.timeout is None and "open" not in effect.how and "if the executor" not in why
            severity: Severity = "error" if is_certain else "warning"
            message = f"{found.message}{ends}, if that is not set before"
            yield effect.at, replace(found, severity=severity, message=message)


MANY = 1000
"""Number of runs of callbacks that may overlap without limit."""


def _sleepers(node: NodeFact, nodes: Iterable[NodeFact]) -> int:
    """Return how many callbacks on an executor can sleep on a rate of rclpy at once."""
    groups: set[object] = set()
    for other in nodes:
        for each in (
            other.callbacks if other is node or (other.is_beside(node) and other.pool == node.pool) else ()
        ):
            if each.kind in (*_CALLED, "execute") and any(
                (effect.do, effect.how) == ("sleep", "rate") for effect in each.effects
            ):
                if _overlaps_itself(each, other):
                    return MANY
                group = _group(each, other)
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
        other is node and each is not callback and each.kind in _CALLED and not each.is_open
        for each, other in setters
    )
    if not setters or not is_own:
        return None
    names = ", ".join(dict.fromkeys(each.name for each, _ in setters))
    if _may_be_one(node) and not is_suspended:
        return f"which only {names} sets: the only thread is here{_if_one(node)}"
    group = _group(callback, node)
    if group is None or any(_common_group(_starters(each, node), node) != group for each, _ in setters):
        return None
    return f"which only {names} sets, in the callback group that {callback.name} itself holds"


def _ends(done: Effect, wait: Effect, *, is_own: bool) -> bool:
    """Return whether an effect of the waiting callback, or of another one, ends a wait."""
    return (done.do, done.what) == ("notify", wait.what) and not (is_own and done.how == BARRIER)


def _may_be_one(node: NodeFact) -> bool:
    """Return whether an executor has one thread, or an unknown number."""
    return node.is_single or (is_open(node.threads) and not node.apart)


def _if_one(node: NodeFact) -> str:
    return "" if node.is_single else f", if the executor has one thread ({node.threads})"


def _overlaps_itself(callback: CallbackFact, node: NodeFact) -> bool:
    """Return whether several runs of a callback may overlap, if there are several threads."""
    kinds = [
        str(group.details.get("kind", ""))
        for entity in node.entities
        if callback in entity.callbacks.values() and (group := node.group_of(entity)) is not None
    ]
    return callback.kind == "execute" or any(kind.startswith("reentrant") for kind in kinds)


def _group(callback: CallbackFact, node: NodeFact) -> str | None:
    """Return the mutually exclusive group that a callback is known to be in."""
    return _common_group((each for each in node.entities if callback in each.callbacks.values()), node)


def _common_group(entities: Iterable[Entity], node: NodeFact) -> str | None:
    """Return the mutually exclusive group that all entities are known to be in."""
    found: set[str | None] = set()
    for entity in entities:
        said = str(entity.details.get("group", "default"))
        if is_open(said):
            return None
        group = node.group_of(entity)
        if group is None:
            found.add("default")
        elif str(group.details.get("kind", "")).startswith("exclusive"):
            found.add(f"{group.at} {id(group)}")  # a line may make several
        else:
            found.add(None)
    return found.pop() if len(found) == 1 else None


def _starters(callback: CallbackFact, node: NodeFact) -> list[Entity]:
    """Return the entities that start a callback.

    A done callback starts when its client has taken the response, which needs the group of the client. It
    runs in no group then.
    """
    clients = [
        effect.entity
        for each in node.callbacks
        for effect in each.effects
        if (effect.then is callback or callback in effect.meanwhile) and effect.entity is not None
    ]
    return [*clients, *(each for each in node.entities if callback in each.callbacks.values())]
