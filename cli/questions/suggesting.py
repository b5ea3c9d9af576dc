"""``dineros check --suggest-...``: searches for changes of a model and prints them."""

from __future__ import annotations

from collections.abc import Callable, Sized
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.cli.analysing import HOLDS, UNKNOWN, VIOLATED
from dineros.cli.console import warn
from dineros.cli.presentation.suggestions import say_callback_groups, say_capacities, say_start_order
from dineros.cli.searching import search
from dineros.metamodel.errors import DinerosError, Location

if TYPE_CHECKING:
    from dineros.analysis.answers.budget import Budget
    from dineros.analysis.suggestions.callback_groups import Suggestion
    from dineros.analysis.suggestions.start_orders import StartOrder
    from dineros.metamodel import pn


@dataclass(frozen=True)
class _Suggestion:
    """A kind of suggestion: the search, its output (with the reason of an early end), and the exit status."""

    search: Callable[[Budget], object]
    say: Callable[[str], None]
    status: Callable[[], int]


def suggest(option: str, net: pn.Net, model: Path, as_json: bool, witnesses: bool) -> int:
    """Search for the suggestion of an option, print it, and return the exit status.

    Raises
    ------
    DinerosError
        The model has no elements for this suggestion.
    """
    from dineros.analysis.model.assumptions import of_source

    suggestion, run = _KINDS[option](net, model, as_json, witnesses), search()

    def so_far(ending: str) -> int:
        suggestion.say(ending)
        return UNKNOWN

    run.draft(so_far)
    suggestion.search(run.budget())
    with run.answer():
        suggestion.say("")
        for each in of_source(net):
            warn(f"assumes: {each}")
    return suggestion.status()


def _capacities(net: pn.Net, model: Path, as_json: bool, witnesses: bool) -> _Suggestion:
    from dineros.analysis.suggestions.capacities import Capacity, suggest_capacities
    from dineros.metamodel import sym

    if not isinstance(net, sym.SystemModel):
        raise DinerosError("has no queues: it is not a system model", location=Location(model))
    found: list[Capacity] = []

    def status() -> int:
        if all(capacity.needed is not None and capacity.needed <= capacity.limit for capacity in found):
            return HOLDS
        is_open = any(capacity.needed is None and not capacity.grows for capacity in found)
        return UNKNOWN if is_open else VIOLATED

    say = partial(say_capacities, found, model, as_json, witnesses)
    return _Suggestion(partial(suggest_capacities, net, found=found), say, status)


def _callback_groups(net: pn.Net, model: Path, as_json: bool, witnesses: bool) -> _Suggestion:
    from dineros.analysis.suggestions.callback_groups import Suggestion, suggest_callback_groups
    from dineros.metamodel import sym
    from dineros.metamodel.callbacks.groups import runs_callbacks
    from dineros.metamodel.elements import node_nets

    if not isinstance(net, sym.SystemModel):
        raise DinerosError("has no callbacks: it is not a system model", location=Location(model))
    if net.middleware != sym.Middleware.ros2 or not any(map(runs_callbacks, node_nets(net))):
        raise DinerosError(
            "no node net runs callbacks under the rules of ros2",
            location=Location(model),
            hint="set execution=callbacks for node nets that are written by hand, and middleware=ros2",
        )
    found = Suggestion()
    say = partial(say_callback_groups, found, net, model, as_json, witnesses)
    look = partial(suggest_callback_groups, net, suggestion=found)
    return _Suggestion(look, say, lambda: _status(found, found.changes))


def _start_order(net: pn.Net, model: Path, as_json: bool, witnesses: bool) -> _Suggestion:
    from dineros.analysis.suggestions.start_orders import StartOrder, suggest_start_order
    from dineros.metamodel import sym
    from dineros.metamodel.lifecycles.start_order import managed_nodes

    is_of_ros2 = isinstance(net, sym.SystemModel) and net.middleware == sym.Middleware.ros2
    if not isinstance(net, sym.SystemModel) or not is_of_ros2 or not managed_nodes(net):
        raise DinerosError(
            "no node net has a lifecycle under the rules of ros2",
            location=Location(model),
            hint="set NODE.lifecycle.pauses=false for a node that is to be managed, and middleware=ros2",
        )
    found = StartOrder()
    say = partial(say_start_order, found, net, model, as_json, witnesses)
    look = partial(suggest_start_order, net, found=found)
    return _Suggestion(look, say, lambda: _status(found, found.order))


def _status(found: Suggestion | StartOrder, changes: Sized) -> int:
    """Return the exit status: no change needed; a change found or none possible; or unknown."""
    if found.is_found and not changes:
        return HOLDS
    return VIOLATED if found.is_found or found.is_proved else UNKNOWN


_KINDS = {
    "--suggest-capacities": _capacities,
    "--suggest-callback-groups": _callback_groups,
    "--suggest-start-order": _start_order,
}
