"""Who waits for whom: callbacks, their groups, the threads of executors, and clients of services.

A callback that has begun waits for the responses to its calls. A response waits for the callback that serves
the request, and then for a thread and a group to be taken by; so does a callback that could begin. A thread
and a group wait for the callbacks that have them. Where that leads in a circle, none of those in it ever
moves (E. G. Coffman, M. Elphick, A. Shoshani, *System deadlocks*, ACM Computing Surveys 3(2), 1971).

What the places and transitions of the net are, the links of the rules tell, never their names.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

from dineros.analysis.model.subject import Subject
from dineros.analysis.model.wording import client_words, source_of
from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import callback_page_of, threads_of, works_on_goals
from dineros.metamodel.elements import node_net_of
from dineros.metamodel.records import Reply, Request, Response, Serve
from dineros.transformations.flattening.traces import Link

Marking = Sequence[int]
Kind = Literal["callback", "response", "group", "thread"]


@dataclass(frozen=True)
class Waiter:
    """One that waits, or that is waited for.

    Attributes
    ----------
    kind : {"callback", "response", "group", "thread"}
        What it is.
    text : str
        The same in the words of the model.
    element : str
        Id of the callback page, service, callback group or node net.
    model : EObject
        The callback page, client or callback group; of a thread and a default group the node net.
    """

    kind: Kind
    text: str
    element: str
    model: EObject = field(compare=False, repr=False)


@dataclass(frozen=True)
class Circle:
    """Some that wait for each other: each for the next, the last for the first, which is a callback.

    Attributes
    ----------
    waiters : tuple of Waiter
        They.
    sharers : tuple of tuple of Waiter
        For each of them that is a thread, the callbacks that have the executor's other threads.
    """

    waiters: tuple[Waiter, ...]
    sharers: tuple[tuple[Waiter, ...], ...]

    def __str__(self) -> str:
        first = self.waiters[0]
        parts = [first.text]
        following = (*self.waiters[1:], first)
        for before, after, sharers in zip(self.waiters, following, self.sharers, strict=True):
            which = "" if before is first else ", which"
            if before.kind in ("group", "thread"):
                names = [after.text, *(sharer.text for sharer in sharers)]
                parts.append(f"{which} {' and '.join(names)} {'has' if len(names) == 1 else 'have'}")
            else:
                parts.append(f"{which} waits for {after.text}")
        return "".join(parts)

    @property
    def elements(self) -> tuple[str, ...]:
        """Ids of the elements of the model concerned, each once."""
        return tuple(dict.fromkeys(waiter.element for waiter in self.waiters))


@dataclass
class Callback:
    """A callback page of a node, or a server instance's copy of it.

    Attributes
    ----------
    waiter : Waiter
        It, as one that waits.
    page : sym.CallbackPage
        Its page.
    index : int or None
        Number of the server instance.
    running, awaiting : int
        Places of how often it runs, and how often it awaits a response.
    """

    waiter: Waiter
    page: sym.CallbackPage
    index: int | None
    running: int
    awaiting: int | None = None

    @property
    def places(self) -> tuple[int, ...]:
        """Places of which one is marked from its beginning to its end."""
        return (self.running,) if self.awaiting is None else (self.running, self.awaiting)

    def has_begun(self, marking: Marking) -> bool:
        """Tell whether it has begun and not ended."""
        return _any(self.places, marking)


@dataclass
class _Call:
    """A client, or a server instance's copy of it; transitions of its call, by server instance."""

    waiter: Waiter
    client: sym.ClientPort
    index: int | None
    takes: list[int]
    calls: dict[int, int]
    works: dict[int, int]
    under_way: list[int]


