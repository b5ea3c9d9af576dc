"""A second reading of timers, executors and callback groups: what else the events of the interpreter need.

A callback is a small state machine: how often it runs, and how often it awaits an answer. Which threads are
free and which groups are at rest is counted from that. It shares no code with `dineros.transformations`,
`dineros.analysis` or `dineros.metamodel.callbacks`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from dineros.metamodel import pn, sym
from tests.support.references.histories import Event, Guard, Interpreter, State


@dataclass(frozen=True)
class _Callback:
    """A callback page of a node that runs callbacks, or an instance's copy of one."""

    page: sym.CallbackPage
    copy: int
    node: sym.NodeNet
    group: object
    """What none of the others of it may run together with; None where they may."""
    running: int
    awaiting: int | None


class ExecutorInterpreter(Interpreter):
    """The behaviour of a system model under ROS 2 with its timers, executors and callback groups."""

    def __init__(self, model: sym.SystemModel, signals: str = "none") -> None:
        super().__init__(model, signals)
        self._ports: list[tuple[sym.ServiceChannel, sym.ClientPort]] = [
            (service, client) for service in self._services for client in service.clients
        ]
        self._more: dict[str, list[Guard]] = {}
        self._also: dict[str, dict[int, int]] = {}
        self._callbacks: dict[tuple[pn.Page, int], _Callback] = {}
        self._steps: list[tuple[str, sym.NodeNet]] = []
        """What fires on pages of goals that hold no thread between two steps."""
        pages = [page for page in self._pages if isinstance(page, sym.CallbackPage)]
        for page in pages:
            for copy in self._copies_of(page):
                self._callback(page, copy)
        for page in pages:
            for copy in self._copies_of(page):
                if str(page.kind) == "timer":
                    self._timer(page, copy)
                if (page, copy) in self._callbacks:
                    self._runs(self._callbacks[page, copy])
        for name, net in self._steps:
            self._if(name, self._has_thread(net))
        for service, client in self._ports:
            for copy in self._copies(client.request):
                self._response(service, client, copy)
        for action in self._actions:
            self._goals(action)
            for sender in action.clients:
                self._answers(action, sender)
        self.events = [self._extended(event) for event in self.events]

    def _extended(self, event: Event) -> Event:
        more, guard = self._more.pop(event.name, []), event.guard
        effect = dict(event.effect)
        for slot, tokens in self._also.pop(event.name, {}).items():
            effect[slot] = effect.get(slot, 0) + tokens
        return Event(event.name, lambda s: guard(s) and all(each(s) for each in more), effect)

    def _if(self, name: str, guard: Guard) -> None:
        self._more.setdefault(name, []).append(guard)

    def _then(self, name: str, slot: int | None, tokens: int) -> None:
        assert slot is not None
        self._also.setdefault(name, {})[slot] = tokens

    # ----------------------------------------------------------------------------------- structure

    def _copies_of(self, page: pn.Page) -> list[int]:
        if page not in self._home:
            return [0]
        return list(range(1, self._instances(self._home[page]) + 1))

    def _callback(self, page: sym.CallbackPage, copy: int) -> None:
        node = _node_of(page)
        if node is None or str(node.execution) != "callbacks":
            return
        if str(page.kind) == "goal" and page.awaits:
            for transition in self._transitions_on(page):
                self._steps.append((self._name(transition, copy), node))
            return
        running = self._slot(("running", page, copy))
        awaiting = self._slot(("awaiting", page, copy)) if page.awaits else None
        group = None if str(page.kind) == "goal" else self._group(page, node)
        callback = _Callback(page, copy, node, group, running, awaiting)
        self._callbacks[page, copy] = callback

    def _group(
        self,
        asking: sym.CallbackPage | sym.ClientPort | sym.ActionClientPort,
        node: sym.NodeNet,
    ) -> object:
        """Return what has only one callback at a time; None where a group is reentrant, or there is none."""
        named = asking.group
        if named is None and isinstance(asking, sym.CallbackPage) and str(asking.kind) == "client":
            return None  # a task of the executor, as rclpy has it
        if named is None:
            return node
        return named if str(named.kind) == "exclusive" else None

    def _slots_on(self, page: pn.Page, copy: int) -> set[int]:
        return {
            self._place(place, copy)
            for each in self._pages
            for place in each.objects
            if isinstance(place, pn.Place) and _page_of(place) is page
        }

    def _transitions_on(self, page: pn.Page) -> list[pn.Transition]:
        return [
            node
            for each in self._pages
            for node in each.objects
            if isinstance(node, pn.Transition) and _page_of(node) is page
        ]

    def _calls(self, copy: int) -> list[tuple[int, int]]:
        """Return the request and the response of each client, as seen from a copy of a page."""
        found = []
        for _, client in self._ports:
            copies = self._copies(client.request)
            if not copies:
                continue
            here = copy if copy in copies else copies[0]
            found.append((self._place(client.request, here), self._place(client.response, here)))
            if client.timedOut is not None:
                found.append((self._place(client.request, here), self._place(client.timedOut, here)))
        for action in self._actions:
            for sender in action.clients:
                goal = self._place(sender.goal, 0)
                learned = [] if sender.accepted is None else [sender.accepted]
                found.extend((goal, self._place(place, 0)) for place in (*_told(sender), *learned))
        return found

    def _begins(self, page: sym.CallbackPage, copy: int) -> list[str]:
        """Return the transitions by which a timer's callback begins."""
        own = self._transitions_on(page)
        marked = [t for t in own if isinstance(t, sym.Transition) and str(t.kind) == "start"]
        if marked:
            return [self._name(t, copy) for t in marked]
        effects = {self._name(t, copy): self._uses[self._name(t, copy)].effect() for t in own}
        inside, calls = self._slots_on(page, copy), self._calls(copy)
        gained = {slot for effect in effects.values() for slot, n in effect.items() if n > 0}
        later = (gained & inside) | {a for q, a in calls if a in inside or q in gained}
        return [
            name
            for name, effect in effects.items()
            if not any(n < 0 and slot in later for slot, n in effect.items())
        ]

    def _ends(self, page: sym.CallbackPage, copy: int) -> list[str]:
        """Return the transitions by which a callback ends that is not a server's."""
        own = self._transitions_on(page)
        effects = {self._name(t, copy): self._uses[self._name(t, copy)].effect() for t in own}
        last = [t for t in own if isinstance(t, sym.Transition) and str(t.kind) == "end"]
        places = [
            self._place(place, copy)
            for each in self._pages
            for place in each.objects
            if isinstance(place, sym.Place) and _page_of(place) is page and str(place.kind) == "end"
        ]
        if last or places:
            names = {self._name(t, copy) for t in last}
            return [n for n, e in effects.items() if n in names or any(e.get(p, 0) > 0 for p in places)]
        inside, calls = self._slots_on(page, copy), self._calls(copy)
        taken = {slot for effect in effects.values() for slot, n in effect.items() if n < 0}
        onward = (taken & inside) | {q for q, a in calls if a in inside or a in taken}
        return [
            name
            for name, effect in effects.items()
            if not any(n > 0 and slot in onward for slot, n in effect.items())
        ]

    # ----------------------------------------------------------------------------------- what runs

    def _timer(self, page: sym.CallbackPage, copy: int) -> None:
        """Let a timer tick, and its callback begin once for however many ticks."""
        due = self._slot(("due", page, copy))
        service = self._home.get(page)
        name = page.id if service is None else f"{service.id}[{copy}].{page.id}"
        self._happens(f"{name}.tick", lambda s: s[due] == 0, {due: 1})
        for begin in self._begins(page, copy):
            self._if(begin, lambda s: s[due] == 1)
            self._then(begin, due, -1)

    def _has_thread(self, node: sym.NodeNet) -> Guard:
        threads = node.threads if str(node.executor) == "multi" else 1
        busy = [each.running for each in self._callbacks.values() if each.node is node]
        return lambda s: sum(s[slot] for slot in busy) < threads

    def _is_at_rest(self, group: object) -> Guard:
        """Tell when no callback of a group has begun and not ended."""
        members = [each for each in self._callbacks.values() if group is not None and each.group is group]
        slots = [slot for each in members for slot in (each.running, each.awaiting) if slot is not None]
        return lambda s: not any(s[slot] for slot in slots)

    def _begin(self, name: str, callback: _Callback, ends: Iterable[str] = ()) -> None:
        self._if(name, self._has_thread(callback.node))
        self._if(name, self._is_at_rest(callback.group))
        if name not in ends:
            self._then(name, callback.running, 1)

    def _end(self, name: str, callback: _Callback) -> None:
        self._if(name, lambda s: s[callback.running] > 0)
        self._then(name, callback.running, -1)

    def _runs(self, callback: _Callback) -> None:
        page, copy = callback.page, callback.copy
        for service in self._services:
            if service.server.page is page:
                for name in self._names_of_calls(service):
                    self._begin(f"{name}.call[{copy}]", callback)
                    self._end(f"{name}.return[{copy}]", callback)
                return
        for action in self._actions:
            if action.server.page is page:
                for client in action.clients:
                    prefix = f"{action.id}.client.{client.client}"
                    self._begin(f"{prefix}.accept[{copy}]", callback)
                    for name in _ways_to_end(action, prefix, copy):
                        self._end(name, callback)
                return
        ends = self._ends(page, copy)
        begins = self._begins(page, copy) if str(page.kind) == "timer" else []
        for begin in begins:
            self._begin(begin, callback, ends)
        for end in ends:
            if end not in begins:
                self._end(end, callback)
        for topic in self._topics:
            for reader in topic.subscribers:
                if _page_of(reader.place) is page:
                    self._begin(f"{topic.id}.reader.{self._name(reader.place, 0)}.out", callback)

    def _names_of_calls(self, service: sym.ServiceChannel) -> list[str]:
        """Return the prefixes of the events of calls, also of late ones that there may not be."""
        names = [
            f"{service.id}.client.{self._client_name(client, copy)}"
            for client in service.clients
            for copy in self._copies(client.request)
        ]
        return [*names, f"{service.id}.late"]

    def _client_name(self, client: sym.ClientPort, copy: int) -> str:
        page = client.request.page
        assert page is not None
        caller = self._home.get(page)
        return client.client if caller is None else f"{caller.id}[{copy}].{client.client}"

    def _response(self, service: sym.ServiceChannel, client: sym.ClientPort, copy: int) -> None:
        node = _node_of(client.response)
        if node is None or str(node.execution) != "callbacks":
            return
        name = f"{service.id}.client.{self._client_name(client, copy)}"
        page = _page_of(client.response)
        callback = None if page is None else self._callbacks.get((page, copy))
        self._if(f"{name}.res", self._is_at_rest(self._group(client, node)))
        if callback is not None and _comes_anew(client, callback.page):
            self._begin(f"{name}.res", callback)
            return
        self._if(f"{name}.res", self._has_thread(node))
        if callback is None or callback.awaiting is None or _page_of(client.request) is not page:
            return
        awaiting = callback.awaiting
        self._end(f"{name}.req", callback)
        self._then(f"{name}.req", awaiting, 1)
        self._if(f"{name}.res", lambda s: s[awaiting] > 0)
        self._then(f"{name}.res", awaiting, -1)
        self._then(f"{name}.res", callback.running, 1)
        for event in self.events:
            if event.name.startswith(f"{name}.giveUp."):
                self._if(event.name, self._has_thread(node))
                self._if(event.name, lambda s: s[awaiting] > 0)
                self._then(event.name, awaiting, -1)
                self._then(event.name, callback.running, 1)

    # ------------------------------------------------------------------------------------- actions

    def _between(self, name: str, node: sym.NodeNet, group: object) -> None:
        """Let something happen between callbacks of a group, by a thread that is free."""
        self._if(name, self._has_thread(node))
        self._if(name, self._is_at_rest(group))

    def _goals(self, action: sym.ActionChannel) -> None:
        """Let goals and requests to cancel be taken between the callbacks of the server's group."""
        node = _node_of(action.server.entry)
        if node is None or str(node.execution) != "callbacks":
            return
        assert isinstance(action.server.page, sym.CallbackPage)
        group = self._group(action.server.page, node)
        for number in range(1, self._instances(action) + 1):
            for word in ("cancel", "refuse"):
                self._between(f"{action.id}[{number}].{word}", node, group)
            for client in action.clients:
                self._between(f"{action.id}.client.{client.client}.accept[{number}]", node, group)
        for client in action.clients:
            self._between(f"{action.id}.client.{client.client}.reject", node, group)

    def _answers(self, action: sym.ActionChannel, client: sym.ActionClientPort) -> None:
        """Let a client take results, refusals and feedback: between callbacks, or by one of their own."""
        node, asked = _node_of(client.goal), _page_of(client.goal)
        if node is None or str(node.execution) != "callbacks":
            return
        prefix = f"{action.id}.client.{client.client}"
        taken: list[tuple[str, pn.Place | None]] = []
        for outcome in ("succeeded", "aborted", "canceled"):
            end: pn.Place | None = getattr(action.server, outcome)
            if end is not None:
                taken.append((f"{prefix}.result.{end.id}", getattr(client, outcome)))
        if action.server.mayReject:
            taken.append((f"{prefix}.refused", client.rejected))
        if client.accepted is not None:
            taken.append((f"{prefix}.learn", client.accepted))
        if action.server.feedback is not None and client.feedback is not None:
            taken.append((f"{prefix}.feedback.out", client.feedback))
        awaits = (
            asked is not None and asked.awaits and any(_page_of(place) is asked for place in _told(client))
        )
        if awaits:
            assert asked is not None
            callback = self._callbacks[asked, 0]
            self._end(f"{prefix}.send", callback)
            assert callback.awaiting is not None
            self._then(f"{prefix}.send", callback.awaiting, 1)
        group = self._group(client, node)
        for name, place in taken:
            page = None if place is None else _page_of(place)
            self._if(name, self._is_at_rest(group))
            if page is not None and str(page.kind) == "client" and page is not asked:
                self._begin(name, self._callbacks[page, 0])
                continue
            self._if(name, self._has_thread(node))
            if awaits and page is not None and page is asked and place in _told(client):
                self._goes_on(name, self._callbacks[page, 0])

    def _goes_on(self, name: str, callback: _Callback) -> None:
        awaiting = callback.awaiting
        assert awaiting is not None
        self._if(name, lambda s: s[awaiting] > 0)
        self._then(name, awaiting, -1)
        self._then(name, callback.running, 1)


