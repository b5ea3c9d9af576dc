"""A small valid model of each kind, without any violation, to break in one place."""

from __future__ import annotations

from typing import Any

from dineros.metamodel import pn, pnm, rtm, sym
from dineros.metamodel.build import flow, inhibit, read
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.elements import find


class Small:
    """A model whose elements are found by id: ``small["Talk"]``; untyped, since tests break it."""

    def __init__(self, net: pn.Net) -> None:
        self.net: Any = net

    def __getitem__(self, id: str) -> Any:
        return find(self.net, id)


def plain() -> Small:
    """Return a place/transition net of two pages with references, time and priorities."""
    net = pn.Net(id="plain")
    left, right = pn.Page(id="left", net=net), pn.Page(id="right", net=net)
    layout = pn.Graphics(positions=[pn.Point(x=1.0, y=2.0)])
    p, q = pn.Place(id="p", tokens=1, page=left, graphics=layout), pn.Place(id="q", page=left)
    t = pn.Transition(id="t", page=left, interval=pn.TimeInterval(earliest=1.0, latest=2.0))
    u = pn.Transition(id="u", page=right, overrides=[t])
    pr, tr = (
        pn.ReferencePlace(id="pr", target=p, page=right),
        pn.ReferenceTransition(id="tr", target=t, page=right),
    )
    r = pn.Place(id="r", page=right)
    flow(p, t, q)
    flow(r, u, pr)
    read(r, tr)
    inhibit(pr, u)
    return Small(net)


def system() -> Small:
    """Return a system model of two node nets that meet through a topic and a service."""
    model = sym.SystemModel(id="small")
    model.tokenType = sym.TokenType(
        id="Token",
        fields=[
            sym.TokenField(name="count", kind="integer", default="1"),
            sym.TokenField(name="pose", kind="list", elementKind="number", length=2, default="[0, 0.5]"),
            sym.TokenField(name="tag", kind="text"),
        ],
    )
    _talker(model)
    _listener(model)
    small = Small(model)
    chatter = sym.TopicChannel(
        id="chatter",
        topic="/chatter",
        type="std_msgs/msg/String",
        mappings=[sym.FieldMapping(messageField="data", tokenField="tag")],
        publishers=[sym.PublisherPort(place=small["Said"])],
        subscribers=[sym.SubscriberPort(place=small["Heard"])],
        dispatchers=[sym.Dispatcher(node=small["listener"], limit=4)],
    )
    ask = sym.ServiceChannel(
        id="ask",
        service="/ask",
        server=sym.ServerPort(entry=small["Entry"], exit=small["Exit"], page=small["serve"]),
        clients=[sym.ClientPort(client="c1", request=small["Ask"], response=small["Answer"])],
        instances=2,
    )
    model.channels.extend([chatter, ask])
    return small


def _talker(model: sym.SystemModel) -> None:
    net = sym.NodeNet(
        id="talker", package="talking", namespace="/left", executor="multi", threads=2, net=model
    )
    net.signals.extend([sym.InputSignal(id="Ready"), sym.InputSignal(id="Danger")])
    net.callbackGroups.append(sym.CallbackGroup(id="group"))
    idle = sym.Place(id="Idle", tokens=1, balloons=[sym.BalloonToken(data='{"count": "3"}')], page=net)
    talk = sym.Transition(
        id="Talk", page=net, kind="timed", interval=pn.TimeInterval(earliest=1.0, latest=2.0)
    )
    said, ask, answer = (sym.Place(id=id, page=net) for id in ("Said", "Ask", "Answer"))
    done = sym.Transition(id="Done", page=net)
    state = pn.Page(id="state", page=net)
    busy = sym.Place(id="Busy", page=state)
    reference = pn.ReferencePlace(id="BusyHere", target=busy, page=net)
    flow(idle, talk, said)
    flow(talk, ask)
    flow(answer, done, idle)
    inhibit(reference, talk)
    set_clause(talk, "Ready -> !Danger")
    clock = sym.CallbackPage(id="clock", kind="timer", timer=0.5, page=net)
    sym.Place(id="Tick", page=clock)


