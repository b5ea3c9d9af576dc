"""Small models that tests of several formats share."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow, inhibit, read


def small_net() -> pn.Net:
    """Return a net with every kind of arc, a nested page, a reference, an interval and a priority."""
    net = pn.Net(id="small", name="Small & <odd>")
    page, inner = pn.Page(id="page", net=net), pn.Page(id="inner")
    idle, busy = pn.Place(id="idle", tokens=2, page=page), pn.Place(id="busy", page=page)
    start = pn.Transition(id="start", interval=pn.TimeInterval(earliest=1.0, latest=2.5), page=page)
    stop = pn.Transition(id="stop", overrides=[start], page=page)
    page.objects.append(inner)
    reference = pn.ReferencePlace(id="idle2", target=idle, page=inner)
    refill = pn.Transition(id="refill", page=inner)
    flow(idle, start, busy, stop)
    flow(refill, reference, weight=3)
    inhibit(busy, start, 2)
    read(idle, stop)
    return net


def small_system() -> sym.SystemModel:
    """Return a system model of a talker and a listener, with a signal, a clause and token data."""
    model = sym.SystemModel(id="talk")
    model.tokenType = sym.TokenType(id="Token", fields=[sym.TokenField(name="text")])
    talker, listener = sym.NodeNet(id="talker", net=model), sym.NodeNet(id="listener", net=model)
    said = sym.Place(id="said", tokens=2, balloons=[sym.BalloonToken(data='{"text": "hello"}')], page=talker)
    page = sym.CallbackPage(id="callback", page=listener)
    heard, take = sym.Place(id="heard", page=page), sym.Transition(id="take", page=page)
    flow(heard, take)
    ready = sym.InputSignal(id="ready", node=listener)
    clause = sym.InputClause(text="!ready", transition=take)
    clause.disjunctions.append(sym.Disjunction(literals=[sym.Literal(signal=ready, negated=True)]))
    topic = sym.TopicChannel(id="chatter", topic="/chatter", model=model)
    topic.publishers.append(sym.PublisherPort(place=said, limit=3))
    topic.subscribers.append(sym.SubscriberPort(place=heard))
    return model