def _told(client: sym.ActionClientPort) -> list[pn.Place]:
    """Return the places where a client learns that a goal is over, or refused."""
    places = (client.succeeded, client.aborted, client.canceled, client.rejected)
    return [place for place in places if place is not None]


def _ways_to_end(action: sym.ActionChannel, prefix: str, number: int) -> list[str]:
    server = action.server
    places = [p for p in (server.succeeded, server.aborted, server.canceled) if p is not None]
    words = ("finish", "late", "heeded", "unheeded")
    return [f"{prefix}.{word}.{place.id}[{number}]" for word in words for place in places]


def _comes_anew(client: sym.ClientPort, page: sym.CallbackPage) -> bool:
    """Tell whether a response begins a callback, which did not ask for it itself."""
    return str(page.kind) == "client" and _page_of(client.response) is page is not _page_of(client.request)


def _node_of(element: pn.PageObject) -> sym.NodeNet | None:
    holder: object = element
    while holder is not None and not isinstance(holder, sym.NodeNet):
        holder = holder.eContainer()  # type: ignore[attr-defined]
    return holder


def _page_of(element: pn.Node) -> sym.CallbackPage | None:
    holder: object = element.page
    while holder is not None and not isinstance(holder, sym.CallbackPage):
        holder = holder.eContainer()  # type: ignore[attr-defined]
    return holder


__all__ = ["ExecutorInterpreter", "State"]
