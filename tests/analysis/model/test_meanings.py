"""A rule says what its elements mean, and nobody needs to know the rule."""

from __future__ import annotations

from dineros.analysis.model.queues import queues_of
from dineros.analysis.model.step_roles import StepRole, step_roles
from dineros.analysis.model.wording import words
from dineros.metamodel import pn, sym
from dineros.metamodel.records import Drop, Publish, Transfer
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.language.meaning import Meaning
from dineros.transformations.language.patterns import Node
from dineros.transformations.language.rule import Rule
from dineros.transformations.rules.notation import OverflowQueue, place, transition
from tests.support.systems.talker import talker


class Mirror(Rule):
    """A second topic and a second queue for each publisher, of one's own."""

    channel = Node(sym.TopicChannel)
    port = Node(sym.PublisherPort, channel=channel)
    source = Node(pn.Place, of=port.place)
    seen = place("{channel.id}.seen", means=Meaning("messages seen on topic {topic}"))
    forget = transition(
        "{channel.id}.forget", means=Meaning("topic {topic} forgets", step=Transfer, part="forget")
    )
    plain = place("{channel.id}.plain")
    queue = OverflowQueue(
        "{channel.id}.mirror", source=source, limit=port.limit, sinks=[seen], kind="publisher", enters=Publish
    )

    lhs = [channel, port, source]
    rhs = [*lhs, seen, forget, plain, *queue]


def test_elements_of_a_rule_of_ones_own_have_words_steps_and_queues() -> None:
    model = talker()
    trace = flatten(model, "none", extra=[Mirror]).trace
    (channel,) = model.channels
    links = {link.role: link for link in trace if link.rule == "Mirror"}
    assert words(links["seen"]) == "messages seen on topic chatter"
    assert words(links["plain"]) == f"{channel.id}.plain"
    assert words(links["queue.drop"]) == "publisher queue of Said (topic chatter) loses a message"
    roles = step_roles(trace.links)
    assert roles[f"{channel.id}.forget"] == StepRole(Transfer, channel=channel.id, stage="forget")
    assert roles[f"{channel.id}.mirror.in"].kind is Publish
    assert roles[f"{channel.id}.mirror.drop"].kind is Drop
    assert sorted(queue.load for queue in queues_of(trace) if queue.kind == "publisher") == [
        f"{channel.id}.mirror.Load",
        f"{channel.id}.publisher.Said.Load",
    ]


def test_queues_have_all_their_parts() -> None:
    queues = queues_of(flatten(talker(), "none").trace)
    assert [queue.kind for queue in queues] == ["publisher", "dispatcher", "subscriber"]
    for queue in queues:
        (entrance,) = queue.entrances
        prefix = queue.load.removesuffix(".Load")
        assert (queue.capacity, queue.leave) == (f"{prefix}.Capacity", f"{prefix}.out")
        assert (entrance.enter, entrance.drop) == (f"{prefix}.in", f"{prefix}.drop")
        assert queue.drops == (entrance.drop,)
