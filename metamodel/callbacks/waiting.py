"""Decides which clients wait: whether a request is answered before its client may send the next one.

A client *waits* if a single token carries its requests: there is a set of places that contains the request
place, has at most one initial token, and to which no firing adds tokens. Such a set is a state machine of the
net, whose token moves from the request over the response to the next request (Murata, Proc. IEEE 77(4), 1989,
Sect. V). The path of the token may include a callback, which begins and ends once for each token, the lock of
an exclusive callback group, or places of the node for that purpose.

If no such set is found, the next request need not wait for the response. A node that runs callbacks then
sends any number of requests, as `rclpy` and `rclcpp` do. A node with execution `net` runs our engine: its
client sends the next request once the last one is answered. The same applies to action clients and their
goals.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.callbacks.bodies import Body, calls_of
from dineros.metamodel.callbacks.groups import (
    begins_answer,
    begins_callback,
    callback_page_of,
    group_or_node,
    holds_thread,
    runs_callbacks,
    threads_of,
    works_on_goals,
)
from dineros.metamodel.calls import UNLIMITED, answers, exits
from dineros.metamodel.elements import (
    arcs,
    channels,
    node_net_of,
    pages,
    places,
    resolve,
    system_model_of,
    transitions,
)

_MOST_SLOTS = 3
"""Maximum number of slots of an action that has one slot for each thread of its server."""
_MOST_SETS = 2000
"""Maximum number of sets of places tried for a client; then it counts as not waiting."""

Key: TypeAlias = tuple[str, EObject]
"""A place, the requests under way of a client, or a resource that lets one callback run at a time."""


@dataclass
class _StepChange:
    """The tokens that a step takes and gives, by place."""

    takes: Counter[Key] = field(default_factory=Counter)
    gives: Counter[Key] = field(default_factory=Counter)


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
        nets without times one is enough: the threads run out, however many requests there are.
    """
    services = channels(model, sym.ServiceChannel)
    counts = {client: client.outstanding or 1 for service in services for client in service.clients}
    if model.middleware != sym.Middleware.ros2:
        return counts
    silent = [each for each in counts if each.outstanding is None and _sends_freely(each)]
    waiting = Waiting(model) if silent else None
    runs = {client: _runs_asking(client) for client in silent} if runs_overlap else {}
    overlapping = Waiting(model, runs_overlap=True) if any(number != 1 for number in runs.values()) else None
    for client in silent:
        if waiting is not None and not waiting.waits(client):
            counts[client] = UNLIMITED
        elif overlapping is not None and not overlapping.waits(client):
            counts[client] = runs[client]
    return counts


def _runs_asking(client: sym.ClientPort, calling: frozenset[sym.CallbackPage] = frozenset()) -> int:
    """Return how many runs of callbacks can wait at once for responses to a client, or `UNLIMITED`.

    The page of a server or goal has copies, each with a client of its own. If it does not contain the place
    of the requests, its copies share the client, and all count.

    Parameters
    ----------
    calling : frozenset of sym.CallbackPage
        Pages of servers on the way here: one that calls itself through others has no limit.
    """
    runs = [_runs_at_once(page, calling) for page in _asking(client)]
    return 1 if all(number == 1 for number in runs) else _sum(runs)


def _asking(client: sym.ClientPort) -> set[sym.CallbackPage]:
    """Return the callbacks that put requests of a client, without a page that is copied with the client."""
    place, model = resolve(client.request), system_model_of(client)
    into = () if model is None else (each for each in arcs(model) if resolve(each.target) is place)
    asking = {page for each in into if (page := callback_page_of(each.source)) is not None}
    return {page for page in asking if page is not callback_page_of(place) or page.kind not in _COPIED}


_COPIED = {sym.CallbackKind.server, sym.CallbackKind.goal}
"""Callbacks of which each instance of a service or slot of an action has a copy."""


