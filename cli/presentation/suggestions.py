"""What to change: capacities of queues, callback groups and threads, start orders; as text and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dineros.cli.analysing import say_witness
from dineros.cli.console import say, say_json, summarise
from dineros.cli.models import rules_of
from dineros.metamodel.errors import counted

if TYPE_CHECKING:
    from dineros.analysis.suggestions.callback_groups import Suggestion
    from dineros.analysis.suggestions.capacities import Capacity
    from dineros.analysis.suggestions.start_orders import StartOrder
    from dineros.metamodel import pn


def say_capacities(
    found: Sequence[Capacity], model: Path, as_json: bool, witnesses: bool, ending: str = ""
) -> None:
    """Print what capacity each queue has, and what it needs; and why there are no more of them, if so."""
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
            say(f"{capacity.queue}: has {capacity.limit}, {needed}{fix}")
            if witnesses and capacity.witness:
                say_witness(capacity.witness)
        if ending:
            say(f"unknown: all other queues: {ending}", "magenta")
        summarise(f"{model}: {counted(len(found), 'queue')}")


def say_callback_groups(
    suggestion: Suggestion, net: pn.Net, model: Path, as_json: bool, witnesses: bool
) -> None:
    """Print which callback groups and threads to change, what that mends, and what is proved of it."""
    if as_json:
        say_json({"model": str(model), **rules_of(net), **_groups_json(suggestion)})
        return
    for fault in suggestion.faults:
        say(f"to mend: {fault.message}", "bold red")
        if witnesses and fault.witness:
            say_witness(fault.witness)
    for words, settings in suggestion.changes:
        say(f"change: {words}: {' '.join(f'--set {setting}' for setting in settings)}")
    tried = f"{counted(suggestion.tried, 'model')} checked"
    if suggestion.is_found:
        with_it = ", and no queue overflows that did not before" if suggestion.changes else ""
        least = "; no smaller change is enough" if suggestion.changes and suggestion.is_proved else ""
        say(f"proved: no callback waits for ever{with_it}{least}")
    if suggestion.reason:
        what = "whether a smaller change is enough" if suggestion.is_found else "what to change"
        none = suggestion.is_proved and not suggestion.is_found
        say(f"none: {suggestion.reason}" if none else f"unknown: {what}: {suggestion.reason}", "magenta")
    summarise(f"{model}: {counted(len(suggestion.changes), 'change')}, {tried}")


def _groups_json(suggestion: Suggestion) -> dict[str, Any]:
    return {
        "found": suggestion.is_found,
        "proved": suggestion.is_proved,
        "changes": [{"text": words, "settings": list(settings)} for words, settings in suggestion.changes],
        "mends": [
            {
                "rule": fault.rule,
                "elements": list(fault.elements),
                "message": fault.message,
                "circle": list(fault.circle),
                "witness": fault.witness.to_dict() if fault.witness else None,
            }
            for fault in suggestion.faults
        ],
        "checked": suggestion.tried,
        "reason": suggestion.reason,
    }


def say_start_order(found: StartOrder, net: pn.Net, model: Path, as_json: bool, witnesses: bool) -> None:
    """Print in which order to bring nodes up, and what is proved of it."""
    if as_json:
        say_json({"model": str(model), **rules_of(net), **_order_json(found)})
        return
    for fault in found.faults:
        say(f"to mend: {fault.message}", "bold red")
        if witnesses and fault.witness:
            say_witness(fault.witness)
    for (what, node), setting in zip(found.order, found.settings, strict=True):
        say(f"{what} {node}: --set {setting}")
    if found.is_found:
        order = "in this order" if found.order else "in the order that the model has"
        say(f"proved: {order}, no message is lost while the nodes come up")
    else:
        none = "none" if found.is_proved else "unknown: what to change"
        say(f"{none}: {found.reason}", "magenta")
    summarise(f"{model}: {counted(found.tried, 'start order')} checked")


def _order_json(found: StartOrder) -> dict[str, Any]:
    return {
        "found": found.is_found,
        "proved": found.is_found or found.is_proved,
        "order": [
            {"transition": what, "node": node, "setting": setting}
            for (what, node), setting in zip(found.order, found.settings, strict=True)
        ],
        "mends": [
            {
                "rule": fault.rule,
                "elements": list(fault.elements),
                "message": fault.message,
                "witness": fault.witness.to_dict() if fault.witness else None,
            }
            for fault in found.faults
        ],
        "checked": found.tried,
        "reason": found.reason,
    }
