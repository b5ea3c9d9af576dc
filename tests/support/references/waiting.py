"""Which clients wait, found a second way: an integer program over what can happen to a model's states.

A client waits where some slots of the state hold one token together at the start at most, nothing that can
happen adds to them, and what the client has under way is among them. Besides the slots there is, for each
callback, server instance and slot of an action, whether it is at rest; of an exclusive group, whether all
are.
It shares no code with `dineros.metamodel.callbacks`.
"""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp

from dineros.metamodel import sym
from dineros.metamodel.elements import node_net_of

if TYPE_CHECKING:
    from tests.support.references.executors import ExecutorInterpreter

UNLIMITED = -1


def outstanding_of(model: sym.SystemModel) -> dict[sym.ClientPort, int]:
    """Return how many requests each client has under way at most; -1: any number."""
    from tests.support.references.executors import ExecutorInterpreter

    clients = [
        client
        for service in model.channels
        if isinstance(service, sym.ServiceChannel)
        for client in service.clients
    ]
    silent = [client for client in clients if client.outstanding is None]
    by_hand = []
    for client in silent:
        node = node_net_of(client.request)
        if node is not None and str(node.execution) == "callbacks":
            by_hand.append(client)
    found = {client: client.outstanding or 1 for client in clients}
    if by_hand:
        for client in silent:
            client.outstanding = UNLIMITED if client in by_hand else 1
        try:
            play = ExecutorInterpreter(model)
            found.update({client: 1 if _waits(play, client) else UNLIMITED for client in by_hand})
        finally:
            for client in silent:
                client.outstanding = None
    return found


def _waits(play: ExecutorInterpreter, client: sym.ClientPort) -> bool:
    copies = play._copies(client.request)
    if not copies:
        return True
    slots = len(play.start_values)
    at_rest: dict[object, list[int]] = defaultdict(list)
    for callback in play._callbacks.values():
        is_free = callback.group is None and callback.awaiting is not None
        if is_free and str(callback.page.kind) in ("timer", "subscriber"):
            continue  # it gives its thread back: the next run may begin
        turn = callback.group or (callback.page, callback.copy)
        at_rest[turn] += [each for each in (callback.running, callback.awaiting) if each is not None]
    for key, slot in play._slots.items():
        of_service = isinstance(key, tuple) and len(key) == 2 and isinstance(key[0], sym.ServiceChannel)
        if of_service or (isinstance(key, tuple) and key[-1] == "phase"):
            at_rest[key].append(slot)
    rows = []
    for event in play.events:
        row = np.zeros(slots + len(at_rest))
        for slot, tokens in event.effect.items():
            row[slot] = tokens
        for number, busy in enumerate(at_rest.values()):
            row[slots + number] = -sum(np.sign(row[slot]) for slot in busy)
        rows.append(row)
    start = np.array([*play.start_values, *(1 for _ in at_rest)])
    least = np.zeros(len(start))
    for slot in play.under_way[client, copies[0]]:
        least[slot] = 1
    constraints = [
        LinearConstraint(np.array(rows), ub=np.zeros(len(rows))),
        LinearConstraint(start[None, :], ub=[1]),
    ]
    answer = milp(
        np.zeros(len(start)),
        integrality=np.ones(len(start)),
        bounds=Bounds(least, np.ones(len(start))),
        constraints=constraints,
    )
    return bool(answer.success)
