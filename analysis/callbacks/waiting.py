"""What waits for what: callbacks, their groups, the threads of executors, calls, and places of the model.

A callback that has begun waits for the answers to its calls, and for tokens that other callbacks give. An
answer waits for the callback that serves the request, and then for a thread and a group to be taken by; so
does a callback that could begin. A thread and a group wait for the callbacks that hold them, and so does a
place that a semiflow shows to be a lock; other places wait for the callbacks that would put a token there.
If one of several is enough, all of them must wait. Those that wait in a circle never move (E. G. Coffman,
M. Elphick, A. Shoshani, *System deadlocks*, ACM Computing Surveys 3(2), 1971).

The links of the rules say what the places and transitions of the net are, never their names.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

from dineros.analysis.callbacks.calls import Call, calls_in
from dineros.analysis.callbacks.circles import Circle, Waiter
from dineros.analysis.callbacks.shortest_circles import Ways, shortest_circle, text_of
from dineros.analysis.model.subject import Subject
from dineros.analysis.model.wording import source_of, words
from dineros.analysis.nets.bounds import flows_and_bounds
from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import begins_answer, begins_callback, callback_page_of, threads_of
from dineros.metamodel.elements import node_net_of

if TYPE_CHECKING:
    from dineros.transformations.flattening.traces import Link

Marking: TypeAlias = Sequence[int]
Key: TypeAlias = tuple[EObject, int | None]
"""A callback page, and the number of its server instance or slot."""


@dataclass
class Callback:
    """A callback page of a node, or a server instance's copy of it."""

    waiter: Waiter
    """It, as one that waits."""
    page: sym.CallbackPage
    index: int | None
    """Number of the server instance or slot."""
    running: int
    awaiting: int | None = None
    """`running`, `awaiting`: places of how often it runs, and how often it awaits an answer."""

    @property
    def places(self) -> tuple[int, ...]:
        """Places of which one is marked from its beginning to its end."""
        return (self.running,) if self.awaiting is None else (self.running, self.awaiting)

    def has_begun(self, marking: Marking) -> bool:
        """Return whether it has begun and not ended."""
        return _any(self.places, marking)


