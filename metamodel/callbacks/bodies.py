"""The beginning and end of callbacks, and their callback groups.

A callback is the part of a callback page, including inner pages, from the message, request, response or tick
that begins it to the transition that ends it. Transitions of kind `start` and `end` mark it; so does a place
of kind `end`, which marks the transitions that put tokens on it. On a page without marks, a timer callback
begins with the transitions without a predecessor on the page, and a callback ends with those without a
successor on it; a call precedes the transition that takes its response.

>>> from dineros.metamodel import sym
>>> from dineros.metamodel.build import flow
>>> page = sym.CallbackPage(id="OnTimer", kind="timer")
>>> begin, between = sym.Transition(id="Begin", page=page), sym.Place(id="Between", page=page)
>>> _ = flow(begin, between, sym.Transition(id="Finish", page=page))
>>> body = Body(page)
>>> [each.id for each in body.beginnings()], [each.id for each in body.ends()]
(['Begin'], ['Finish'])
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.calls import answers
from dineros.metamodel.elements import channels, pages, resolve


def calls_of(net: EObject | None) -> list[tuple[pn.Place, pn.Place]]:
    """Return request and response (or time-out) place of each client of a net; also for goals."""
    while net is not None and not isinstance(net, pn.Net):
        net = net.eContainer()
    if isinstance(net, sym.SystemModel):
        clients = [port for service in channels(net, sym.ServiceChannel) for port in service.clients]
        told = [(port.request, port.timedOut) for port in clients if port.timedOut is not None]
        return [*((port.request, port.response) for port in clients), *told, *_goals(net)]
    if isinstance(net, rtm.RuntimeModel):
        places = [each for each in net.eAllContents() if isinstance(each, rtm.Place)]
        ports = [(place, port) for place in places for port in place.ports]
        calls = [(place, port.response) for place, port in ports if isinstance(port, rtm.ClientPort)]
        goals = [(place, port) for place, port in ports if isinstance(port, rtm.ActionClientPort)]
        return [*calls, *((place, answer) for place, port in goals for answer in answers(port))]
    return []


def timers_of(net: pn.Net) -> list[sym.CallbackPage]:
    """Return the callbacks of timers with a period, in model order."""
    found = [page for page in pages(net) if isinstance(page, sym.CallbackPage)]
    return [page for page in found if page.kind == sym.CallbackKind.timer and page.timer]


def _goals(net: sym.SystemModel) -> list[tuple[pn.Place, pn.Place]]:
    clients = [client for action in channels(net, sym.ActionChannel) for client in action.clients]
    learned = [(client.goal, client.accepted) for client in clients if client.accepted is not None]
    return [*((client.goal, answer) for client in clients for answer in answers(client)), *learned]


class Body:
    """The content of a callback page.

    Parameters
    ----------
    page : sym.CallbackPage
        The page, of a system model or a runtime model.
    calls : sequence of (pn.Place, pn.Place), optional
        Request and response place of each client of the model, if they are known already.
    """

    def __init__(self, page: sym.CallbackPage, calls: list[tuple[pn.Place, pn.Place]] | None = None) -> None:
        calls = calls_of(page) if calls is None else calls
        nodes = list(_nodes(page))
        self.transitions = [node for node in nodes if isinstance(node, pn.Transition)]
        self._inside = {node for node in nodes if isinstance(node, pn.Place)}
        self._changes = {transition: Counter[pn.Node]() for transition in self.transitions}
        for holder in _pages(page):
            for arc in holder.arcs:
                self._join(arc)
        self._raised = self._where(1)
        self._lowered = self._where(-1)
        self.requests = {
            request
            for request, response in calls
            if response in self._inside or (response in self._lowered and request in self._raised)
        }
        """Places of requests for whose responses the callback waits."""
        self._responses = {response for request, response in calls if request in self.requests}

    def _join(self, arc: pn.Arc) -> None:
        source, target = resolve(arc.source), resolve(arc.target)
        if isinstance(source, pn.Transition) and source in self._changes:
            self._changes[source][target] += arc.weight
        elif isinstance(target, pn.Transition) and target in self._changes and arc.kind == pn.ArcKind.normal:
            self._changes[target][source] -= arc.weight

    def _where(self, sign: int) -> set[pn.Node]:
        """Return the places whose tokens the page's transitions increase (or decrease)."""
        return {place for change in self._changes.values() for place, n in change.items() if n * sign > 0}

    def beginnings(self) -> list[pn.Transition]:
        """Return the transitions with which a timer callback begins."""
        marked = [each for each in self.transitions if _is(each, sym.TransitionKind.start)]
        later = (self._raised & self._inside) | self._responses
        return marked or [each for each in self.transitions if not self._changed(each, later, -1)]

    def ends(self) -> list[pn.Transition]:
        """Return the transitions with which the callback ends; servers and goals end with their response."""
        marked = [each for each in self.transitions if _is(each, sym.TransitionKind.end)]
        last = {p for p in self._inside if isinstance(p, sym.Place) and p.kind == sym.PlaceKind.end}
        if marked or last:
            return [each for each in self.transitions if each in marked or self._changed(each, last, 1)]
        onward = (self._lowered & self._inside) | self.requests
        return [each for each in self.transitions if not self._changed(each, onward, 1)]

    def continues(self, transition: pn.Transition) -> int:
        """Return the number of ways in which the callback continues after a transition; tokens count."""
        onward = (self._lowered & self._inside) | self.requests
        return sum(max(0, self._changes[transition][place]) for place in onward)

    @property
    def is_sequential(self) -> bool:
        """Whether a run continues in at most one way after each of its transitions."""
        return all(self.continues(each) <= 1 for each in self.transitions)

    def _changed(self, transition: pn.Transition, places: Collection[pn.Node], sign: int) -> bool:
        return any(self._changes[transition][place] * sign > 0 for place in places)


def _is(transition: pn.Transition, kind: sym.TransitionKind) -> bool:
    return isinstance(transition, sym.Transition) and transition.kind == kind


def _pages(page: pn.Page) -> Iterator[pn.Page]:
    """Yield a callback page and the pages inside it that are part of the callback."""
    yield page
    for inner in page.objects:
        if isinstance(inner, pn.Page) and not isinstance(inner, sym.CallbackPage):
            yield from _pages(inner)


def _nodes(page: pn.Page) -> Iterator[pn.Node]:
    for holder in _pages(page):
        for node in holder.objects:
            if isinstance(node, pn.Node):
                yield node
