"""How often a client's callback is called for the ends of its goals.

A client has at most N goals under way (rule A1). A goal is under way from the moment at which it is sent
until the client takes its result, or the refusal. So in a window, at most N goals and those that are sent in
it end. A goal is sent from a place with a capacity: those sent in a window waited there when it began, or
came in it.

Besides, each goal is accepted once at most. A client of one goal at a time learns that before it takes the
result (rule A9First). A client of several goals can take results while the news that goals are accepted waits
for a callback, so any number of these can wait.
"""

from __future__ import annotations

from dataclasses import dataclass

from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import runs_callbacks
from dineros.metamodel.callbacks.under_way import goal_counts
from dineros.metamodel.calls import UNLIMITED
from dineros.metamodel.elements import node_net_of, node_nets, resolve, system_model_of
from dineros.metamodel.times.once import once
from dineros.metamodel.times.runs import ports_at

_ENDS = ("succeeded", "aborted", "canceled", "rejected")
_ACCEPTED = "accepted"


@dataclass(frozen=True)
class Ended:
    """The goals of a client whose ends call a callback.

    Attributes
    ----------
    client : sym.ActionClientPort
        The client of the action.
    goal : pn.Place
        Where its goals come from.
    times : int
        How often a goal calls the callback at most.
    under_way : int
        How many goals are sent and not over, or wait to be sent, at most.
    """

    client: sym.ActionClientPort
    goal: pn.Place
    times: int
    under_way: int


@once
def goals_ended(page: sym.CallbackPage) -> tuple[Ended, ...] | None:
    """Return the goals whose ends call a callback; None if others call it, or nothing bounds them."""
    model = system_model_of(page)
    if model is None or page.kind != sym.CallbackKind.client or not runs_callbacks(node_net_of(page)):
        return None
    if any(node.lifecycle is not None for node in node_nets(model)):
        return None  # when nodes come and go, goals end in other ways
    counts = goal_counts(model)
    found = []
    for client, names in (_called_by(page) or {}).items():
        goal, most = resolve(client.goal), counts.get(client, UNLIMITED)
        if not isinstance(goal, pn.Place) or not goal.capacity or most == UNLIMITED:
            return None
        if [port for port in ports_at(goal) if port is not client]:
            return None
        if _ACCEPTED in names and most > 1:
            return None
        times = int(not names.isdisjoint(_ENDS)) + int(_ACCEPTED in names)
        found.append(Ended(client, goal, times, max(1, most) + int(goal.capacity)))
    return tuple(found) or None


def _called_by(page: sym.CallbackPage) -> dict[sym.ActionClientPort, set[str]] | None:
    """Return which answers to clients of actions a callback takes; None if it takes what others bring."""
    found: dict[sym.ActionClientPort, set[str]] = {}
    for transition in Body(page).transitions:
        for arc in transition.incoming:
            place = resolve(arc.source)
            if not isinstance(place, pn.Place):
                continue
            for port in ports_at(place):
                if not isinstance(port, sym.ActionClientPort) or place.tokens:
                    return None
                names = {name for name in (*_ENDS, _ACCEPTED) if _is(port, name, place)}
                if not names:
                    return None
                found.setdefault(port, set()).update(names)
    return found


def _is(client: sym.ActionClientPort, name: str, place: pn.Place) -> bool:
    named = getattr(client, name)
    return named is not None and resolve(named) is place