class Waiting:
    """Which transitions wait for which places in markings of a net.

    Attributes
    ----------
    callbacks : dict of (page, instance) to Callback
        All callbacks of nodes that run callbacks.
    resources : dict of int to Waiter
        Places of free threads and of free callback groups.
    """

    def __init__(self, subject: Subject) -> None:
        self._subject = subject
        self._net = subject.net
        self.callbacks: dict[Key, Callback] = {}
        self.resources: dict[int, Waiter] = {}
        self._requests: dict[sym.CallbackPage, set[pn.Place]] = {}
        """Places of the requests whose answers a callback waits for, as far as they were asked."""
        for link in subject.links():
            part = "" if link.meaning is None else link.meaning.part
            if part in ("threads", "lock"):
                self.resources[subject.place_index[link.target.id]] = _resource(link, part)
            elif part == "running":
                page = source_of(link, sym.CallbackPage)
                place = subject.place_index[link.target.id]
                waiter = callback_waiter(page, link.index)
                self.callbacks[page, link.index] = Callback(waiter, page, link.index, place)
        for link in subject.links():
            if link.meaning is not None and link.meaning.part == "awaiting":
                page = source_of(link, sym.CallbackPage)
                self.callbacks[page, link.index].awaiting = subject.place_index[link.target.id]

    def circle(self, marking: Marking, of: Waiter | None = None) -> Circle | None:
        """Return some that wait for each other in a marking, a shortest circle; None if there is none.

        `of`: only circles that it waits for, those that it is in before others.
        """
        ways, held = self._ways(marking)
        begun = {each.waiter for each in self.callbacks.values() if each.has_begun(marking)}
        return shortest_circle(ways, held, begun, of)

    def _ways(self, marking: Marking) -> tuple[dict[Waiter, Ways], set[Waiter]]:
        """Return the ways on for each that waits; and the places that wait for those that hold a token."""
        ways: dict[Waiter, Ways] = {}
        missing: set[int] = set()
        for key, callback in self.callbacks.items():
            if callback.has_begun(marking):
                ways[callback.waiter] = self._ways_on(key, marking, missing)
            else:
                ways[callback.waiter] = self._ways_to_begin(callback, marking)
        for call in self._calls:
            if _any(call.under_way, marking):
                ways[call.waiter] = self._ways_of_call(call, marking, ways, missing)
        for resource, waiter in self.resources.items():
            if marking[resource] == 0:
                ways[waiter] = [frozenset({each.waiter}) for each in self._holders(resource, marking)]
        held: set[Waiter] = set()
        for place in missing:
            waiter = self._place_waiter(place)
            holders = self._lock_holders(place, marking)
            if holders:
                held.add(waiter)
            asking = {one for one, each in ways.items() if any(waiter in way for way in each)}
            makers = [each for each in self._makers(place) if each not in asking]
            ways[waiter] = [frozenset({each}) for each in holders or makers or self._makers(place)]
        return ways, held

    def _ways_on(self, key: Key, marking: Marking, missing: set[int]) -> Ways:
        """Return how a callback that has begun may continue; a timeout of a call is a way that is open."""
        page, index = key
        assert isinstance(page, sym.CallbackPage)
        awaited = [call for call in self._awaited(page, index) if _any(call.under_way, marking)]
        if any(call.may_give_up for call in awaited):
            return [frozenset()]
        if awaited:
            return [frozenset(call.waiter for call in awaited)]
        begins = set(self._begins(self.callbacks[key])) if key in self.callbacks else set()
        steps = [each for each in self.steps[key] if each not in begins]
        reached = [each for each in steps if self._is_reached(each, marking)] or steps
        ways: Ways = []
        for step in reached:
            lacking = self._missing(step, marking)
            resources = lacking & self.resources.keys()
            places = {place for place in lacking - resources if self._is_given(place, key)}
            if resources or places:
                missing |= places
                ways.append(
                    frozenset(self.resources[each] for each in resources)
                    | frozenset(self._place_waiter(each) for each in places)
                )
        return ways

    def lacking(self, page: str, marking: Marking) -> list[str]:
        """Return the places of the model whose tokens a callback that has begun lacks, by their ids."""
        found: dict[str, None] = {}
        for key, callback in self.callbacks.items():
            if callback.waiter.element != page or not callback.has_begun(marking):
                continue
            for call in self._awaited(callback.page, callback.index):
                if isinstance(call.client, sym.ClientPort) and _any(call.under_way, marking):
                    found[str(call.client.response.id)] = None
            begins = set(self._begins(callback))
            for step in self.steps[key]:
                if step not in begins and self._is_reached(step, marking):
                    lacks = self._missing(step, marking) - self.resources.keys()
                    found.update(dict.fromkeys(self._place_waiter(each).element for each in sorted(lacks)))
        return list(found)

    def _is_reached(self, transition: int, marking: Marking) -> bool:
        inputs = [place for place, _ in self._net.pre.row(transition) if place not in self.resources]
        return _any(inputs, marking)

    def _ways_to_begin(self, callback: Callback, marking: Marking) -> Ways:
        """Return the resources that a callback needs to start: a thread and its group."""
        lacking = [self._missing(each, marking) & self.resources.keys() for each in self._begins(callback)]
        return [frozenset(self.resources[each] for each in resources) for resources in lacking]

    def _ways_of_call(
        self, call: Call, marking: Marking, ways: dict[Waiter, Ways], missing: set[int]
    ) -> Ways:
        """Return how the answer to a call may come."""
        lacking = [self._missing(each, marking) for each in call.takes]
        taken = [each for each in lacking if each <= self.resources.keys()]
        if taken:
            return [frozenset(self.resources[each] for each in resources) for resources in taken]
        working = [instance for instance, place in call.works.items() if marking[place] > 0]
        if working:
            return [self._serving(call, instance, marking, ways, missing) for instance in working]
        found: Ways = []
        for instance, transition in call.serves.items():
            lacks = self._missing(transition, marking)
            resources = frozenset(self.resources[each] for each in lacks & self.resources.keys())
            if lacks & self._inactive:
                found.append(resources | self._serving(call, instance, marking, ways, missing))
            elif lacks <= self.resources.keys():
                found.append(resources)
        return found

    def _serving(
        self, call: Call, instance: int, marking: Marking, ways: dict[Waiter, Ways], missing: set[int]
    ) -> frozenset[Waiter]:
        """Return the callback that serves a call; one that awaits at each step of a goal is noted here."""
        page = call.server
        if not isinstance(page, sym.CallbackPage):
            return frozenset()
        key = page, instance
        if key in self.callbacks:
            callback = self.callbacks[key]
            return frozenset({callback.waiter}) if callback.has_begun(marking) else frozenset()
        waiter = callback_waiter(page, instance)
        ways[waiter] = self._ways_on(key, marking, missing)
        return frozenset({waiter})

    def _awaited(self, page: sym.CallbackPage, index: int | None) -> list[Call]:
        """Return the calls whose answers a callback waits for, without the answer that begins it."""
        requests = self._requests.get(page)
        if requests is None:
            begun = {call.request for call in self._calls if _begins_with(call, page)}
            requests = self._requests[page] = Body(page).requests - begun
        return [call for call in self._calls if call.request in requests and call.index == index]

    def _begins(self, callback: Callback) -> list[int]:
        """Return the transitions by which a callback begins, and ends at once where it is a single one."""
        once = [
            transition
            for transition in self.steps[callback.page, callback.index]
            if any(place in self.resources for place, _ in self._net.pre.row(transition))
        ]
        return list(dict.fromkeys([*self._raising[callback.running], *once]))

    def _missing(self, transition: int, marking: Marking) -> set[int]:
        return {place for place, weight in self._net.pre.row(transition) if marking[place] < weight}

    def _holders(self, resource: int, marking: Marking) -> list[Callback]:
        """Return the callbacks that hold a thread, or a group."""
        is_thread = self.resources[resource].kind == "thread"
        return [
            callback
            for callback in self.callbacks.values()
            if any(self._net.delta[t].get(resource, 0) < 0 for t in self._raising[callback.running])
            and (marking[callback.running] > 0 if is_thread else callback.has_begun(marking))
        ]

    def _lock_holders(self, place: int, marking: Marking) -> list[Waiter]:
        """Return the callbacks that hold the tokens of a place, if a semiflow shows them."""
        flows = self._net.once(flows_and_bounds)[0] or ()
        for flow in sorted((each for each in flows if place in each.weights), key=lambda f: len(f.weights)):
            marked = [other for other in flow.weights if other != place and marking[other] > 0]
            owners = [self._owner_of.get(other) for other in marked]
            found = [self.callbacks[key].waiter for key in owners if key in self.callbacks]
            if found and len(found) == len(owners):
                return list(dict.fromkeys(found))
        return []

    def _makers(self, place: int, but: Key | None = None) -> list[Waiter]:
        """Return the callbacks that would put a token to a place, in the order of their names."""
        keys = {self._of[maker] for maker in self._raising[place] if maker in self._of} - {but}
        waiters = {self.callbacks[key].waiter for key in keys if key in self.callbacks}
        return sorted(waiters, key=text_of)

    def _is_given(self, place: int, key: Key) -> bool:
        """Return whether a callback waits for a token from outside: of another one, or in a shared place."""
        return bool(self._makers(place, None if self._owner_of.get(place) != key else key))

    def _place_waiter(self, place: int) -> Waiter:
        link = self._subject.link_of(self._net.places[place])
        assert link is not None
        sources = (source for source in link.sources if isinstance(source, pn.Place))
        element: pn.Element = next(sources, link.target)
        text = words(link) if link.meaning is not None else f"a token in place {words(link)}"
        return Waiter("place", text, str(element.id), element, text)

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
    def _of(self) -> dict[int, Key]:
        """The callback that a transition of the model belongs to."""
        return dict(self._own(pn.Transition, self._subject.transition_index))

    @cached_property
    def _owner_of(self) -> dict[int, Key]:
        """The callback that a place of the model belongs to; while it is marked, the callback has begun."""
        found = dict(self._own(pn.Place, self._subject.place_index))
        found.update((place, key) for key, each in self.callbacks.items() for place in each.places)
        for call in self._calls:
            page = callback_page_of(call.request)
            if page is not None:
                found.update(dict.fromkeys(call.under_way, (page, call.index)))
        return found

    def _own(self, kind: type[pn.Node], index: dict[str, int]) -> Iterator[tuple[int, Key]]:
        for link in self._subject.links():
            if isinstance(link.target, kind) and link.meaning is None and link.sources:
                page = callback_page_of(link.sources[0])
                if page is not None:
                    yield index[link.target.id], (page, link.index)

    @cached_property
    def steps(self) -> dict[Key, list[int]]:
        """The transitions of the model that belong to a callback."""
        inside: dict[Key, list[int]] = defaultdict(list)
        for transition, key in self._of.items():
            inside[key].append(transition)
        return inside

    @cached_property
    def _inactive(self) -> set[int]:
        """Places that are marked while a server instance or a slot is free."""
        parts = ("inactive", "idle slot")
        links = [link for link in self._subject.links() if link.meaning and link.meaning.part in parts]
        return {self._subject.place_index[link.target.id] for link in links}

    @cached_property
    def _calls(self) -> list[Call]:
        return calls_in(self._subject)


