"""Losses because of a managed node whose life is only assumed: they say nothing about the code."""

from __future__ import annotations

from collections import Counter

import pytest

from dineros.analysis.checks.check import check
from dineros.analysis.consequences.lives import OPEN, RULES, WHY, left_to_lives
from dineros.analysis.witnesses.findings import Report
from dineros.metamodel import sym
from dineros.metamodel.elements import node_nets
from dineros.observation.importing.building import to_model
from dineros.observation.systems import ObservedNode, ObservedSystem, TopicEndpoint

SCAN = (TopicEndpoint("/scan", "sensor_msgs/msg/LaserScan"),)
TALKER = ObservedNode("/lidar", publishers=SCAN, lifecycle="active")
NODES = (TALKER, ObservedNode("/log", subscribers=SCAN, lifecycle="active"))


def model_of_code() -> sym.SystemModel:
    return to_model(ObservedSystem("code", NODES)).model


def given(model: sym.SystemModel, *ids: str) -> None:
    """Let the facts state the life of some nodes."""
    for node in node_nets(model):
        if node.id in ids:
            node.assumed = " ".join(word for word in (node.assumed or "").split() if word != "lifecycle")


def losses(report: Report) -> Counter[str]:
    return Counter(each.severity for each in report.findings if each.rule in RULES)


def test_losses_that_need_an_assumed_change_of_state_are_notes() -> None:
    model = model_of_code()
    report = check(model)
    faults = losses(report)
    assert faults["error"] and faults["warning"] and not faults["note"]
    left = left_to_lives(model, report)
    assert losses(left) == {"note": sum(faults.values())}
    assert all(each.message.endswith(WHY) for each in left.findings if each.rule in RULES)
    assert [each for each in left.findings if each.rule not in RULES] == [
        each for each in report.findings if each.rule not in RULES
    ]


@pytest.mark.parametrize("node", ["lidar", "log"])
def test_losses_are_faults_where_the_facts_state_the_life_of_a_node(node: str) -> None:
    model = model_of_code()
    given(model, node)
    left = losses(left_to_lives(model, check(model)))
    assert left["error"] + left["warning"]
    given(model, "lidar", "log")
    report = check(model)
    assert left_to_lives(model, report) == report


def test_what_is_not_decided_is_a_note_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dineros.analysis.checks.overflow.can_fire", lambda checked, transitions: None)
    model = model_of_code()
    report = check(model)
    asked = [each for each in report.unknown if each.rule in RULES]
    left = left_to_lives(model, report)
    assert asked and left.unknown == [each for each in report.unknown if each.rule not in RULES]
    of_lives = [each.message for each in left.findings if each.rule in RULES]
    assert of_lives == [f"{each.question} {OPEN}" for each in asked]