def _runs_at_once(page: sym.CallbackPage, calling: frozenset[sym.CallbackPage]) -> int:
    """Return how many runs of a callback there can be at once, those of all its copies, or `UNLIMITED`."""
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
        return _sum(_instances(each, calling | {page}) for each in services)
    return threads_of(node) if node is not None and overlap else 1


def _instances(service: sym.ServiceChannel, calling: frozenset[sym.CallbackPage]) -> int:
    """Return how many instances a server has: by default one for each client, and each of its copies."""
    if service.instances is not None:
        return int(service.instances)
    around = [callback_page_of(client.request) for client in service.clients]
    return _sum(
        1 if page is None or page.kind not in _COPIED else _runs_at_once(page, calling) for page in around
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


class Waiting:
    """Decides which clients of a system model wait.

    Parameters
    ----------
    model : sym.SystemModel
        The model; its references must have targets.
    runs_overlap : bool
        Whether runs of a callback may overlap on the threads of its node, if its group allows it. This is
        used for goals. For requests, each callback counts with one: each further run holds a thread and waits
        for it, so only the number of requests in a history differs. Runs of a callback that awaits overlap in
        any case, as they hold no thread: their requests are unbounded.
    """

    def __init__(self, model: sym.SystemModel, runs_overlap: bool = False) -> None:
        self._model, self._runs_overlap = model, runs_overlap
        self._tokens: dict[Key, int] = {_at(place): place.tokens for place in places(model)}
        self._moves = {transition: _StepChange() for transition in transitions(model)}
        self._others: list[_StepChange] = []
        self._arcs()
        self._callbacks()
        self._services()
        self._actions()
        self._subscribers()
        self._givers: dict[Key, list[_StepChange]] = defaultdict(list)
        for move in (*self._moves.values(), *self._others):
            for key in move.gives:
                self._givers[key].append(move)

    def waits(self, client: sym.ClientPort | sym.ActionClientPort) -> bool:
        """Return whether the net itself limits a client to one request or goal under way."""
        stack, seen = [frozenset({_under_way(client)})], set[frozenset[Key]]()
        shared = self._copies_sharing(client)
        while stack and len(seen) < _MOST_SETS:
            carried = stack.pop()
            if carried in seen or sum(self._tokens.get(key, 0) for key in carried) > 1 or carried & shared:
                continue
            seen.add(carried)
            adding = self._adding(carried)
            if adding is None:
                return True
            stack.extend(carried | {key} for key in adding.takes if key not in carried)
        return False

    def _copies_sharing(self, client: sym.ClientPort | sym.ActionClientPort) -> set[Key]:
        """Return the turns of pages of which several copies share a client; each copy has a token there."""
        if not self._runs_overlap or not isinstance(client, sym.ClientPort):
            return set()
        return {("turn", page) for page in _asking(client) if _runs_at_once(page, frozenset()) != 1}

    def _adding(self, carried: frozenset[Key]) -> _StepChange | None:
        """Return a move that adds tokens to a set of places; None: there is none."""
        for key in carried:
            for move in self._givers[key]:
                if _inside(move.gives, carried) > _inside(move.takes, carried):
                    return move
        return None

    # ------------------------------------------------------------------------- moves of tokens

    def _arcs(self) -> None:
        for arc in arcs(self._model):
            source, target = resolve(arc.source), resolve(arc.target)
            if isinstance(source, pn.Transition):
                self._moves[source].gives[_at(target)] += arc.weight
            elif isinstance(target, pn.Transition) and arc.kind == pn.ArcKind.normal:
                self._moves[target].takes[_at(source)] += arc.weight

    def _callbacks(self) -> None:
        """Add the beginning and end of callbacks, one run at a time in an exclusive group."""
        calls = calls_of(self._model)
        for page in pages(self._model):
            if not isinstance(page, sym.CallbackPage) or not runs_callbacks(node_net_of(page)):
                continue
            if self._is_copied(page):
                continue  # they begin with a request or goal, and end with the answer
            turns, body = self._turns(page), Body(page, calls)
            for begin in body.beginnings() if page.kind == sym.CallbackKind.timer else ():
                self._moves[begin].takes.update(turns)
            for end in body.ends():
                self._moves[end].gives.update(turns)

    def _turns(self, page: sym.CallbackPage) -> list[Key]:
        """Return the resources of a running callback that prevent another run; empty: none does.

        This is the lock of its exclusive group. Without one, runs do not overlap only if the node has one
        thread, which a callback that awaits releases. A copy for an instance or a slot has its own resource.
        """
        node, group = node_net_of(page), None if works_on_goals(page) else group_or_node(page)
        is_reentrant = isinstance(group, sym.CallbackGroup) and str(group.kind) == "reentrant"
        if group is not None and not is_reentrant:
            turn: Key = ("turn", group)
        elif not self._is_copied(page) and (
            page.awaits or (self._runs_overlap and (node is None or threads_of(node) > 1))
        ):
            return []
        else:
            turn = ("turn", page)
        self._tokens[turn] = 1
        return [turn]

    @staticmethod
    def _is_copied(page: sym.CallbackPage) -> bool:
        return page.kind == sym.CallbackKind.server or works_on_goals(page)

    def _begun(self, place: pn.Place | None) -> list[Key]:
        """Return the resources taken if a callback begins with a message on a place."""
        page = callback_page_of(place)
        return self._turns(page) if page is not None and runs_callbacks(node_net_of(page)) else []

    def _serve(self, page: pn.Page | None, entry: pn.Place, ends: list[pn.Place]) -> None:
        """Add an instance or slot that takes requests or goals, one at a time, and answers them."""
        if page is None:
            return
        turns: list[Key] = [("turn", page)]
        if isinstance(page, sym.CallbackPage) and runs_callbacks(node_net_of(page)):
            turns = self._turns(page)
        self._tokens.update(dict.fromkeys(turns, 1))
        self._move(turns, [_at(entry)])
        for end in ends:
            self._move([_at(end)], turns)

    def _services(self) -> None:
        for service in channels(self._model, sym.ServiceChannel):
            if service.server is not None:
                self._serve(service.server.page, service.server.entry, [service.server.exit])
            for client in service.clients:
                under_way = _under_way(client)
                begun = self._begun(client.response) if begins_callback(client) else []
                self._move([_at(client.request)], [under_way])
                self._move([under_way, *begun], [_at(client.response)])
                if client.timedOut is not None:
                    self._move([under_way], [_at(client.timedOut)])

    def _actions(self) -> None:
        for action in channels(self._model, sym.ActionChannel):
            if action.server is not None:
                self._serve(action.server.page, action.server.entry, list(exits(action.server)))
            for client in action.clients:
                under_way = _under_way(client)
                self._move([_at(client.goal)], [under_way])
                for place in answers(client):
                    begun = self._begun(place) if begins_answer(client, place) else []
                    self._move([under_way, *begun], [_at(place)])
                for heard in (client.accepted, client.feedback):
                    if heard is not None:
                        begun = self._begun(heard) if begins_answer(client, heard) else []
                        self._move(begun, [_at(heard)])

    def _subscribers(self) -> None:
        for topic in channels(self._model, sym.TopicChannel):
            for port in topic.subscribers:
                self._move(self._begun(port.place), [_at(port.place)])

    def _move(self, takes: list[Key], gives: list[Key]) -> None:
        self._others.append(_StepChange(Counter(takes), Counter(gives)))


def _at(node: pn.Node) -> Key:
    return ("place", resolve(node))


def _under_way(client: sym.ClientPort | sym.ActionClientPort) -> Key:
    return ("under way", client)


def _inside(tokens: Counter[Key], carried: frozenset[Key]) -> int:
    return sum(count for key, count in tokens.items() if key in carried)
