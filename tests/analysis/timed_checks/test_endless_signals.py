"""Stored properties where a signal may change endlessly: only runs that take infinite time violate them."""

from __future__ import annotations

import pytest

from dineros.analysis.timed_checks.timed_check import check_timed
from dineros.metamodel import sym
from dineros.metamodel.build import callback, node_net, place, seconds, step
from dineros.metamodel.clauses import set_clause

LEADS = "fired(Say) leads to fired(Listen)"


def told(latency: float | None) -> sym.SystemModel:
    """Return a model of a timer that says a word while a button is pressed, and of a listener."""
    model = sym.SystemModel(id="greeting", middleware="ros2")
    speaker = node_net(model, "speaker", execution="callbacks")
    speaker.signals.append(sym.InputSignal(id="Button"))
    timer = callback(speaker, "OnTimer", "timer", 1.0, duration=seconds(0, 0.1))
    said = place(timer, "Said")
    set_clause(step(timer, "Say", [], [said]), "Button")
    listener = node_net(model, "listener", execution="callbacks")
    heard = callback(listener, "OnChatter", duration=seconds(0, 0.2))
    words = place(heard, "Heard")
    step(heard, "Listen", [words])
    chatter = sym.TopicChannel(id="Chatter", topic="chatter")
    if latency is not None:
        chatter.latency = seconds(0, latency)
    chatter.publishers.append(sym.PublisherPort(place=said, limit=5))
    chatter.subscribers.append(sym.SubscriberPort(place=words, limit=5))
    model.channels.append(chatter)
    model.properties.append(sym.Property(id="IsHeard", text=LEADS))
    return model


@pytest.mark.parametrize("signals", ["none", "fullyEnabled"])
def test_what_has_to_follow_follows_whatever_a_signal_does(signals: str) -> None:
    model = told(0.1)
    model.properties[0].signals = signals
    report = check_timed(model)
    assert not [each.message for each in report.findings if each.rule == "property-violated"]
    (proof,) = [each for each in report.proved if LEADS in each]
    assert "infinitely many firings in finite time do not count" in proof


def test_what_need_not_follow_is_a_violation() -> None:
    """Without a latency, a message may be on its way forever."""
    assert [each for each in check_timed(told(None)).findings if each.rule == "property-violated"]