class Waiting:
    """What waits for what in markings of a net.

    Parameters
    ----------
    subject : Subject
        What is analysed.

    Attributes
    ----------
    callbacks : dict of (page, instance) to Callback
        All callbacks of nodes that run callbacks.
    """

    def __init__(self, subject: Subject) -> None:
        self._subject = subject
        self._net = subject.net
        self.callbacks: dict[tuple[EObject, int | None], Callback] = {}
        self._resources: dict[int, Waiter] = {}
        for link in subject.links():
            part = "" if link.meaning is None else link.meaning.part
            if part in ("threads", "lock"):
                self._resources[subject.place_index[link.target.id]] = _resource(link, part)
            elif part == "running":
                page = source_of(link, sym.CallbackPage)
                waiter = Waiter("callback", _callback_words(page, link.index), page.id, page)
                place = subject.place_index[link.target.id]
                self.callbacks[page, link.index] = Callback(waiter, page, link.index, place)
        for link in subject.links():
            if link.meaning is not None and link.meaning.part == "awaiting":
                page = source_of(link, sym.CallbackPage)
                self.callbacks[page, link.index].awaiting = subject.place_index[link.target.id]

    def circle(self, marking: Marking) -> Circle | None:
        """Return some that wait for each other in a marking, a shortest circle; None where there is none."""
        waits = list(self._waits(marking))
        if not waits:
            return None
        import networkx as nx  # takes a while to import

        graph: nx.DiGraph[Waiter] = nx.DiGraph(waits)
        begun = {each.waiter for each in self.callbacks.values() if each.has_begun(marking)}
        circles: list[tuple[Waiter, ...]] = []
        for part in nx.strongly_connected_components(graph):
            here = graph.subgraph(part)
            for waiter in part & begun:
                ways = [nx.shortest_path(here, after, waiter) for after in here.successors(waiter)]
                circles += [(waiter, *way[:-1]) for way in ways]
        if not circles:
            return None
        waiters = min(circles, key=lambda circle: (len(circle), [waiter.text for waiter in circle]))
        following = (*waiters[1:], waiters[0])
        sharers = (
            tuple(sorted((w for w in graph.successors(each) if w != after), key=lambda w: w.text))
            if each.kind == "thread"
            else ()
            for each, after in zip(waiters, following, strict=True)
        )
        return Circle(waiters, tuple(sharers))

    def _waits(self, marking: Marking) -> Iterator[tuple[Waiter, Waiter]]:
        """Yield who waits for whom."""
        for callback in self.callbacks.values():
            if callback.has_begun(marking):
                yield from self._waits_of(callback, marking)
            else:
                for begin in self._begins(callback):
                    for resource in self._missing_only(begin, marking):
                        yield callback.waiter, self._resources[resource]
        for call in self._calls.values():
            yield from self._waits_of_call(call, marking)
        for resource, waiter in self._resources.items():
            if marking[resource] == 0:
                yield from ((waiter, holder.waiter) for holder in self._holders(resource, marking))

    def _waits_of(self, callback: Callback, marking: Marking) -> Iterator[tuple[Waiter, Waiter]]:
        requests = self._awaited[callback.page]
        for (client, index), call in self._calls.items():
            if (
                client.timeout is None
                and client.request in requests
                and index == callback.index
                and _any(call.under_way, marking)
            ):
                yield callback.waiter, call.waiter
        begins = self._begins(callback)
        for transition in self._inside[callback.page, callback.index]:
            if transition in begins:
                continue
            for place in self._missing(transition, marking) - self._resources.keys():
                others = {self._of[maker] for maker in self._raising[place] if maker in self._of}
                others.discard((callback.page, callback.index))
                waiters = {self.callbacks[key].waiter for key in others if key in self.callbacks}
                for waiter in sorted(waiters, key=lambda waiter: waiter.text):
                    yield callback.waiter, waiter

    def _waits_of_call(self, call: _Call, marking: Marking) -> Iterator[tuple[Waiter, Waiter]]:
        for take in call.takes:
            for resource in self._missing_only(take, marking):
                yield call.waiter, self._resources[resource]
        if not _any(call.under_way, marking):
            return
        page = call.client.channel.server.page if call.client.channel else None
        for instance, place in call.works.items():
            server = self.callbacks.get((page, instance)) if page is not None else None
            if server is not None and marking[place] > 0:
                yield call.waiter, server.waiter
        for instance, transition in call.calls.items():
            server = self.callbacks.get((page, instance)) if page is not None else None
            missing = self._missing(transition, marking)
            if not missing or not missing <= self._resources.keys() | self._inactive:
                continue
            yield from ((call.waiter, self._resources[p]) for p in missing if p in self._resources)
            if server is not None and server.has_begun(marking):
                yield call.waiter, server.waiter

    def _begins(self, callback: Callback) -> list[int]:
        """Return the transitions by which a callback begins, and ends at once where it is a single one."""
        once = [
            transition
            for transition in self._inside[callback.page, callback.index]
            if any(place in self._resources for place, _ in self._net.pre.row(transition))
        ]
        return [*self._raising[callback.running], *once]

    def _missing_only(self, transition: int, marking: Marking) -> set[int]:
        """Return the threads and groups that a transition lacks; none where it lacks something else."""
        missing = self._missing(transition, marking)
        return missing if missing <= self._resources.keys() else set()

    def _missing(self, transition: int, marking: Marking) -> set[int]:
        return {place for place, weight in self._net.pre.row(transition) if marking[place] < weight}

    def _holders(self, resource: int, marking: Marking) -> list[Callback]:
        """Return the callbacks that have a thread, or a group."""
        is_thread = self._resources[resource].kind == "thread"
        return [
            callback
            for callback in self.callbacks.values()
            if any(self._net.delta[t].get(resource, 0) < 0 for t in self._raising[callback.running])
            and (marking[callback.running] > 0 if is_thread else callback.has_begun(marking))
        ]

    @cached_property
    def _raising(self) -> list[list[int]]:
        """By place, the transitions that put more there than they take."""
        raising: list[list[int]] = [[] for _ in self._net.places]
        for transition, change in enumerate(self._net.delta):
            for place, tokens in change.items():
                if tokens > 0:
                    raising[place].append(transition)
        return raising

    @cached_property
    def _of(self) -> dict[int, tuple[EObject, int | None]]:
        """The callback that a transition of the model belongs to."""
        found: dict[int, tuple[EObject, int | None]] = {}
        for link in self._subject.links():
            if isinstance(link.target, pn.Transition) and link.meaning is None and link.sources:
                page = callback_page_of(link.sources[0])
                if page is not None:
                    found[self._subject.transition_index[link.target.id]] = page, link.index
        return found

    @cached_property
    def _inside(self) -> dict[tuple[EObject, int | None], list[int]]:
        """The transitions of the model that belong to a callback."""
        inside: dict[tuple[EObject, int | None], list[int]] = defaultdict(list)
        for transition, key in self._of.items():
            inside[key].append(transition)
        return inside

    @cached_property
    def _awaited(self) -> dict[sym.CallbackPage, set[pn.Place]]:
        """Places of the requests whose responses a callback waits for."""
        return {callback.page: Body(callback.page).requests for callback in self.callbacks.values()}

    @cached_property
    def _inactive(self) -> set[int]:
        """Places that are marked while nobody uses a server instance."""
        links = [link for link in self._subject.links() if link.meaning and link.meaning.part == "inactive"]
        return {self._subject.place_index[link.target.id] for link in links}

    @cached_property
    def _calls(self) -> dict[tuple[sym.ClientPort, int | None], _Call]:
        steps: dict[tuple[sym.ClientPort, int | None], list[Link]] = defaultdict(list)
        for link in self._subject.links():
            client = next((source for source in link.sources if isinstance(source, sym.ClientPort)), None)
            if client is not None and link.meaning is not None:
                steps[client, link.client_index].append(link)
        return {key: self._call(*key, links) for key, links in steps.items()}

    def _call(self, client: sym.ClientPort, index: int | None, links: list[Link]) -> _Call:
        places = {
            self._subject.place_index[link.target.id]: link
            for link in links
            if isinstance(link.target, pn.Place)
        }
        moves: dict[type, dict[int, int]] = defaultdict(dict)
        for link in links:
            if link.meaning is not None and link.meaning.step in (Request, Serve, Reply, Response):
                number = self._subject.transition_index[link.target.id]
                moves[link.meaning.step][link.index or 0] = number
        works = {
            instance: next(place for place, _ in self._net.pre.row(transition) if place in places)
            for instance, transition in moves[Reply].items()
        }
        service = source_of(links[0], sym.ServiceChannel)
        text = f"the response of service {service.service} to {client_words(links[0])}"
        return _Call(
            Waiter("response", text, service.id, client),
            client,
            index,
            list(moves[Response].values()),
            moves[Serve],
            works,
            [p for p, link in places.items() if link.meaning is not None and not link.meaning.rests],
        )


def _any(places: Sequence[int], marking: Marking) -> bool:
    return any(marking[place] > 0 for place in places)


def _resource(link: Link, part: str) -> Waiter:
    owner = link.sources[0]
    node = node_net_of(owner)
    assert node is not None
    of = f"of node net {node.name or node.id}"
    if part == "threads":
        threads = threads_of(node)
        one = "the thread" if threads == 1 else f"one of the {threads} threads"
        return Waiter("thread", f"{one} {of}", node.id, node)
    if isinstance(owner, sym.CallbackGroup):
        return Waiter("group", f"callback group {owner.name or owner.id} {of}", owner.id, owner)
    return Waiter("group", f"the default callback group {of}", node.id, node)


def _callback_words(page: sym.CallbackPage, index: int | None) -> str:
    if index is None:
        return f"callback {page.name or page.id}"
    return (
        f"callback {page.name or page.id} of {'slot' if works_on_goals(page) else 'server instance'} {index}"
    )
