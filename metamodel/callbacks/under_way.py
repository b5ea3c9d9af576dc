"""How many requests and goals of each client are under way at once, and how many slots actions need."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from dineros.metamodel import sym
from dineros.metamodel.callbacks.groups import (
    callback_page_of,
    group_or_node,
    holds_thread,
    runs_callbacks,
    threads_of,
)
from dineros.metamodel.callbacks.waiting import Waiting
from dineros.metamodel.calls import UNLIMITED
from dineros.metamodel.elements import arcs, channels, node_net_of, resolve, system_model_of

_MOST_SLOTS = 3
"""Maximum number of slots of an action that has one slot for each thread of its server."""


def outstanding(client: sym.ClientPort) -> int:
    """Return the maximum number of requests of a client under way, or `UNLIMITED`.

    This is the value in the model; else 1 if the client waits, if its node's execution is `net`, or if the
    middleware is `ros1`, whose calls block.
    """
    model = client.channel.model if client.channel is not None else None
    if client.outstanding is not None or model is None:
        return client.outstanding or 1
    return outstanding_counts(model)[client]


def outstanding_counts(model: sym.SystemModel, runs_overlap: bool = False) -> dict[sym.ClientPort, int]:
    """Return the maximum number of requests under way of each client of a model, as for `outstanding`.

    Parameters
    ----------
    model : sym.SystemModel
        The model.
    runs_overlap : bool
        Whether each run of a callback counts that may overlap with others and waits for its own response. In
        nets without times one is enough: the threads run out, however many requests there are. Copies of
        servers and goals always count.
    """
    services = channels(model, sym.ServiceChannel)
    counts = {client: client.outstanding or 1 for service in services for client in service.clients}
    if model.middleware != sym.Middleware.ros2:
        return counts
    silent = [each for each in counts if each.outstanding is None and _sends_freely(each)]
    waiting = Waiting(model) if silent else None
    runs = {client: _runs_asking(client, runs_overlap) for client in silent}
    is_shared = any(number != 1 for number in runs.values())
    overlapping = Waiting(model, runs_overlap) if is_shared else None
    for client in silent:
        if waiting is not None and not waiting.waits(client):
            counts[client] = UNLIMITED
        elif overlapping is not None:
            copied = [page for page in _asking(client) if _runs_at_once(page, runs_overlap) != 1]
            counts[client] = 1 if overlapping.waits(client, copied) else runs[client]
    return counts


def _runs_asking(client: sym.ClientPort, runs_overlap: bool) -> int:
    """Return how many runs of callbacks can wait at once for responses to a client, or `UNLIMITED`.

    The page of a server or goal has copies, each with a client of its own. If it does not contain the place
    of the requests, its copies share the client, and all count.
    """
    runs = [_runs_at_once(page, runs_overlap) for page in _asking(client)]
    return 1 if all(number == 1 for number in runs) else _sum(runs)


def _asking(client: sym.ClientPort) -> set[sym.CallbackPage]:
    """Return the callbacks that put requests of a client, without a page that is copied with the client."""
    place, model = resolve(client.request), system_model_of(client)
    into = () if model is None else (each for each in arcs(model) if resolve(each.target) is place)
    asking = {page for each in into if (page := callback_page_of(each.source)) is not None}
    return {page for page in asking if page is not callback_page_of(place) or page.kind not in _COPIED}


_COPIED = {sym.CallbackKind.server, sym.CallbackKind.goal}
"""Callbacks of which each instance of a service or slot of an action has a copy."""


def _runs_at_once(
    page: sym.CallbackPage, runs_overlap: bool, calling: frozenset[sym.CallbackPage] = frozenset()
) -> int:
    """Return how many runs of a callback there can be at once, those of all its copies, or `UNLIMITED`.

    Parameters
    ----------
    runs_overlap : bool
        Whether runs of a callback that has no copies count, too.
    calling : frozenset of sym.CallbackPage
        Pages of servers on the way here: one that calls itself through others has no limit.
    """
    model, group, node = system_model_of(page), group_or_node(page), node_net_of(page)
    if model is not None and page.kind == sym.CallbackKind.goal:
        goals = goals_at_once(model)
        numbers = [number for action, number in goals.items() if action.server.page is page]
        return _sum(UNLIMITED if number is None else number for number in numbers)
    is_reentrant = isinstance(group, sym.CallbackGroup) and group.kind == sym.CallbackGroupKind.reentrant
    overlap = node is not None and (group is None or is_reentrant)
    if model is not None and page.kind == sym.CallbackKind.server:
        if not overlap and not page.awaits and runs_callbacks(node):
            return 1
        if page in calling:
            return UNLIMITED
        services = [each for each in channels(model, sym.ServiceChannel) if each.server.page is page]
        return _sum(_instances(each, runs_overlap, calling | {page}) for each in services)
    return threads_of(node) if runs_overlap and node is not None and overlap else 1


def _instances(service: sym.ServiceChannel, runs_overlap: bool, calling: frozenset[sym.CallbackPage]) -> int:
    """Return how many instances a server has: by default one for each client, and each of its copies."""
    if service.instances is not None:
        return int(service.instances)
    around = [callback_page_of(client.request) for client in service.clients]
    return _sum(
        1 if page is None or page.kind not in _COPIED else _runs_at_once(page, runs_overlap, calling)
        for page in around
    )


def _sum(numbers: Iterable[int]) -> int:
    """Return the sum of some numbers, or `UNLIMITED` if one of them is."""
    known = list(numbers)
    return UNLIMITED if UNLIMITED in known else sum(known)


def _sends_freely(client: sym.ClientPort) -> bool:
    return runs_callbacks(node_net_of(client.request))


def goal_counts(model: sym.SystemModel) -> dict[sym.ActionClientPort, int]:
    """Return the maximum number of goals of each action client under way, or `UNLIMITED`.

    This is the value in the model; else 1 if the client waits for the end of a goal, if its node's execution
    is `net`, or under `ros1`. The client of our engine sends the next goal once the last one has ended.
    """
    clients = [client for action in channels(model, sym.ActionChannel) for client in action.clients]
    counts = {client: client.outstanding or 1 for client in clients}
    if model.middleware != sym.Middleware.ros2:
        return counts
    silent = [each for each in clients if each.outstanding is None and runs_callbacks(node_net_of(each.goal))]
    waiting = Waiting(model, runs_overlap=True) if silent else None
    for client in silent:
        if waiting is not None and not waiting.waits(client):
            counts[client] = UNLIMITED
    return counts


@dataclass(frozen=True)
class Slots:
    """The number of goals that an action executes at once in the analysis, if a client does not wait.

    Attributes
    ----------
    action : sym.ActionChannel
        The action, whose model does not give this number.
    number : int
        The number of slots.
    is_enough : bool
        Whether the threads of the server allow no more.
    """

    action: sym.ActionChannel
    number: int
    is_enough: bool


def free_slots(model: sym.SystemModel, counts: Mapping[sym.ActionClientPort, int]) -> list[Slots]:
    """Return the slots of actions without a given limit of simultaneous goals.

    A server of `rclpy` or `rclcpp` accepts each goal. The execution of a goal holds a thread unless it
    awaits.

    Parameters
    ----------
    model : sym.SystemModel
        The model.
    counts : mapping
        Number of goals under way of each client.
    """
    found = []
    for action in channels(model, sym.ActionChannel):
        server: sym.ActionServerPort | None = action.server
        clients, node = list(action.clients), None if server is None else node_net_of(server.entry)
        if action.instances is not None or server is None or node is None or not runs_callbacks(node):
            continue
        if all(counts[client] != UNLIMITED for client in clients):
            continue
        page, threads = callback_page_of(server.entry), threads_of(node)
        needs_thread = page is not None and holds_thread(page)
        least = max(len(clients), 1 if needs_thread else 2)
        number = max(least, min(threads, _MOST_SLOTS)) if needs_thread else least
        found.append(Slots(action, number, needs_thread and number >= threads))
    return found


def goals_at_once(model: sym.SystemModel) -> dict[sym.ActionChannel, int | None]:
    """Return how many goals each action works on at once at most; None: any number.

    Without a given limit, and with a client that does not wait, each thread of the server may work on a goal;
    the net has fewer slots then, see `free_slots`.
    """
    actions = channels(model, sym.ActionChannel)
    found: dict[sym.ActionChannel, int | None] = {
        action: len(action.clients) if action.instances is None else int(action.instances)
        for action in actions
    }
    for slots in free_slots(model, goal_counts(model)) if any(a.instances is None for a in actions) else ():
        entry = slots.action.server.entry
        page, node = callback_page_of(entry), node_net_of(entry)
        holds = page is not None and holds_thread(page) and node is not None
        found[slots.action] = max(slots.number, threads_of(node)) if holds and node is not None else None
    return found
