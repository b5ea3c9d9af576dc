"""A model against what was seen: what is missing, extra, otherwise; the same has no findings."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from dineros.metamodel import sym
from dineros.observation.differences.comparing import FAULTS, differences
from dineros.observation.differences.described import described, full_name
from dineros.observation.importing.building import to_model
from dineros.observation.systems import (
    USUAL,
    Endpoint,
    ObservedNode,
    ObservedSystem,
    RecordedService,
    RecordedTopic,
)
from tests.support.systems.foreign import TEXT, port, robot, trigger
from tests.support.systems.talker import talker

NODES = (
    ObservedNode("/a", publishers=(port("/x", depth=5),), servers=(trigger("/s"),)),
    ObservedNode("/b", subscribers=(port("/x"),), clients=(trigger("/s"),)),
)
SYSTEM = ObservedSystem("nowhere", NODES)


def changed(**features: Any) -> ObservedSystem:
    """Return the system with another first node."""
    return replace(SYSTEM, nodes=(replace(NODES[0], **features), NODES[1]))


@pytest.mark.parametrize(
    ("there", "rule", "words"),
    [
        (replace(SYSTEM, nodes=NODES[1:]), "node-missing", "node /a is missing"),
        (replace(SYSTEM, departed=("/a",)), "node-missing", "node /a is missing"),
        (changed(name="/aa"), "node-missing", "did you mean '/aa'?"),
        (changed(name="/aa"), "node-extra", "the model has no node /aa"),
        (changed(publishers=()), "port-missing", "node /a has no publisher of /x"),
        (changed(publishers=(port("/xx"),)), "port-missing", "did you mean '/xx'?"),
        (changed(clients=(trigger("/t"),)), "port-extra", "has the client of /t"),
        (
            changed(publishers=(port("/x", "std_msgs/msg/Int32"),)),
            "type-differs",
            "has the type std_msgs/msg/Int32; in the model std_msgs/msg/String",
        ),
        (
            changed(publishers=(port("/x", quality=USUAL._replace(deadline=0.5)),)),
            "quality-differs",
            "has the deadline 0.5 s; in the model without bound",
        ),
        (changed(publishers=(port("/x", depth=6),)), "quality-differs", "the depth 6; in the model 5"),
        (changed(lifecycle="active"), "lifecycle-differs", "is managed; in the model it is not managed"),
    ],
)
def test_one_thing_is_otherwise(there: ObservedSystem, rule: str, words: str) -> None:
    report = differences(to_model(SYSTEM).model, there)
    messages = [each.message for each in report.findings if each.rule == rule]
    assert any(words in message for message in messages), report.findings
    assert rule in FAULTS


def test_what_is_the_same_is_proved() -> None:
    report = differences(to_model(robot()).model, robot())
    assert report.findings == []
    assert len(report.proved) == 12


def test_a_depth_that_nobody_told_is_no_difference() -> None:
    assert differences(to_model(SYSTEM).model, changed(publishers=(port("/x"),))).findings == []


def test_only_some_namespaces_and_without_some_nodes() -> None:
    model = to_model(robot()).model
    sensors = replace(
        robot(), nodes=tuple(each for each in robot().nodes if each.name.startswith("/sensors"))
    )
    assert differences(model, sensors).findings
    assert differences(model, sensors, ["/sensors"]).findings == []
    more = replace(SYSTEM, nodes=(*NODES, ObservedNode("/recorder")))
    assert differences(to_model(SYSTEM).model, more).findings
    assert differences(to_model(SYSTEM).model, more, without=["/recorder"]).findings == []


def test_the_same_port_twice_is_no_third() -> None:
    twice = changed(publishers=(port("/x", depth=5), port("/x", depth=5)))
    model = to_model(twice).model
    assert differences(model, twice).findings == []
    assert [each.rule for each in differences(model, SYSTEM).findings] == ["port-missing"]


def test_topics_of_a_recording() -> None:
    model = to_model(SYSTEM).model

    def rules(*topics: RecordedTopic) -> list[tuple[str, str]]:
        found = differences(model, ObservedSystem("bag", (), topics)).findings
        return [(each.rule, each.severity) for each in found]

    assert rules(RecordedTopic("/x", TEXT, (USUAL,))) == []
    assert rules(RecordedTopic("/y", TEXT)) == [("topic-extra", "error"), ("topic-not-recorded", "note")]
    assert rules(RecordedTopic("/x", "std_msgs/msg/Int32")) == [("type-differs", "error")]
    lossy = USUAL._replace(reliability="bestEffort")
    assert rules(RecordedTopic("/x", TEXT, (USUAL, lossy))) == [("quality-differs", "error")]


def test_services_of_a_recording() -> None:
    endpoint = Endpoint("/ask", "std_srvs/srv/Trigger")
    nodes = (ObservedNode("/a", servers=(endpoint,)), ObservedNode("/b", clients=(endpoint,)))
    model = to_model(ObservedSystem("nowhere", nodes)).model

    def rules(*services: RecordedService) -> list[tuple[str, str]]:
        found = ObservedSystem("bag", services=services)
        return [(finding.rule, finding.severity) for finding in differences(model, found).findings]

    assert rules(RecordedService("/ask", "std_srvs/srv/Trigger")) == []
    assert rules(RecordedService("/ask", "std_srvs/srv/Empty")) == [("type-differs", "error")]
    other = RecordedService("/asks", "std_srvs/srv/Trigger")
    assert rules(other) == [("service-extra", "error"), ("service-not-recorded", "note")]


def test_names_and_types_of_a_model_that_was_not_imported() -> None:
    node = sym.NodeNet(id="left-arm", namespace="/robot")
    assert full_name(node) == "/robot/left_arm"
    nodes = described(talker()).system.nodes
    assert all(each.name.startswith("/") for each in nodes)
    types = {end.type for each in nodes for end in (*each.publishers, *each.subscribers)}
    assert all("/msg/" in each for each in types)
