"""A Hypothesis strategy for models of ROS 2 whose nodes run callbacks: timers, groups, awaits."""

from __future__ import annotations

import itertools

from hypothesis import strategies as st

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from dineros.metamodel.elements import node_nets
from tests.support.ros2_systems.history_models import history_models


@st.composite
def executor_models(draw: st.DrawFn) -> sym.SystemModel:
    """Return a small system of topics and services with timers, some of whose nodes run callbacks."""
    return _Builder(draw, draw(history_models())).model


class _Builder:
    def __init__(self, draw: st.DrawFn, model: sym.SystemModel) -> None:
        self.draw = draw
        self.model = model
        self.numbers = itertools.count()
        self.services = [each for each in model.channels if isinstance(each, sym.ServiceChannel)]
        self.topics = [each for each in model.channels if isinstance(each, sym.TopicChannel)]
        for net in node_nets(model):
            net.execution = draw(st.sampled_from(["net", "callbacks", "callbacks"]))
            net.executor = draw(st.sampled_from(["single", "multi", "multi"]))
            net.threads = draw(st.integers(1, 3)) if net.executor == sym.Executor.multi else 1
            for number in range(draw(st.integers(0, 2))):
                kind = draw(st.sampled_from(["exclusive", "reentrant"]))
                net.callbackGroups.append(sym.CallbackGroup(id=f"group{number}.{net.id}", kind=kind))
        for net in draw(st.lists(st.sampled_from(node_nets(model)), max_size=2, unique=True)):
            self._timer(net)
        for page in [each for each in model.eAllContents() if isinstance(each, sym.CallbackPage)]:
            self._callback(page)
        for service in self.services:
            for client in service.clients:
                client.group = self._group(client.response)

    def _id(self, stem: str) -> str:
        return f"{stem}.{next(self.numbers)}"

    def _group(self, element: pn.PageObject) -> sym.CallbackGroup | None:
        net = element.page
        while not isinstance(net, sym.NodeNet):
            assert net is not None
            net = net.page
        choice: list[sym.CallbackGroup | None] = [None, *net.callbackGroups]
        return self.draw(st.sampled_from(choice))

    def _callback(self, page: sym.CallbackPage) -> None:
        """Choose its group, whether it awaits, and see that it can end."""
        page.group = self._group(page)
        clients = [client for service in self.services for client in service.clients]
        own = [c for c in clients if page is _around(c.request) is _around(c.response)]
        for client in own:
            if not client.response.outgoing:
                flow(client.response, sym.Transition(id=self._id("then"), page=client.response.page))
        nodes = [each for each in page.eAllContents() if isinstance(each, pn.Transition)]
        if own and all(len(each.outgoing) < 2 for each in nodes):
            page.awaits = self.draw(st.booleans())

    def _timer(self, net: sym.NodeNet) -> None:
        """Add a timer, whose callback works, calls and continues, or leaves the answer to another one."""
        draw = self.draw
        callback = sym.CallbackPage(id=self._id("timer"), kind="timer", timer=0.5, page=net)
        page: pn.Page = pn.Page(id=self._id("inner"), page=callback) if draw(st.booleans()) else callback
        last = begin = self._transition(page)
        if draw(st.booleans()):
            flow(sym.Place(id=self._id("budget"), tokens=draw(st.integers(1, 2)), page=page), begin)
        for step in draw(st.lists(st.sampled_from(["work", "call", "call"]), max_size=2)):
            if step == "work" or not self.services:
                between, after = sym.Place(id=self._id("between"), page=page), self._transition(page)
                flow(last, between, after)
                last = after
                continue
            last = self._call(page, net, last)
            if last.page is not page:
                break
        assert last.page is not None
        topics: list[sym.TopicChannel | None] = [None, *self.topics]
        topic = draw(st.sampled_from(topics))
        if topic is not None:
            sent = sym.Place(id=self._id("sent"), page=last.page)
            flow(last, sent)
            topic.publishers.append(sym.PublisherPort(place=sent, limit=1))
        if draw(st.booleans()):
            begin.kind = sym.TransitionKind.start
        if last is not begin and draw(st.booleans()):
            last.kind = sym.TransitionKind.end
        elif draw(st.booleans()):
            flow(last, sym.Place(id=self._id("ended"), kind="end", page=last.page))

    def _call(self, page: pn.Page, net: sym.NodeNet, before: sym.Transition) -> sym.Transition:
        """Call a service, and return what takes the response: there, or in a callback of its own."""
        request = sym.Place(id=self._id("request"), page=page)
        flow(before, request)
        if self.draw(st.integers(0, 2)) == 0:
            page = sym.CallbackPage(id=self._id("answered"), kind="client", page=net)
        response, after = sym.Place(id=self._id("response"), page=page), self._transition(page)
        flow(response, after)
        self.draw(st.sampled_from(self.services)).clients.append(
            sym.ClientPort(client=self._id("client"), request=request, response=response)
        )
        return after

    def _transition(self, page: pn.Page) -> sym.Transition:
        return sym.Transition(id=self._id("step"), page=page)


def _around(place: pn.Place) -> pn.Page | None:
    page = place.page
    while page is not None and not isinstance(page, sym.CallbackPage):
        page = page.page
    return page
