"""A small valid system model: one node publishes words to another one; a signal, a clause, data in tokens."""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.clauses import set_clause


def talker() -> sym.SystemModel:
    """Return the model."""
    words, say, said = sym.Place(id="Words", tokens=3), sym.Transition(id="Say"), sym.Place(id="Said")
    button = sym.InputSignal(id="Button")
    speaker = sym.NodeNet(id="talker", objects=[words, say, said], signals=[button])
    flow(words, say, said)
    set_clause(say, "Button")

    heard, listen, noted = sym.Place(id="Heard"), sym.Transition(id="Listen"), sym.Place(id="Noted")
    callback = sym.CallbackPage(id="OnChatter", objects=[heard, listen, noted])
    listener = sym.NodeNet(id="listener", objects=[callback])
    flow(heard, listen, noted)

    chatter = sym.TopicChannel(
        id="Chatter",
        topic="chatter",
        publishers=[sym.PublisherPort(place=said)],
        subscribers=[sym.SubscriberPort(place=heard)],
    )
    return sym.SystemModel(id="greeting", pages=[speaker, listener], channels=[chatter])
