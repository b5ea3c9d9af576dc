"""A Hypothesis strategy for services whose server pages call services and publish; all nets are bounded."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

from hypothesis import strategies as st

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow, read
from dineros.metamodel.clauses import set_clause


@st.composite
def calling_systems(
    draw: st.DrawFn, circles: bool = False, services: int = 3, limit: int = 2
) -> sym.SystemModel:
    """Return a system of one to `services` services, each of which may call later ones and publish.

    `circles` lets a later service call an earlier one, where all of them declare their instances; `limit` is
    the largest capacity of a queue.
    """
    return _Builder(draw, circles, services, limit).model


class _Builder:
    def __init__(self, draw: st.DrawFn, circles: bool, services: int, limit: int) -> None:
        self.draw = draw
        self.numbers: Iterator[int] = itertools.count()
        self.limits = st.integers(1, limit)
        self.model = sym.SystemModel(id="calling")
        count = draw(st.integers(min(2, services), services))
        self.circle = circle = circles and draw(st.booleans())
        self.nets = [sym.NodeNet(id=f"server{number}", net=self.model) for number in range(count)]
        self.signal = sym.InputSignal(id="Go", initial=True, node=self.nets[0])
        self.news = sym.TopicChannel(id="news", topic="/news")
        # The first two may live in one node net.
        homes = [self.nets[0], *(draw(st.sampled_from([self.nets[0], net])) for net in self.nets[1:])]
        self.channels = [self._service(net, number, circle) for number, net in enumerate(homes)]
        for number, channel in enumerate(self.channels):
            later = list(range(number + 1, count))
            allowed = [0] if circle and not later else later
            called = draw(st.lists(st.sampled_from(allowed), max_size=2)) if allowed else []
            self._serve(channel, [self.channels[each] for each in called])
        for number in range(draw(st.integers(1, 2))):
            self._user(number, self.channels[draw(st.integers(0, min(1, count - 1)))])
        if len(self.news.publishers):
            self.model.channels.append(self.news)
            self._listeners()

    def _id(self, stem: str) -> str:
        return f"{stem}{next(self.numbers)}"

    def _place(self, stem: str, page: pn.Page, tokens: int = 0) -> sym.Place:
        return sym.Place(id=self._id(stem), tokens=tokens, page=page)

    def _service(self, net: sym.NodeNet, number: int, declared: bool) -> sym.ServiceChannel:
        page = sym.CallbackPage(id=f"page{number}", kind="server", page=net)
        entry, exit_ = self._place("entry", page), self._place("exit", page)
        return sym.ServiceChannel(
            id=f"service{number}",
            service=f"/service{number}",
            server=sym.ServerPort(entry=entry, exit=exit_, page=page),
            instances=self.draw(st.sampled_from([1, 2] if declared else [None, None, 1, 2])),
            model=self.model,
        )

    def _serve(self, channel: sym.ServiceChannel, called: list[sym.ServiceChannel]) -> None:
        """Let a server page call services, one after the other or at once, and publish in the end."""
        draw, server = self.draw, channel.server
        page, at_once = server.page, draw(st.booleans())
        begin, end = self._transition("begin", page), self._transition("end", page)
        flow(server.entry, begin)
        flow(end, server.exit)
        before = begin
        for each in called:
            request, response = self._place("request", page), self._place("response", page)
            each.clients.append(sym.ClientPort(client=self._id("client"), request=request, response=response))
            flow(begin if at_once else before, request)
            if not at_once:
                before = self._transition("go_on", page)
            flow(response, end if at_once else before)
        if not (called and at_once):
            flow(before, self._place("last", page), end)
        if draw(st.booleans()):
            state = self._place("state", page.page or page, tokens=1)
            read(pn.ReferencePlace(id=self._id("ref"), target=state, page=page), begin)
        if page.page is self.nets[0] and draw(st.booleans()):
            set_clause(end, "Go")
        if len(self.news.publishers) < 2 and draw(st.booleans()):
            self._publish(page, draw(st.sampled_from([begin, end])))

    def _transition(self, stem: str, page: pn.Page) -> sym.Transition:
        return sym.Transition(id=self._id(stem), page=page)

    def _publish(self, page: pn.Page, transition: sym.Transition) -> None:
        """Publish from a server page, sometimes from a page inside it."""
        inner = pn.Page(id=self._id("inner"), page=page) if self.draw(st.booleans()) else page
        sent = self._place("sent", inner)
        here = sent if inner is page else pn.ReferencePlace(id=self._id("ref"), target=sent, page=page)
        flow(transition, here)
        self.news.publishers.append(sym.PublisherPort(place=sent, limit=self.draw(self.limits)))

    def _user(self, number: int, channel: sym.ServiceChannel) -> None:
        net = sym.NodeNet(id=f"user{number}", net=self.model)
        request = self._place("ask", net, tokens=self.draw(st.integers(1, 2)))
        response = self._place("got", net)
        flow(response, self._transition("take", net), self._place("done", net))
        channel.clients.append(sym.ClientPort(client=f"user{number}", request=request, response=response))

    def _listeners(self) -> None:
        """Subscribe to the news; what comes is noted, or is the request of a call (of the last service)."""
        net = sym.NodeNet(id="listener", net=self.model)
        for number in range(self.draw(st.integers(1, 2))):
            page = sym.CallbackPage(id=f"hear{number}", page=net)
            heard, noted = self._place("heard", page), self._place("noted", page)
            self.news.subscribers.append(sym.SubscriberPort(place=heard, limit=self.draw(self.limits)))
            last = self.channels[-1]
            if self._is_quiet(last) and (number == 0 or self.draw(st.booleans())):
                last.clients.append(sym.ClientPort(client=f"listener{number}", request=heard, response=noted))
            else:
                flow(heard, self._transition("note", page), noted)

    def _is_quiet(self, channel: sym.ServiceChannel) -> bool:
        """Tell whether calling the last service makes no news, which would call it again, and so on."""
        page = channel.server.page
        pages = [page, *(inner for inner in page.objects if isinstance(inner, pn.Page))]
        return not self.circle and not any(port.place.page in pages for port in self.news.publishers)
