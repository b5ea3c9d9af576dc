"""What code shows to be wrong that no model of callbacks does: sleeps, waits without bound, spins, loops."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from dineros.analysis.witnesses.findings import Finding, Severity
from dineros.sources.facts import CallbackFact, Effect, Facts, NodeFact, Place

LONG = 1.0
"""Seconds of a sleep that is reported."""

_CALLED = ("subscription", "timer", "service", "goal", "cancel", "accepted", "done callback", "feedback")
"""Kinds of callbacks that an executor runs in turn."""
_SPINS = (
    "rclpy before July 2024 (ros2/rclpy#1316) takes the node from its executor for good; "
    "later ones still never run what is in the callback's own group"
)


def code_findings(read: Iterable[tuple[str, Facts]]) -> list[Finding]:
    """Return what is found in the code of folders, in the order of the code.

    Parameters
    ----------
    read : iterable of (str, Facts)
        Each folder, and what was read there.
    """
    found: list[tuple[str, int, Finding]] = []
    for folder, facts in read:
        for node in facts.nodes:
            for callback in node.callbacks:
                if _holds_others_up(callback, node):
                    of_callback = _of_callback(callback, node, folder)
                    found += [(place.file, place.line, finding) for place, finding in of_callback]
            found += [(at.file, at.line, each) for at, each in _locks(node, folder)]
    unique = {finding: (file, line) for file, line, finding in found}
    return sorted(unique, key=lambda finding: unique[finding])


def _holds_others_up(callback: CallbackFact, node: NodeFact) -> bool:
    """Tell whether other callbacks wait while one runs; work on goals is in no group, and needs a thread."""
    if node.threads == "not spun":
        return False
    return callback.kind in _CALLED or (callback.kind == "execute" and node.threads == 1)


def _of_callback(callback: CallbackFact, node: NodeFact, folder: str) -> Iterator[tuple[Place, Finding]]:
    who = f"{callback.kind} callback {callback.name} of {node.name}"
    if callback.kind == "execute":
        who = f"callback {callback.name} of {node.name}, which works on goals,"

    def finding(rule: str, severity: Severity, effect: Effect, words: str) -> tuple[Place, Finding]:
        at = f"{folder.rstrip('/')}/{effect.at}" if folder not in ("", ".") else str(effect.at)
        return effect.at, Finding(rule, severity, (node.name,), f"{at}: {who} {words}")

    is_asked = False
    for effect in callback.effects:
        where = " in a loop" if effect.when == "in a loop" else ""
        if effect.do == "sleep" and (effect.timeout or 0) >= LONG:
            words = f"sleeps {effect.timeout:g} s{where}: what waits for it waits as long"
            yield finding("code-sleeps", "warning", effect, words)
        elif effect.do in ("wait_for_service", "wait_for_server") and "without time-out" in effect.how:
            what = "service" if effect.do.endswith("service") else "action server"
            words = f"waits without time-out for the {what} of {effect.what}: forever, if that is not there"
            yield finding("code-waits", "warning", effect, words)
        elif effect.do in ("spin", "spin_once", "spin_until"):
            words = f"spins ({effect.do}{where}) while its executor runs it: {_SPINS}"
            yield finding("code-spins", "error", effect, words)
        elif effect.do == "loop" and effect.how:
            words = f"may loop forever ({effect.what}): {effect.how}"
            yield finding("code-never-ends", "warning", effect, words)
        elif effect.do == "input" and not is_asked:
            is_asked = True
            yield finding("code-waits", "warning", effect, "waits for somebody to type")
        elif effect.do == "send_goal" and effect.how == "async and ignored":
            yield finding(
                "code-ignores", "note", effect, f"ignores what becomes of its goal of {effect.what}"
            )
        elif (effect.do, effect.what) == ("create", "client") and not _destroys(callback):
            yield finding("code-makes-clients", "note", effect, "makes a client each time, and destroys none")


def _destroys(callback: CallbackFact) -> bool:
    return any(each.do == "destroy" for each in callback.effects)


def _locks(node: NodeFact, folder: str) -> Iterator[tuple[Place, Finding]]:
    """Yield waits under a lock that another callback of the node wants, too."""
    if node.threads in (1, "not spun") and not any(each.kind == "thread" for each in node.callbacks):
        return  # no two callbacks run at once
    users: dict[str, set[str]] = {}
    for callback in node.callbacks:
        for effect in callback.effects:
            if effect.do == "lock":
                users.setdefault(effect.what, set()).add(callback.name)
    for callback in node.callbacks:
        for effect in callback.effects:
            waits = (
                (effect.do == "call" and effect.how.startswith(("blocks", "spin", "waits", "polled")))
                or effect.do in ("wait_for_service", "wait_for_server", "spin_until", "spin")
                or (effect.do == "sleep" and (effect.timeout or 0) >= LONG)
            )
            for lock in effect.holding if waits else ():
                others = sorted(users.get(lock, set()) - {callback.name})
                if others:
                    at = f"{folder.rstrip('/')}/{effect.at}" if folder not in ("", ".") else str(effect.at)
                    words = f"{at}: {callback.name} of {node.name} waits ({effect.do}) while it holds {lock}"
                    message = f"{words}, which {', '.join(others)} wants, too"
                    yield effect.at, Finding("code-holds-lock", "warning", (node.name,), message)