def _any(places: Iterable[int], marking: Marking) -> bool:
    return any(marking[place] > 0 for place in places)


def _resource(link: Link, part: str) -> Waiter:
    owner = link.sources[0]
    node = node_net_of(owner)
    assert node is not None
    of = f"of node {node.name or node.id}"
    if part == "threads":
        threads = threads_of(node)
        short = "the only thread" if threads == 1 else f"one of the {threads} threads"
        if "executor" in (node.assumed or "").split():
            short += f" (that it has {'one' if threads == 1 else threads} is assumed)"
        return Waiter("thread", f"{short} {of}", node.id, node, short)
    if isinstance(owner, sym.CallbackGroup):
        short = f"callback group {owner.name or owner.id}"
        return Waiter("group", f"{short} {of}", owner.id, owner, short)
    return Waiter("group", f"the default callback group {of}", node.id, node, "the default callback group")


_KINDS = {
    sym.CallbackKind.timer: "timer callback",
    sym.CallbackKind.subscriber: "subscription callback",
    sym.CallbackKind.server: "service callback",
    sym.CallbackKind.client: "answer callback",
    sym.CallbackKind.goal: "goal callback",
}
"""What ROS calls callbacks."""


def callback_waiter(page: sym.CallbackPage, index: int | None = None) -> Waiter:
    """Return a callback as one that waits, with the number of its server instance or slot."""
    name = str(page.name or page.id)
    if index is not None:
        name += f" ({'slot' if page.kind == sym.CallbackKind.goal else 'instance'} {index})"
    return Waiter("callback", f"{_KINDS[page.kind]} {name}", str(page.id), page, name)


def _begins_with(call: Call, page: sym.CallbackPage) -> bool:
    """Return whether answers to a client begin a callback."""
    client = call.client
    if isinstance(client, sym.ClientPort):
        return callback_page_of(client.response) is page and begins_callback(client)
    return any(callback_page_of(place) is page and begins_answer(client, place) for place in call.answers)
