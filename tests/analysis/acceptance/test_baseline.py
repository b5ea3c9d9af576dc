"""What a baseline knows: by rule, elements and severity, from each format that it can be read from."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.analysis.acceptance.baseline import Baseline, to_baseline
from dineros.analysis.checks.check import FAULTS
from dineros.analysis.witnesses import report_formats
from dineros.analysis.witnesses.findings import SEVERITIES, Finding, Report, Suppressed
from dineros.metamodel.errors import DinerosError
from tests.support.systems.talker import talker

to_sarif = partial(report_formats.to_sarif, faults=FAULTS)

OVERFLOW = Finding("queue-overflow", "error", ("Chatter", "Heard"), "it can overflow")
DEADLOCK = Finding("deadlock", "warning", ("Listen", "made.by.flattening"), "it can stop")
WHOLE = Finding("not-live", "note", ("greeting",), "not live")
ACCEPTED = Suppressed(Finding("unbounded", "error", ("Said",), "it grows"), "Said", "until the next release")

FINDINGS = st.lists(
    st.builds(
        Finding,
        st.sampled_from(["deadlock", "unbounded"]),
        st.sampled_from(sorted(SEVERITIES)),
        st.lists(st.sampled_from("ab"), max_size=2).map(tuple),
        st.sampled_from(["one", "two"]),
    ),
    max_size=5,
)


def read(path: Path, content: object) -> Baseline:
    path.write_text(json.dumps(content))
    return Baseline.read(path)


@pytest.mark.parametrize("format", ["baseline", "json", "sarif"])
def test_each_format_knows_what_was_found_and_not_what_was_suppressed(tmp_path: Path, format: str) -> None:
    report = Report([OVERFLOW, DEADLOCK, WHOLE], suppressed=[ACCEPTED])
    content = {
        "baseline": to_baseline(report),
        "json": report.to_dict("old name.xmi"),
        "sarif": to_sarif(report, talker(), Path("old name.xmi")),
    }[format]
    known = read(tmp_path / "known.json", content)
    later = Report([ACCEPTED.finding, WHOLE, DEADLOCK, OVERFLOW])
    after = known.apply(later)
    assert after.findings == [ACCEPTED.finding]
    assert set(after.known) == {WHOLE, DEADLOCK, OVERFLOW}
    assert (after.gone, after.has_baseline) == (0, True)


@pytest.mark.parametrize("format", ["json", "sarif"])
def test_what_was_known_stays_known(tmp_path: Path, format: str) -> None:
    report = Baseline([("queue-overflow", "error", ["Heard", "Chatter"], "")]).apply(
        Report([OVERFLOW, DEADLOCK])
    )
    assert (report.findings, report.known) == ([DEADLOCK], [OVERFLOW])
    content = report.to_dict("m") if format == "json" else to_sarif(report, talker(), Path("m"))
    after = read(tmp_path / "known.json", content).apply(Report([OVERFLOW, DEADLOCK]))
    assert after.findings == []


@pytest.mark.parametrize(
    ("known", "is_new"),
    [
        (("deadlock", "warning", ["made.by.flattening", "Listen"]), False),
        (("deadlock", "error", ["Listen", "made.by.flattening"]), False),
        (("deadlock", "note", ["Listen", "made.by.flattening"]), True),
        (("deadlock", "warning", ["Listen"]), True),
        (("unbounded", "warning", ["Listen", "made.by.flattening"]), True),
    ],
)
def test_rule_elements_and_severity_decide(known: tuple[str, str, list[str]], is_new: bool) -> None:
    after = Baseline([(*known, "")]).apply(Report([DEADLOCK]))
    assert (after.findings == [DEADLOCK]) == is_new
    assert after.gone == int(is_new and known[1] != "note")


@given(FINDINGS, FINDINGS)
def test_one_known_finding_stands_for_one(before: list[Finding], after: list[Finding]) -> None:
    """As many are known as can be matched one to one with no less severe ones of the same kind."""
    report = Baseline((each.rule, each.severity, each.elements, "") for each in before).apply(
        Report(list(after))
    )
    assert sorted(map(id, [*report.findings, *report.known])) == sorted(map(id, after))
    assert report.findings == [each for each in after if any(each is one for one in report.findings)]

    def kind(finding: Finding) -> tuple[str, list[str]]:
        return finding.rule, sorted(finding.elements)

    for one in after:
        mine = sorted(SEVERITIES[each.severity] for each in before if kind(each) == kind(one))
        wanted = sorted(
            (SEVERITIES[each.severity] for each in after if kind(each) == kind(one)), reverse=True
        )
        matched = 0
        for rank in wanted:  # the most severe first takes the most severe that is left
            if mine and mine[-1] >= rank:
                mine.pop()
                matched += 1
        assert sum(kind(each) == kind(one) for each in report.known) == matched
    left = [each.severity for each in before]
    assert report.gone <= len(left) - left.count("note")


@given(FINDINGS)
def test_a_report_is_its_own_baseline(findings: list[Finding]) -> None:
    after = Baseline.of(to_baseline(Report(list(findings)))).apply(Report(list(findings)))
    assert (after.findings, after.gone) == ([], 0)


@pytest.mark.parametrize(
    "content",
    [
        [],
        {},
        7,
        "findings",
        {"findings": 3},
        {"findings": [{"rule": "deadlock"}]},
        {"findings": [{"rule": 1, "severity": "error", "elements": []}]},
        {"findings": [{"rule": "deadlock", "severity": "fatal", "elements": []}]},
        {"findings": [{"rule": "deadlock", "severity": "error", "elements": [1]}]},
        {"findings": [{"rule": "deadlock", "severity": [], "elements": []}]},
        {"runs": [{"results": [{"ruleId": "deadlock", "level": "error", "locations": [7]}]}]},
        {"runs": [{"results": [{"ruleId": "deadlock", "level": "none", "locations": []}]}]},
        {"runs": 3},
    ],
)
def test_other_files_are_refused_in_one_line(tmp_path: Path, content: object) -> None:
    with pytest.raises(DinerosError, match="is not a baseline") as caught:
        read(tmp_path / "other.json", content)
    assert "other.json" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("format", ["baseline", "json", "sarif"])
def test_a_property_with_another_text_is_another_question(tmp_path: Path, format: str) -> None:
    """Spaces do not matter; the name of the property alone does not make it known."""
    found = Finding("property-violated", "error", ("Few",), "Few does not hold", question="always A  <= 2")
    report = Report([found])
    content = {
        "baseline": to_baseline(report),
        "json": report.to_dict("m.xmi"),
        "sarif": to_sarif(report, talker(), Path("m.xmi")),
    }[format]
    known = read(tmp_path / "known.json", content)
    same = replace(found, question="always A <= 2", message="reworded")
    changed = replace(found, question="always A <= 3")
    assert known.apply(Report([same])).known == [same]
    after = known.apply(Report([changed]))
    assert (after.findings, after.known, after.gone) == ([changed], [], 1)


def test_files_without_texts_of_properties_know_a_property_by_its_name() -> None:
    found = Finding("property-violated", "error", ("Few",), "Few does not hold", question="always A <= 2")
    assert Baseline([("property-violated", "error", ["Few"], "")]).apply(Report([found])).findings == []
