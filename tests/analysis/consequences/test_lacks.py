"""Unused parts of models of source code are notes while the model lacks parts of the code."""

from __future__ import annotations

from dineros.analysis.checks.check import check
from dineros.analysis.consequences.lacks import RULES, WHY, left_to_lacks
from dineros.metamodel import sym
from dineros.observation.importing.building import to_model
from dineros.observation.importing.given import Given, GivenNode
from dineros.observation.systems import Endpoint, ObservedNode, ObservedSystem

STOP = (Endpoint("/stop", "std_srvs/srv/Trigger"),)
NODES = (ObservedNode("/base", servers=STOP), ObservedNode("/panel", clients=STOP))


def model(*lacks: str) -> sym.SystemModel:
    given = Given({"/panel": GivenNode(), "/base": GivenNode()})
    return to_model(ObservedSystem("code", NODES), given, "code", lacks).model


def test_unused_parts_are_faults_if_nothing_is_missing() -> None:
    whole = model()
    report = check(whole)
    assert {each.rule for each in report.findings if each.severity != "note"} & RULES
    assert left_to_lacks(whole, report) == report


def test_unused_parts_are_notes_if_the_model_lacks_something() -> None:
    part = model("not read: panel.cpp")
    before, after = check(part), left_to_lacks(part, check(part))
    changed = [each for each in after.findings if each not in before.findings]
    assert changed and all(each.severity == "note" and each.message.endswith(WHY) for each in changed)
    assert not [each for each in after.findings if each.rule in RULES and each.severity != "note"]
    assert [each for each in before.findings if each.rule not in RULES] == [
        each for each in after.findings if each.rule not in RULES
    ]
