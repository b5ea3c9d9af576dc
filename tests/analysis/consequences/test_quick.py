"""Unused parts fold under their causes by planned runs, however little time there is for a search."""

from __future__ import annotations

from typing import Any

import pytest

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.checks.check import check
from dineros.analysis.consequences import folding
from dineros.analysis.consequences.folding import fold_consequences
from dineros.analysis.consequences.quick import folded_quickly
from dineros.analysis.witnesses.findings import Finding, Report
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.elements import find
from examples.callbacks.models import battery, node, program, topic


def unheard(model: sym.SystemModel) -> sym.SystemModel:
    """Add a topic whose reader asks for more reliability than its writer offers."""
    writer, reader = node(model, "lidar"), node(model, "logger")
    said = sym.Place(id="Scan", page=writer)
    flow(sym.Place(id="ToScan", tokens=1, page=writer), sym.Transition(id="Scans", page=writer), said)
    page = sym.CallbackPage(id="OnScan", page=reader)
    heard = sym.Place(id="Heard", page=page)
    flow(heard, sym.Transition(id="Log", page=page))
    topic(model, "Scans_", said, heard)
    channel = find(model, "Scans_", sym.TopicChannel)
    channel.publishers[0].qos = sym.QualityOfService(reliability="bestEffort")
    channel.subscribers[0].qos = sym.QualityOfService(reliability="reliable")
    return model


def never(model: sym.SystemModel) -> sym.SystemModel:
    """Add a node with a transition that never fires, whatever is fixed."""
    other = node(model, "other")
    flow(sym.Place(id="Never", page=other), sym.Transition(id="Idle", page=other))
    return model


def out_of_time(*_: Any) -> Any:
    raise BudgetExceededError("time")


def consequences(findings: list[Finding]) -> dict[str, list[str]]:
    return {each.rule: [one.elements[0] for one in each.consequences] for each in findings}


def folded_without_search(
    model: sym.SystemModel, monkeypatch: pytest.MonkeyPatch
) -> tuple[Report, list[Finding]]:
    report = check(model)
    before = list(report.findings)
    monkeypatch.setattr(folding, "fix_of", out_of_time)
    fold_consequences(model, report, Budget(seconds=600).begun(), again=None)
    return report, before


def test_each_part_is_under_its_cause_without_a_search(monkeypatch: pytest.MonkeyPatch) -> None:
    report, before = folded_without_search(never(unheard(program("same_group"))), monkeypatch)
    assert {"Log", "NoteLevel", "Idle"} <= {
        each.elements[0] for each in before if each.rule == "dead-transition"
    }
    found = consequences(report.findings)
    assert found["callback-deadlock"] == ["NoteLevel"]
    assert "Log" in found["ports-not-matched"]
    assert [each.elements for each in report.findings if each.rule == "dead-transition"] == [("Idle",)]


def test_a_change_after_which_the_circle_closes_is_not_taken() -> None:
    """One thread and one group: neither a thread more nor a group alone lets the callback end."""
    model = battery()
    report = check(model)
    causes = [each for each in report.findings if each.rule == "callback-deadlock"]
    assert len(causes) == 1
    assert not list(folded_quickly(model, causes, report.findings, Budget().begun()))


def test_the_report_is_folded_as_far_as_it_is_when_time_runs_out() -> None:
    """What is printed at the limit of time is the report as it is then, and is already folded."""
    model = unheard(program("same_group"))
    report = check(model)
    begun: list[str] = []

    def stage(name: str) -> None:
        begun.append(name)
        if begun.count(folding.QUICK) == 3:  # two causes have been looked at
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fold_consequences(model, report, Budget(seconds=600, stages=stage).begun())
    found = consequences(report.findings)
    assert found["callback-deadlock"] == ["NoteLevel"]
    assert "Log" in found["ports-not-matched"]
