"""A Hypothesis strategy for small system models whose flows run forward, so that all nets are bounded."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

from hypothesis import strategies as st

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow, inhibit, read
from dineros.metamodel.clauses import set_clause

SATISFIABLE = [
    "{0}",
    "!{0}",
    "{0} | {1}",
    "({0} | !{1}) & ({1} | !{0})",
    "({0} | !{0}) & {1}",
    "!({0} & {1})",
]
UNSATISFIABLE = ["{0} & !{0}", "({0} | {1}) & !{0} & !{1}"]


@st.composite
def small_system_models(
    draw: st.DrawFn, satisfiable: bool = False, clients: int = 1, nets: int = 3
) -> sym.SystemModel:
    """Return a system model of one to `nets` node nets with at most two channels and two signals.

    `satisfiable` leaves out clauses that are never true; `clients` is the least number of a service.
    """
    return _Builder(draw, satisfiable, clients, nets).model


class _Builder:
    def __init__(self, draw: st.DrawFn, satisfiable: bool, clients: int, nets: int) -> None:
        self.draw = draw
        self.texts = SATISFIABLE if satisfiable else SATISFIABLE + UNSATISFIABLE
        self.numbers: Iterator[int] = itertools.count()
        self.least_clients = clients
        self.signals = 2
        self.model = sym.SystemModel(id="system")
        self.nets = [self._node_net(number) for number in range(draw(st.integers(1, nets)))]
        for _ in range(draw(st.integers(0, 2))):
            if len(self.nets) > 1 and draw(st.booleans()):
                self._service()
            else:
                self._topic()

    def _id(self, stem: str) -> str:
        return f"{stem}{next(self.numbers)}"

    def _place(self, stem: str, page: pn.Page, tokens: int = 0) -> sym.Place:
        return sym.Place(id=self._id(stem), tokens=tokens, page=page)

    def _transition(self, stem: str, page: pn.Page) -> sym.Transition:
        return sym.Transition(id=self._id(stem), page=page)

    def _reference(self, target: pn.PlaceNode, page: pn.Page) -> pn.PlaceNode:
        """Refer to a place, sometimes through a chain."""
        for _ in range(self.draw(st.integers(1, 2))):
            target = pn.ReferencePlace(id=self._id("ref"), target=target, page=page)
        return target

    def _node_net(self, number: int) -> sym.NodeNet:
        """Add a line start -> work -> middle -> finish -> end and a state page."""
        draw = self.draw
        net = sym.NodeNet(id=self._id("node"), net=self.model)
        for _ in range(draw(st.integers(0, self.signals))):
            self.signals -= 1
            sym.InputSignal(id=self._id("signal"), initial=draw(st.booleans()), node=net)
        states = pn.Page(id=self._id("states"), page=net)
        state = self._place("state", states, tokens=draw(st.integers(0, 2)))
        shared = self._reference(state, net)
        start = self._place("start", net, tokens=draw(st.integers(0, 2)) if number else 2)
        middle, end = self._place("middle", net), self._place("end", net)
        work, finish = self._transition("work", net), self._transition("finish", net)
        flow(start, work, weight=draw(st.sampled_from([1, 1, 1, 2])))
        flow(work, middle, finish, end)
        if draw(st.booleans()):
            finish.overrides.append(work)
        self._test(shared, work)
        self._clause(net, work)
        self._clause(net, finish)
        if draw(st.booleans()):
            self._other_end(finish, end, states, draw(st.booleans()))
        return net

    def _test(self, place: pn.PlaceNode, transition: pn.TransitionNode) -> None:
        """Let a transition depend on a place, whose tokens it leaves as they are."""
        kind = self.draw(st.sampled_from(["none", "loop", "read", "inhibitor"]))
        weight = self.draw(st.integers(1, 2))
        if kind == "loop":
            flow(place, transition, place, weight=weight)
        elif kind == "read":
            read(place, transition, weight)
        elif kind == "inhibitor":
            inhibit(place, transition, weight)

    def _other_end(self, transition: pn.Transition, place: pn.Place, page: pn.Page, out: bool) -> None:
        """Join a transition from another page, by references to it and to the place."""
        reference = pn.ReferenceTransition(id=self._id("rt"), target=transition, page=page)
        other = self._reference(place, page)
        if out:
            flow(reference, other)
        else:
            self._test(other, reference)

    def _clause(self, net: sym.NodeNet, transition: sym.Transition) -> None:
        if len(net.signals) and self.draw(st.booleans()):
            text = self.draw(st.sampled_from(self.texts))
            set_clause(transition, text.format(net.signals[0].id, net.signals[len(net.signals) - 1].id))

    def _topic(self) -> None:
        draw = self.draw
        channel = sym.TopicChannel(id=self._id("topic"), topic=self._id("/topic"), model=self.model)
        limits = st.integers(1, 2)
        sources = draw(st.lists(st.integers(0, len(self.nets) - 1), min_size=1, max_size=2, unique=True))
        for source in sources:
            sent = self._place("sent", self.nets[source])
            flow(self._sender(self.nets[source]), sent)
            channel.publishers.append(sym.PublisherPort(place=sent, limit=draw(limits)))
        targets = draw(st.lists(st.integers(max(sources), len(self.nets) - 1), max_size=2))
        for target in targets:
            net = self.nets[target]
            page = sym.CallbackPage(id=self._id("callback"), page=net)
            received, handle = self._place("received", page), self._transition("handle", page)
            later = target > max(sources) and draw(st.booleans())
            flow(received, handle, self._reference(_named(net, "middle" if later else "end"), page))
            channel.subscribers.append(sym.SubscriberPort(place=received, limit=draw(limits)))
            if all(dispatcher.node is not net for dispatcher in channel.dispatchers) and draw(st.booleans()):
                channel.dispatchers.append(sym.Dispatcher(node=net, limit=draw(st.integers(1, 3))))

    def _service(self) -> None:
        draw = self.draw
        server = draw(st.sampled_from(self.nets))
        page = sym.CallbackPage(id=self._id("server"), kind="server", page=server)
        entry, exit_ = self._place("entry", page), self._place("exit", page)
        serve = self._transition("serve", page)
        flow(entry, serve, exit_)
        self._test(self._reference(_state(server), page), serve)
        if draw(st.booleans()):
            self._test(self._place("stock", page, tokens=draw(st.integers(0, 2))), serve)
        if draw(st.booleans()):  # an exit on an inner page, reached by references
            inner = pn.Page(id=self._id("inner"), page=page)
            last, exit_ = self._reference(exit_, inner), self._place("exit", inner)
            leave = self._transition("leave", inner)
            flow(last, leave, exit_)
            leave.overrides.append(serve)
            self._clause(server, leave)
        if draw(st.booleans()):
            _sender(server).overrides.append(serve)
        self._clause(server, serve)
        channel = sym.ServiceChannel(
            id=self._id("service"),
            service=self._id("/service"),
            server=sym.ServerPort(entry=entry, exit=exit_, page=page),
            instances=draw(st.sampled_from([None, 1, 2])),
            model=self.model,
        )
        others: Sequence[sym.NodeNet] = [net for net in self.nets if net is not server]
        for net in draw(st.lists(st.sampled_from(others), min_size=self.least_clients, max_size=2)):
            request, response = self._place("request", net), self._place("response", net)
            flow(_sender(net), request)
            flow(response, self._transition("take", net), _named(net, "end"))
            channel.clients.append(
                sym.ClientPort(client=self._id("client"), request=request, response=response)
            )

    def _sender(self, net: sym.NodeNet) -> sym.Transition:
        return _sender(net, self.draw(st.booleans()))


def _named(net: sym.NodeNet, stem: str) -> sym.Place:
    return next(
        node for node in net.objects if isinstance(node, sym.Place) and node.id.rstrip("0123456789") == stem
    )


def _state(net: sym.NodeNet) -> pn.Place:
    page = next(page for page in net.objects if isinstance(page, pn.Page))
    return next(node for node in page.objects if isinstance(node, pn.Place))


def _sender(net: sym.NodeNet, early: bool = False) -> sym.Transition:
    work, finish, *_ = (node for node in net.objects if isinstance(node, sym.Transition))
    return work if early else finish
