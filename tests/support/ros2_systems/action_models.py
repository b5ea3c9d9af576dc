"""A Hypothesis strategy for models with actions: slots, refusals, cancels, feedback, under executors, too."""

from __future__ import annotations

import itertools

from hypothesis import strategies as st

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow, read
from dineros.metamodel.elements import node_nets
from tests.support.ros2_systems.executor_models import executor_models
from tests.support.ros2_systems.history_models import qualities


@st.composite
def action_models(draw: st.DrawFn) -> sym.SystemModel:
    """Return a small system with one action or two, alone or beside topics, services and timers."""
    beside = draw(st.integers(0, 2)) == 0
    return _Builder(draw, draw(executor_models()) if beside else _bare(draw)).model


def _bare(draw: st.DrawFn) -> sym.SystemModel:
    model = sym.SystemModel(id="bare", middleware="ros2")
    for number in range(draw(st.integers(1, 3))):
        net = sym.NodeNet(id=f"node{number}", net=model)
        net.execution = draw(st.sampled_from(["net", "callbacks", "callbacks"]))
        net.executor = draw(st.sampled_from(["single", "multi"]))
        net.threads = draw(st.integers(1, 3)) if net.executor == sym.Executor.multi else 1
        for group in range(draw(st.integers(0, 2))):
            kind = draw(st.sampled_from(["exclusive", "reentrant"]))
            net.callbackGroups.append(sym.CallbackGroup(id=f"group{group}.{net.id}", kind=kind))
    return model


