"""Messages arrive with the values with which they were sent, in models with guards or without."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import pytest

from dineros.analysis.conformance import Verdict, conform
from dineros.analysis.conformance.data.arrivals import Arrivals
from dineros.metamodel import sym
from dineros.metamodel.build import node_net, place, step
from dineros.metamodel.records import Record, Response, Serve, Start, Take
from tests.analysis.conformance.recording import recorded
from tests.analysis.conformance.test_values import finished


def talking(type: str | None = None) -> sym.SystemModel:
    """Return a node that tells another one three different words, without any guard."""
    fields = [sym.TokenField(name="word"), sym.TokenField(name="weight", kind="number", ros="float32")]
    model = sym.SystemModel(
        id="talking", tokenType=sym.TokenType(id="Word", fields=fields), middleware="ros2"
    )
    talker, listener = node_net(model, "talker"), node_net(model, "listener")
    words, said = place(talker, "Words", tokens=3), place(talker, "Said")
    words.balloons.extend(sym.BalloonToken(data=f'{{"word": "{each}", "weight": 0.1}}') for each in "abc")
    heard, kept = place(listener, "Heard"), place(listener, "Kept")
    step(talker, "Say", [words], [said])
    step(listener, "Keep", [heard], [kept])
    channel = sym.TopicChannel(id="Talk", topic="/talk", type=type)
    channel.publishers.append(sym.PublisherPort(place=said))
    channel.subscribers.append(sym.SubscriberPort(place=heard))
    model.channels.append(channel)
    return model


def verdict_on(model: sym.SystemModel, traces: dict[str, list[Record]]) -> Verdict:
    return conform(model, {node: partial(iter, records) for node, records in traces.items()})


def changed(traces: dict[str, list[Record]], kind: type[Record], **data: Any) -> dict[str, list[Record]]:
    """Return traces in which the first record of a kind carries other data."""
    found = {node: list(records) for node, records in traces.items()}
    for records in found.values():
        for number, record in enumerate(records):
            if isinstance(record, kind):
                records[number] = replace(record, data={**record.data, **data})  # type: ignore[attr-defined,call-arg]
                return found
    raise AssertionError(f"no {kind.__name__}")


@pytest.mark.parametrize("seed", range(3))
def test_a_message_of_a_topic_with_another_word(seed: int) -> None:
    model = talking()
    traces = recorded(model, seed, 40)
    assert verdict_on(model, traces).status == "conforms"
    wrong = verdict_on(model, changed(traces, Take, word="z"))
    (deviation,) = wrong.violations
    assert "Heard.word is z, but Said sent" in deviation.reason
    assert verdict_on(model, changed(traces, Take, weight=0.25)).status == "conforms"


def test_what_is_not_known_is_not_compared() -> None:
    model = talking()
    traces = changed(recorded(model, 1, 40), Take, word="z")
    nameless = {
        node: [replace(each, message=None) if isinstance(each, Take) else each for each in records]
        for node, records in traces.items()
    }
    assert not [each for each in verdict_on(model, nameless).violations if "sent" in each.reason]
    typed = talking("std_msgs/msg/String")
    assert not [each for each in verdict_on(typed, traces).violations if "sent" in each.reason]


def test_requests_and_responses_of_a_service() -> None:
    model, traces = finished()
    for kind, sent in ((Serve, "Ask"), (Response, "Ask[1].Exit")):
        arrived = [each for records in traces.values() for each in records if isinstance(each, kind)]
        level = 0 if arrived[0].data["level"] else 1
        wrong = verdict_on(model, changed(traces, kind, level=level))
        assert any(f", but {sent} sent " in each.reason for each in wrong.violations)


def test_a_node_that_begins_anew_gives_old_numbers_to_new_messages() -> None:
    model = talking()
    traces = recorded(model, 2, 40)
    arrivals = Arrivals(model)
    for record in traces["talker"]:
        arrivals.happen(record)
    arrived = next(each for each in traces["listener"] if isinstance(each, Take))
    wrong = replace(arrived, data={**arrived.data, "word": "z"})
    assert arrivals.fault(arrived) is None
    assert arrivals.fault(wrong) is not None
    arrivals.happen(Start(sequence=99, node="talker"))
    assert arrivals.fault(wrong) is None
