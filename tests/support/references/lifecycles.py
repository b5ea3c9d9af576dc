"""A second reading of managed nodes: in which state each one is, and what else happens, or can not, there.

A managed node is a number: 0 unconfigured, 1 inactive, 2 active, 3 finalized. Before it is configured,
nothing of it exists; while it is inactive, only what it publishes is lost. It shares no code with
`dineros.transformations` or `dineros.analysis`.
"""

from __future__ import annotations

from dineros.metamodel import pn, sym
from tests.support.references.calls import is_deserted, leaves, sends_once
from tests.support.references.executors import ExecutorInterpreter, _node_of, _page_of
from tests.support.references.histories import Guard, are_matched, quality_of

UNCONFIGURED, INACTIVE, ACTIVE, FINALIZED = range(4)


def is_kept(writer: sym.PublisherPort, reader: sym.SubscriberPort) -> bool:
    """Tell whether a reader that comes late gets what was written before it: only if both are reliable."""
    qualities = quality_of(writer), quality_of(reader)
    return {(str(each.durability), str(each.reliability)) for each in qualities} == {
        ("transientLocal", "reliable")
    }


class LifecycleInterpreter(ExecutorInterpreter):
    """The behaviour of a system model under ROS 2 with its managed nodes."""

    def __init__(self, model: sym.SystemModel, signals: str = "none") -> None:
        super().__init__(model, signals)
        self._nodes = [p for p in self._pages if isinstance(p, sym.NodeNet) and p.lifecycle is not None]
        self._life = {node: self._slot(("life", node)) for node in self._nodes}
        self._empty: dict[sym.NodeNet, list[int]] = {node: [] for node in self._nodes}
        """Slots that are empty when a node is configured."""
        self._settled: dict[sym.NodeNet, list[tuple[str, int]]] = {node: [] for node in self._nodes}
        """Slots that are empty when a node leaves; with the beginning of what it does then."""
        for topic in self._topics:
            self._writers(topic)
            self._readers(topic)
        for service in self._services:
            self._calls_of(service)
        for action in self._actions:
            self._goals_of(action)
        for node in self._nodes:
            self._works(node)
            self._changes_state(node)
        self.events = [self._extended(event) for event in self.events]

    # ------------------------------------------------------------------------------------ states

    def _in(self, node: sym.NodeNet | None, *states: int) -> Guard:
        """Tell whether a node is in one of some states; one without a lifecycle is always active."""
        slot = self._life.get(node) if node is not None else None
        return lambda s: (ACTIVE if slot is None else s[slot]) in states

    def _is_there(self, node: sym.NodeNet | None) -> Guard:
        return self._in(node, INACTIVE, ACTIVE)

    def _changes_state(self, node: sym.NodeNet) -> None:
        life = node.lifecycle
        assert life is not None
        self._change(node, "configure", UNCONFIGURED, INACTIVE, life.configureStep)
        self._change(node, "activate", INACTIVE, ACTIVE, life.activateStep)
        if life.configureFails:
            self._change(node, "configure.fails", UNCONFIGURED, UNCONFIGURED, life.configureStep)
        if life.activateFails:
            self._change(node, "activate.fails", INACTIVE, INACTIVE, life.activateStep)
        if life.deactivates:
            self._change(node, "deactivate", ACTIVE, INACTIVE)
        if life.cleansUp:
            self._change(node, "cleanup", INACTIVE, UNCONFIGURED)
        if life.shutsDown:
            for word, state in (("unconfigured", UNCONFIGURED), ("inactive", INACTIVE), ("active", ACTIVE)):
                self._change(node, f"shutdown.{word}", state, FINALIZED)

    def _change(self, node: sym.NodeNet, word: str, before: int, after: int, step: int = 0) -> None:
        name, slot = f"{node.id}.{word}", self._life[node]
        self._happens(name, self._in(node, before), {slot: after - before} if after != before else {})
        if word.startswith("configure"):
            for empty in self._empty[node]:
                self._if(name, lambda s, empty=empty: s[empty] == 0)  # type: ignore[misc]
        for beginning, slot in self._settled[node]:
            if word.startswith(beginning):
                self._if(name, lambda s, slot=slot: s[slot] == 0)  # type: ignore[misc]
        if str(node.execution) == "callbacks":
            self._if(name, self._has_thread(node))
            self._if(name, self._is_at_rest(node))
        for other in self._nodes:
            life = other.lifecycle
            if other is node or life is None:
                continue
            if 0 < life.configureStep < step:
                self._if(name, self._is_there(other))
            if 0 < life.activateStep < step:
                self._if(name, self._in(other, ACTIVE))

    # -------------------------------------------------------------------------------------- work

    def _works(self, node: sym.NodeNet) -> None:
        """Let nothing of a node happen before it is configured; a callback that has begun continues."""
        pauses = node.lifecycle is not None and node.lifecycle.pauses
        works = self._in(node, ACTIVE) if pauses else self._is_there(node)
        for page in self._pages:
            if isinstance(page, sym.CallbackPage) and str(page.kind) == "timer" and _node_of(page) is node:
                for copy in self._copies_of(page):
                    service = self._home.get(page)
                    name = page.id if service is None else f"{service.id}[{copy}].{page.id}"
                    self._if(f"{name}.tick", self._is_there(node))
            for each in page.objects:
                if not isinstance(each, pn.Transition) or _node_of(each) is not node:
                    continue
                callback = _page_of(each)
                for copy in self._copies(each):
                    name = self._name(each, copy)
                    if (
                        str(node.execution) == "net"
                        or callback is None
                        or (str(callback.kind) == "timer" and name in self._begins(callback, copy))
                    ):
                        self._if(name, works)

    def _calls_of(self, service: sym.ServiceChannel) -> None:
        server = self._is_there(_node_of(service.server.page))
        clients: dict[str, Guard] = {}
        for client in service.clients:
            there = self._is_there(_node_of(client.request))
            for copy in self._copies(client.request):
                clients[f"{service.id}.client.{self._client_name(client, copy)}."] = there
        for event in self.events:
            for prefix in (*clients, f"{service.id}.late."):
                if not event.name.startswith(prefix):
                    continue
                what = event.name[len(prefix) :]
                if what.startswith(("call[", "return[")):
                    self._if(event.name, server)
                elif what in ("req", "res") or what.startswith("giveUp."):
                    self._if(event.name, clients[prefix])
        if is_deserted(service):
            self._deserted(service)

    def _deserted(self, service: sym.ServiceChannel) -> None:
        """Lose what clients of rclpy ask a server that is not there, and what it has when it goes away."""
        node = _node_of(service.server.page)
        assert node is not None and node.lifecycle is not None
        there, away = self._is_there(node), self._in(node, UNCONFIGURED, FINALIZED)
        goes, comes_again = leaves(service), node.lifecycle.cleansUp
        for client in service.clients:
            for copy in self._copies(client.request):
                name = self._client_name(client, copy)
                prefix = f"{service.id}.client.{name}"
                sent, kept = (self._slots[service, name, word] for word in ("sent", "kept"))
                counted = self._slots.get((service, name, "lost"))
                lost = {} if counted is None else {counted: 1}
                for word in ("in", "drop", "instead"):
                    self._if(f"{prefix}.{word}", there)
                if goes and comes_again:
                    self._empty[node].append(kept)
                if not sends_once(client):
                    if goes:
                        self._moved(f"{prefix}.again", kept, {sent: 1}, away)
                    continue
                if client.waitsForService:
                    self._if(f"{prefix}.req", there)
                self._moved(f"{prefix}.miss", sent, lost, away)
                if not goes:
                    continue
                self._moved(f"{prefix}.left", kept, lost, away)
                leaving = ("cleanup", "shutdown.inactive", "shutdown.active")
                self._settled[node].extend((word, sent) for word in leaving)
                for number in range(1, self._instances(service) + 1):
                    served, late = self._slots[service, name, number], self._slots[service, "late", number]
                    self._moved(f"{prefix}.unanswered[{number}]", served, {**lost, late: 1}, away)
                    if comes_again:
                        self._empty[node].append(served)
        if goes and (service, "late") in self._slots:
            late = self._slots[service, "late"]
            self._moved(f"{service.id}.late.gone", late, {}, away)
            if comes_again:
                self._empty[node].append(late)

    def _moved(self, name: str, slot: int, to: dict[int, int], guard: Guard) -> None:
        self._happens(name, lambda s: s[slot] > 0 and guard(s), {slot: -1, **to})

    def _goals_of(self, action: sym.ActionChannel) -> None:
        """Let nothing happen to goals at an end whose node is not there; feedback it had is lost."""
        server = self._is_there(_node_of(action.server.page))
        told = ("accept[", "reject", "finish.", "late.", "heeded.", "unheeded.", "feedback[")
        heard = ("result.", "refused", "feedback.out", "learn")
        asked = ("send", "cancel[", "again[", "nothing", "twice", "tooLate.")
        for event in self.events:
            if event.name.startswith(f"{action.id}[") and event.name.endswith(("].cancel", "].refuse")):
                self._if(event.name, server)
            for client in action.clients:
                prefix = f"{action.id}.client.{client.client}."
                if not event.name.startswith(prefix):
                    continue
                what = event.name[len(prefix) :]
                if what.startswith(told):
                    self._if(event.name, server)
                elif what.startswith((*heard, *asked)):
                    self._if(event.name, self._is_there(_node_of(client.goal)))
        for client in action.clients:
            node, name = _node_of(client.goal), f"{action.id}.client.{client.client}.feedback"
            if node is None or node.lifecycle is None:
                continue
            if not (node.lifecycle.cleansUp or node.lifecycle.shutsDown):
                continue
            if ("come", name) in self._slots:
                away = self._in(node, UNCONFIGURED, FINALIZED)
                for word, slot in (("gone", "come"), ("clear", "kept")):
                    self._lost(f"{name}.{word}", self._slots[slot, name], away)
                    self._empty[node].append(self._slots[slot, name])

    # ------------------------------------------------------------------------------------ topics

    def _writers(self, topic: sym.TopicChannel) -> None:
        for writer in topic.publishers:
            node = _node_of(writer.place)
            for copy in self._copies(writer.place) if node in self._life else ():
                place = self._name(writer.place, copy)
                sent = self._slots[place]
                self._if(f"{topic.id}.publisher.{place}.publish", self._in(node, ACTIVE))
                name = f"{topic.id}.publisher.{place}.discard"
                self._happens(name, lambda s, sent=sent: s[sent] > 0, {sent: -1})  # type: ignore[misc]
                self._if(name, self._in(node, INACTIVE))
                life = None if node is None else node.lifecycle
                if life is not None and (life.cleansUp or life.shutsDown):
                    name = f"{topic.id}.publisher.{place}.abandon"
                    self._lost(name, sent, self._in(node, UNCONFIGURED, FINALIZED))
            for reader in topic.subscribers:
                if are_matched(writer, reader):
                    self._pair(topic, writer, reader)

    def _pair(self, topic: sym.TopicChannel, writer: sym.PublisherPort, reader: sym.SubscriberPort) -> None:
        name = f"{topic.id}.writer.{writer.place.id}.{reader.place.id}"
        come, kept = self._slots["come", name], self._slots["kept", name]
        node, other = _node_of(writer.place), _node_of(reader.place)
        late = is_kept(writer, reader)
        gone = (FINALIZED,) if late else (UNCONFIGURED, FINALIZED)
        delivered = None
        if other is not None and other.lifecycle is not None:
            for word in ("in", "drop"):
                self._if(f"{name}.{word}", lambda s: not self._in(other, *gone)(s))
            self._if(f"{name}.out", self._is_there(other))
            self._lost(f"{name}.miss", come, self._in(other, *gone))
            leaving = ("shutdown.",) if late else ("cleanup", "shutdown.inactive", "shutdown.active")
            self._settled[other].extend((word, come) for word in leaving)
            if other.lifecycle.shutsDown or (other.lifecycle.cleansUp and not late):
                self._lost(f"{name}.left", kept, self._in(other, *gone))
            if other.lifecycle.cleansUp and late:
                delivered = self._again(name, come, kept, writer.limit, other)
                self._empty[other].append(delivered)
            elif other.lifecycle.cleansUp:
                self._empty[other].append(kept)
        life = None if node is None else node.lifecycle
        if node is not None and life is not None and (life.cleansUp or life.shutsDown):
            away = self._in(node, UNCONFIGURED, FINALIZED)
            self._lost(f"{name}.gone", kept, away)
            self._empty[node].append(kept)
            if delivered is not None:
                self._lost(f"{name}.forget", delivered, away)
                self._empty[node].append(delivered)

    def _lost(self, name: str, slot: int, guard: Guard) -> None:
        self._happens(name, lambda s: s[slot] > 0 and guard(s), {slot: -1})

    def _again(self, name: str, come: int, kept: int, depth: int, reader: sym.NodeNet) -> int:
        """Let a reader that has been cleaned up get again what its writer still keeps."""
        delivered = self._slot(("delivered", name))
        self._if(f"{name}.in", lambda s: s[kept] + s[delivered] < depth)
        self._then(f"{name}.out", delivered, 1)
        self._happens(
            f"{name}.replace",
            lambda s: s[come] > 0 and s[delivered] > 0 and s[kept] + s[delivered] == depth,
            {come: -1, delivered: -1, kept: 1},
        )
        self._if(f"{name}.replace", lambda s: not self._in(reader, FINALIZED)(s))
        self._happens(f"{name}.again", lambda s: s[delivered] > 0, {delivered: -1, kept: 1})
        self._if(f"{name}.again", self._in(reader, UNCONFIGURED))
        return delivered

    def _readers(self, topic: sym.TopicChannel) -> None:
        for reader in topic.subscribers:
            node = _node_of(reader.place)
            if node is None or node.lifecycle is None:
                continue
            name = f"{topic.id}.reader.{self._name(reader.place, 0)}"
            self._if(f"{name}.out", self._is_there(node))
            if node.lifecycle.cleansUp or node.lifecycle.shutsDown:
                away = self._in(node, UNCONFIGURED, FINALIZED)
                for word, slot in (("gone", "come"), ("clear", "kept")):
                    self._lost(f"{name}.{word}", self._slots[slot, name], away)
                    self._empty[node].append(self._slots[slot, name])