class _Builder:
    def __init__(self, draw: st.DrawFn, model: sym.SystemModel) -> None:
        self.draw = draw
        self.model = model
        self.numbers = itertools.count()
        self.services = [each for each in model.channels if isinstance(each, sym.ServiceChannel)]
        self.topics = [each for each in model.channels if isinstance(each, sym.TopicChannel)]
        for number in range(draw(st.sampled_from([1, 1, 1, 2]))):
            self._action(number)

    def _maybe(self) -> bool:
        return self.draw(st.booleans())

    def _net(self) -> sym.NodeNet:
        return self.draw(st.sampled_from(node_nets(self.model)))

    def _place(self, stem: str, page: pn.Page, tokens: int = 0) -> sym.Place:
        return sym.Place(id=f"{stem}.a{next(self.numbers)}", tokens=tokens, page=page)

    def _transition(self, stem: str, page: pn.Page) -> sym.Transition:
        return sym.Transition(id=f"{stem}.a{next(self.numbers)}", page=page)

    def _group(self, net: sym.NodeNet) -> sym.CallbackGroup | None:
        choice: list[sym.CallbackGroup | None] = [None, *net.callbackGroups]
        return self.draw(st.sampled_from(choice))

    def _action(self, number: int) -> None:
        draw, net = self.draw, self._net()
        page = sym.CallbackPage(id=f"goal{number}", kind="goal", awaits=self._maybe(), page=net)
        server = self._server(net, page)
        action = sym.ActionChannel(
            id=f"action{number}",
            action=f"/action{number}",
            instances=draw(st.sampled_from([None, None, 1, 2])),
            depth=draw(st.integers(1, 2)),
            server=server,
            model=self.model,
        )
        for each in range(draw(st.sampled_from([1, 1, 2]))):
            self._client(action, each)

    def _server(self, net: sym.NodeNet, page: sym.CallbackPage) -> sym.ActionServerPort:
        """Let a page work on a goal in one or two steps, end it somehow, and take note of cancels or not."""
        draw = self.draw
        server = sym.ActionServerPort(page=page, entry=self._place("entry", page))
        page.group = self._group(net)
        server.mayReject = self._maybe()
        begin, working = self._transition("begin", page), self._place("working", page)
        flow(server.entry, begin, working)
        if self.services and self._maybe():
            asked, answered = self._place("asked", page), self._place("answered", page)
            draw(st.sampled_from(self.services)).clients.append(
                sym.ClientPort(client=f"of{page.id}", request=asked, response=answered)
            )
            call, go_on = self._transition("call", page), self._transition("goOn", page)
            further = self._place("further", page)
            flow(working, call, asked)
            flow(answered, go_on, further)
            working = further
        outcomes = draw(st.sampled_from([("succeeded",), ("aborted",), ("succeeded", "aborted")]))
        for outcome in outcomes:
            place = self._place(outcome, page)
            flow(working, self._transition(f"to.{outcome}", page), place)
            setattr(server, outcome, place)
        if draw(st.integers(0, 3)):
            server.cancel = self._place("cancel", page)
            heeds = draw(st.sampled_from(["no", "takes", "takes", "reads"]))
            if heeds != "no":
                stop = self._transition("stop", page)
                server.canceled = self._place("canceled", page)
                flow(working, stop, server.canceled)
                if heeds == "takes":
                    flow(server.cancel, stop)
                else:
                    read(server.cancel, stop)
        elif self._maybe():
            server.canceled = self._place("canceled", page)  # which is never reached
        if self._maybe():
            inner = pn.Page(id=f"inner.{page.id}", page=page) if self._maybe() else page
            server.feedback = told = self._place("told", inner)
            here = told if inner is page else pn.ReferencePlace(id=f"ref.{page.id}", target=told, page=page)
            flow(
                draw(st.sampled_from([begin, *told_by(page)])), here, weight=draw(st.sampled_from([1, 1, 2]))
            )
        if self.topics and self._maybe():
            sent = self._place("sent", page)
            flow(begin, sent)
            qos = draw(qualities())
            draw(st.sampled_from(self.topics)).publishers.append(
                sym.PublisherPort(place=sent, limit=1, qos=qos)
            )
        if self._maybe():
            state = self._place("state", net, tokens=1)
            read(pn.ReferencePlace(id=f"shared.{page.id}", target=state, page=page), begin)
        return server

    def _client(self, action: sym.ActionChannel, number: int) -> None:
        """Send goals from a node net, or from a timer's callback; take answers there, or in callbacks."""
        draw, net, id = self.draw, self._net(), f"client{number}"
        page: pn.Page = net
        if self._maybe():
            page = sym.CallbackPage(id=f"{action.id}.timer{number}", kind="timer", timer=1.0, page=net)
            page.group = self._group(net)
        goal = self._place("goal", page, 0 if page is not net else draw(st.integers(1, 2)))
        client = sym.ActionClientPort(
            client=id,
            goal=goal,
            group=self._group(net),
            outstanding=draw(st.sampled_from([None, None, 1, 2])),
        )
        waits = page is not net and self._maybe()
        if page is not net:
            first = self._transition("send", page)
            flow(self._place("budget", page, tokens=draw(st.integers(1, 2))), first, goal)
            if isinstance(page, sym.CallbackPage):
                page.awaits = waits and self._maybe()
        for role in ("succeeded", "aborted", "canceled", "rejected"):
            where = draw(st.sampled_from(["here", "here", "callback", "net", "nowhere"]))
            if where != "nowhere":
                setattr(client, role, self._answer(action, client, role, where, net, page if waits else net))
        if self._maybe():
            client.accepted = self._answer(
                action, client, "accepted", draw(st.sampled_from(["net", "callback"])), net, net
            )
        if draw(st.integers(0, 3)):
            client.cancel = self._place("wish", net, tokens=draw(st.integers(0, 2)))
            if self._maybe():
                flow(self._place("doubt", net, tokens=1), self._transition("wishes", net), client.cancel)
        if self._maybe():
            client.feedback = self._answer(
                action, client, "feedback", draw(st.sampled_from(["net", "callback"])), net, net
            )
        action.clients.append(client)

    def _answer(
        self,
        action: sym.ActionChannel,
        client: sym.ActionClientPort,
        role: str,
        where: str,
        net: sym.NodeNet,
        here: pn.Page,
    ) -> sym.Place:
        """Return a place for an answer; something takes it where it stands on a callback page."""
        id, page = f"{action.id}.{client.client}.{role}", net if where == "net" else here
        if where == "callback":
            page = sym.CallbackPage(id=f"{id}.callback", kind="client", page=net)
            page.group = self._group(net)
        place = self._place(role, page)
        if page is not net or self._maybe():
            flow(place, self._transition("take", page), self._place("had", net if page is net else page))
        return place


def told_by(page: pn.Page) -> list[sym.Transition]:
    """Return the transitions of a page."""
    return [node for node in page.objects if isinstance(node, sym.Transition)]
