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
from collections.abc import Iterable
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
    runs_callbacks,
    threads_of,
    works_on_goals,
)
from dineros.metamodel.calls import answers, exits
from dineros.metamodel.elements import (
    arcs,
    channels,
    node_net_of,
    pages,
    places,
    resolve,
    transitions,
)

_MOST_SETS = 2000
"""Maximum number of sets of places tried for a client; then it counts as not waiting."""

Key: TypeAlias = tuple[str, EObject]
"""A place, the requests under way of a client, or a resource that lets one callback run at a time."""


@dataclass
class _StepChange:
    """The tokens that a step takes and gives, by place."""

    takes: Counter[Key] = field(default_factory=Counter)
    gives: Counter[Key] = field(default_factory=Counter)


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

    def waits(
        self, client: sym.ClientPort | sym.ActionClientPort, copied: Iterable[sym.CallbackPage] = ()
    ) -> bool:
        """Return whether the net itself limits a client to one request or goal under way.

        `copied`: callbacks of which several copies share the client. Each copy has a token of its own, so the
        callback does not limit the client.
        """
        stack, seen = [frozenset({_under_way(client)})], set[frozenset[Key]]()
        shared = {("turn", page) for page in copied}
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