def _listener(model: sym.SystemModel) -> None:
    net = sym.NodeNet(id="listener", net=model)
    net.signals.append(sym.InputSignal(id="Open"))
    net.callbackGroups.append(sym.CallbackGroup(id="others"))
    count = sym.Place(id="Count", tokens=1, page=net)
    hear = sym.CallbackPage(id="hear", page=net)
    sym.Place(id="Heard", page=hear)
    serve = sym.CallbackPage(id="serve", kind="server", page=net)
    entry, exit_ = sym.Place(id="Entry", page=serve), sym.Place(id="Exit", page=serve)
    answer = sym.Transition(id="Serve", page=serve)
    reference = pn.ReferencePlace(id="CountHere", target=count, page=serve)
    flow(entry, answer, exit_)
    read(reference, answer)
    set_clause(answer, "Open")


def callbacks() -> Small:
    """Return a system model of ROS 2 whose nodes run callbacks: a timer's that awaits, and two others."""
    model = sym.SystemModel(id="callbacks", middleware="ros2")
    net = sym.NodeNet(id="node", execution="callbacks", net=model)
    net.callbackGroups.append(sym.CallbackGroup(id="own"))
    clock = sym.CallbackPage(id="Clock", kind="timer", timer=0.5, awaits=True, page=net)
    ask, got = sym.Place(id="Ask", page=clock), sym.Place(id="Got", page=clock)
    flow(sym.Transition(id="Begin", page=clock), ask)
    flow(got, sym.Transition(id="Finish", page=clock))
    hear = sym.CallbackPage(id="Hear", page=net)
    heard = sym.Place(id="Heard", page=hear)
    flow(heard, sym.Transition(id="Note", page=hear))
    sym.Place(id="Noted", page=hear)
    other = sym.NodeNet(id="other", execution="callbacks", net=model)
    other.callbackGroups.append(sym.CallbackGroup(id="others"))
    said = sym.Place(id="Said", page=other)
    flow(sym.Transition(id="Say", page=other), said)
    serve = sym.CallbackPage(id="Serve", kind="server", page=other)
    entry, exit_ = sym.Place(id="In", page=serve), sym.Place(id="Out", page=serve)
    flow(entry, sym.Transition(id="Work", page=serve), exit_)
    topic = sym.TopicChannel(
        id="Topic",
        topic="/topic",
        publishers=[sym.PublisherPort(place=said)],
        subscribers=[sym.SubscriberPort(place=heard)],
    )
    service = sym.ServiceChannel(
        id="Service",
        service="/service",
        server=sym.ServerPort(entry=entry, exit=exit_, page=serve),
        clients=[
            sym.ClientPort(client="clock", request=ask, response=got, group=net.callbackGroups[0]),
        ],
    )
    model.channels.extend([topic, service])
    return Small(model)


def runtime() -> Small:
    """Return a run-time model of a node with a port of each kind."""
    model = rtm.RuntimeModel(id="node", systemModel="small")
    net = sym.NodeNet(id="talker", net=model)
    model.node = net
    said, ask, answer = (rtm.Place(id=id, page=net) for id in ("Said", "Ask", "Answer"))
    hear = sym.CallbackPage(id="hear", page=net)
    heard = rtm.Place(id="Heard", page=hear)
    serve = sym.CallbackPage(id="serve", kind="server", page=net)
    entry, exit_ = rtm.Place(id="Entry", page=serve), rtm.Place(id="Exit", page=serve)
    said.ports.append(rtm.PublisherPort(channel="chatter", topic="/chatter"))
    heard.ports.append(rtm.SubscriberPort(channel="news", topic="/news"))
    ask.ports.append(rtm.ClientPort(channel="ask", service="/ask", client="c1", response=answer))
    entry.ports.append(rtm.ServerPort(channel="serve", service="/serve", exit=exit_, page=serve))
    return Small(model)


def flat() -> Small:
    """Return a Petri-net model with a certificate."""
    model = pnm.PetriNetModel(id="flat", systemModel="small")
    page = pn.Page(id="page", net=model)
    load, capacity = pn.Place(id="Load", page=page), pn.Place(id="Capacity", tokens=3, page=page)
    terms = [pnm.InvariantTerm(place=load), pnm.InvariantTerm(place=capacity)]
    model.certificate.append(pnm.PlaceInvariant(name="Load + Capacity = 3", value=3, terms=terms))
    return Small(model)
