"""Findings that a model accepts: which suppressions match, expire, or match nothing."""

from __future__ import annotations

from datetime import date
from pathlib import Path

import pytest

from dineros.analysis.acceptance.suppressions import Suppressions
from dineros.analysis.checks.check import FAULTS
from dineros.analysis.witnesses.findings import Finding, Report, Unknown
from dineros.metamodel import sym
from dineros.metamodel.build import suppress
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import find
from dineros.metamodel.files import load, save
from tests.support.systems.talker import talker

OVERFLOW = Finding("queue-overflow", "error", ("Chatter", "Heard"), "it can overflow")
OTHER = Finding("queue-overflow", "error", ("Chatter", "Said"), "the other one, too")
DEADLOCK = Finding("deadlock", "warning", ("Listen",), "it can stop")
TODAY = date(2026, 6, 15)


def applied(
    *places: tuple[str, str, str | None], findings: tuple[Finding, ...] = (OVERFLOW,), open: bool = False
) -> Report:
    """Return a report after suppressions: element, rule, last day."""
    model = talker()
    for element, rule, until in places:
        suppress(find(model, element), rule, f"because of {element}", until)
    report = Report(list(findings), unknown=[Unknown("fairness", "memory ran out")] if open else [])
    after = Suppressions(model, TODAY).apply(report, FAULTS)
    assert report.findings == list(findings), "the report given is not changed"
    return after


def rules(report: Report) -> list[str]:
    return [finding.rule for finding in report.findings]


@pytest.mark.parametrize("element", ["Heard", "OnChatter", "listener", "greeting"])
def test_it_holds_for_the_element_and_for_what_it_contains(element: str) -> None:
    report = applied((element, "queue-overflow", None), findings=(OVERFLOW, DEADLOCK))
    assert [(each.finding, each.element) for each in report.suppressed] == [(OVERFLOW, element)]
    assert rules(report) == ["deadlock"]


@pytest.mark.parametrize(
    ("element", "rule"), [("Said", "queue-overflow"), ("Heard", "deadlock"), ("talker", "queue-overflow")]
)
def test_it_holds_for_no_other_element_and_no_other_rule(element: str, rule: str) -> None:
    report = applied((element, rule, None))
    assert report.findings[0] is OVERFLOW
    assert report.suppressed == []
    assert rules(report) == ["queue-overflow", "suppression-unused"]


def test_a_channel_accepts_all_of_its_queues_and_a_place_only_its_own() -> None:
    both = applied(("Chatter", "queue-overflow", None), findings=(OVERFLOW, OTHER))
    assert [each.finding for each in both.suppressed] == [OVERFLOW, OTHER]
    one = applied(("Heard", "queue-overflow", None), findings=(OVERFLOW, OTHER))
    assert [each.finding for each in one.suppressed] == [OVERFLOW]
    assert one.findings == [OTHER]


@pytest.mark.parametrize(("until", "accepted"), [("2026-06-15", True), ("2026-06-14", False), (None, True)])
def test_after_its_last_day_the_finding_counts_again(until: str | None, accepted: bool) -> None:
    report = applied(("Heard", "queue-overflow", until))
    assert bool(report.suppressed) == accepted
    if not accepted:
        assert rules(report) == ["queue-overflow", "suppression-expired"]
        assert report.findings[1].severity == "note"
        assert "2026-06-14" in report.findings[1].message
        assert "because of Heard" in report.findings[1].message


def test_one_that_has_expired_does_not_hide_one_that_holds() -> None:
    report = applied(("Heard", "queue-overflow", "2020-01-01"), ("Chatter", "queue-overflow", None))
    assert rules(report) == []
    assert [each.element for each in report.suppressed] == ["Chatter"]


def test_one_without_effect_is_named_only_where_every_question_was_answered() -> None:
    unused = applied(("Said", "queue-overflow", None), findings=())
    assert rules(unused) == ["suppression-unused"]
    assert "place 'Said'" in unused.findings[0].message
    assert rules(applied(("Said", "queue-overflow", None), findings=(), open=True)) == []


def test_a_rule_that_does_not_exist_is_named_always() -> None:
    report = applied(("Said", "queue-overflw", None), findings=(), open=True)
    assert rules(report) == ["suppression-unused"]
    assert "did you mean 'queue-overflow'?" in report.findings[0].message


def test_a_property_of_the_model_can_have_one() -> None:
    model = talker()
    model.properties.append(sym.Property(id="calm", text="never Said >= 2"))
    suppress(model.properties[0], "property-violated", "the requirement changes")
    violated = Finding("property-violated", "error", ("calm",), "calm does not hold")
    report = Suppressions(model, TODAY).apply(Report([violated]), FAULTS)
    assert [each.finding for each in report.suppressed] == [violated]


@pytest.mark.parametrize("suffix", ["sym.xmi", "pnml"])
def test_every_element_keeps_its_own_through_a_file(tmp_path: Path, suffix: str) -> None:
    model = talker()
    listener = find(model, "listener", sym.NodeNet)
    group = sym.CallbackGroup(id="alone")
    listener.callbackGroups.append(group)
    find(model, "OnChatter", sym.CallbackPage).group = group
    names = ["greeting", "listener", "OnChatter", "alone", "Heard", "Listen", "Heard-Listen", "Chatter"]
    for number, name in enumerate(names):
        suppress(find(model, name), "deadlock", f"<reason> {number} & more", "2027-03-31" if number else None)
    assert [each.message for each in validate(model) if each.severity == "error"] == []
    save(model, path := tmp_path / f"model.{suffix}")
    read = load(path)
    for number, name in enumerate(names):
        (kept,) = find(read, name).suppressions
        until = "2027-03-31" if number else None
        assert (kept.rule, kept.reason, kept.until) == ("deadlock", f"<reason> {number} & more", until)
