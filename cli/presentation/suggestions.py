"""Prints suggested changes: capacities, callback groups and threads, start orders; as text and as JSON."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dineros.cli.analysing import say_witness
from dineros.cli.console import SEVERITIES, say, say_json, summarise
from dineros.cli.models import rules_of
from dineros.metamodel.errors import counted

if TYPE_CHECKING:
    from dineros.analysis.suggestions.callback_groups import Suggestion
    from dineros.analysis.suggestions.capacities import Capacity
    from dineros.analysis.suggestions.start_orders import StartOrder
    from dineros.analysis.witnesses.findings import Finding
    from dineros.metamodel import pn


def say_capacities(
    found: Sequence[Capacity], model: Path, as_json: bool, witnesses: bool, ending: str = ""
) -> None:
    """Print the capacity of each queue, and the needed one; and why the list is incomplete, if it is."""
    if as_json:
        rows = [
            {
                "elements": list(capacity.queue.elements),
                "queue": str(capacity.queue),
                "limit": capacity.limit,
                "needed": capacity.needed,
                "reason": capacity.reason,
                "grows": capacity.grows,
                "fix": capacity.fix,
                "witness": capacity.witness.to_dict() if capacity.witness else None,
            }
            for capacity in found
        ]
        report = {"model": str(model), "capacities": rows}
        say_json({**report, "unknown": [f"all other queues: {ending}"]} if ending else report)
    else:
        for capacity in found:
            needed = f"needs {capacity.needed}"
            if capacity.needed is None:
                needed = f"{'none' if capacity.grows else 'unknown'}: {capacity.reason}"
            fix = f"; bounded with {capacity.fix}" if capacity.fix else ""
            if capacity.queue.reader_of_newest is not None:
                fix = " (its reader needs the newest message only)"
            say(f"{capacity.queue}: has {capacity.limit}, {needed}{fix}")
            if witnesses and capacity.witness:
                say_witness(capacity.witness)
        if ending:
            say(f"unknown: all other queues: {ending}", "magenta")
        summarise(f"{model}: {counted(len(found), 'queue')}")


def say_callback_groups(
    found: Suggestion, net: pn.Net, model: Path, as_json: bool, witnesses: bool, ending: str = ""
) -> None:
    """Print changes of callback groups and threads, the faults that they fix, and the proofs."""
    reason = ending or found.reason
    if as_json:
        changes = _changes(found.changes)
        faults = [fault.to_dict() for fault in found.faults]
        report = {"found": found.is_found, "proved": found.is_proved, "changes": changes, "mends": faults}
        report |= {"others": [_changes(each) for each in found.others], "breaks": found.breaks}
        _say_json(net, model, report, found.tried, reason)
        return
    _say_faults(found.faults, witnesses)
    for which, made in [("change", found.changes), *(("or", other) for other in found.others)]:
        for words, settings in made:
            say(f"{which}: {words}: {' '.join(f'--set {shlex.quote(each)}' for each in settings)}")
    if found.is_found:
        heard = any(fault.rule == "cancel-never-heard" for fault in found.faults)
        waits = "no callback waits forever" + (", requests to cancel reach the server" if heard else "")
        with_it = ", and no further queue overflows" if found.changes else ""
        least = "; no smaller change suffices" if found.changes and found.is_proved else ""
        say(f"proved: {waits}{with_it}{least}")
    for broken in found.breaks:
        say(f"warning: after the change, {broken}", SEVERITIES["warning"])
    if reason:
        what = "whether a smaller change suffices" if found.is_found else "what to change"
        none = found.is_proved and not found.is_found
        say(f"none: {reason}" if none else f"unknown: {what}: {reason}", "magenta")
    summarise(f"{model}: {counted(len(found.changes), 'change')}, {counted(found.tried, 'model')} checked")


def say_start_order(
    found: StartOrder, net: pn.Net, model: Path, as_json: bool, witnesses: bool, ending: str = ""
) -> None:
    """Print a start order of nodes, and its proof."""
    reason, steps = ending or found.reason, list(zip(found.order, found.settings, strict=True))
    if as_json:
        order = [{"transition": what, "node": node, "setting": setting} for (what, node), setting in steps]
        faults = [fault.to_dict() for fault in found.faults]
        proved = found.is_found or found.is_proved
        report = {"found": found.is_found, "proved": proved, "order": order, "mends": faults}
        _say_json(net, model, report, found.tried, reason)
        return
    _say_faults(found.faults, witnesses)
    for (what, node), setting in steps:
        say(f"{what} {node}: --set {shlex.quote(setting)}")
    if found.is_found:
        order_text = "in this order" if found.order else "in the order that the model has"
        say(f"proved: {order_text}, no message is lost while the nodes come up")
    else:
        say(f"{'none' if found.is_proved else 'unknown: what to change'}: {reason}", "magenta")
    summarise(f"{model}: {counted(found.tried, 'start order')} checked")


def _changes(changes: Sequence[tuple[str, tuple[str, ...]]]) -> list[dict[str, Any]]:
    return [{"text": words, "settings": list(settings)} for words, settings in changes]


def _say_json(net: pn.Net, model: Path, report: dict[str, Any], checked: int, reason: str) -> None:
    say_json({"model": str(model), **rules_of(net), **report, "checked": checked, "reason": reason})


def _say_faults(faults: Sequence[Finding], witnesses: bool) -> None:
    """Print the faults to fix."""
    for fault in faults:
        say(f"to fix: {fault.message}", "bold red")
        if witnesses and fault.witness:
            say_witness(fault.witness)
