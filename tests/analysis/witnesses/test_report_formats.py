"""Reports as SARIF and JUnit XML."""

from __future__ import annotations

import json
import re
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from lxml import etree

from dineros.analysis.checks.check import FAULTS
from dineros.analysis.model.times import UsedTimes
from dineros.analysis.witnesses import report_formats
from dineros.analysis.witnesses.findings import Finding, Report, Unknown
from dineros.analysis.witnesses.report_formats import to_junit
from dineros.analysis.witnesses.witness import Step, Witness
from dineros.metamodel import pn
from dineros.metamodel.files import load, save
from tests.support.systems.talker import talker

to_sarif = partial(report_formats.to_sarif, faults=FAULTS)

STEPS = (
    Step("Speak", "Speak fires", {"Words": -1, "Said": 1}),
    Step("drop", "a message is lost", {"Said": -1}),
)
OVERFLOW = Finding("queue-overflow", "error", ("Chatter", "Said"), "the queue can overflow", Witness(STEPS))
UNBOUNDED = Finding("unbounded", "error", ("some place",), "tokens grow", Witness(STEPS, loop=1))
UNUSED = Finding("unused-topic", "warning", ("Chatter",), "topic chatter never carries a message")
FAIRNESS = Unknown("fairness", "memory ran out")
LIVENESS = Unknown("liveness", "too much work", "ask for it", may_be_fault=False)
NOTE = Finding("queue-overflow", "note", (), "only a note: <&\x00>")


def report() -> Report:
    return Report([OVERFLOW, UNBOUNDED, UNUSED, NOTE], ["no deadlock"], [FAIRNESS, LIVENESS])


def test_the_note_about_times_names_an_engine_only_if_one_has_answered() -> None:
    times = UsedTimes(1, "lidar.on_timer [0,0]", "1/10")
    assert Report(times=times).text_of_times(None) == str(times)
    assert (
        Report(times=times, by="state classes").text_of_times(None) == f"{times}; answered by: state classes"
    )


@pytest.fixture
def model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[pn.Net, Path]:
    """Return a model as it is read from a file, named as on a command line."""
    monkeypatch.chdir(tmp_path)
    path = Path("my models") / "greeting.sym.xmi"
    path.parent.mkdir()
    save(talker(), path)
    return load(path), path


def line_of(path: Path, id: str) -> int:
    """Return the line of a file in which an element begins."""
    lines = path.read_text(encoding="utf-8").splitlines()
    (found,) = [
        number for number, line in enumerate(lines, 1) if f' xmi:id="{id}"' in line or f' id="{id}"' in line
    ]
    return found


def check_location(location: dict[str, Any]) -> None:
    """Check what SARIF 2.1.0 (3.28 to 3.33) requires of a location."""
    physical = location["physicalLocation"]
    uri = physical["artifactLocation"]["uri"]
    assert uri
    assert " " not in uri
    if "region" in physical:
        assert physical["region"]["startLine"] >= 1
        assert physical["region"].get("startColumn", 1) >= 1
    for logical in location.get("logicalLocations", []):
        assert logical["name"]
        assert set(logical) <= {"name", "fullyQualifiedName", "kind"}


def check_sarif(log: dict[str, Any]) -> None:
    """Check what SARIF 2.1.0 requires, where the log makes use of it."""
    assert log["version"] == "2.1.0"
    assert log["$schema"].endswith("sarif-schema-2.1.0.json")
    assert json.loads(json.dumps(log)) == log
    for run in log["runs"]:
        driver = run["tool"]["driver"]
        assert driver["name"]
        ids = [rule["id"] for rule in driver["rules"]]
        assert len(ids) == len(set(ids))
        for rule in driver["rules"]:
            assert rule["shortDescription"]["text"].endswith(".")
            assert rule["defaultConfiguration"]["level"] in ("none", "note", "warning", "error")
        for invocation in run["invocations"]:
            assert invocation["executionSuccessful"] is True
            assert all(one["message"]["text"] for one in invocation["toolExecutionNotifications"])
        for result in run["results"]:
            assert ids[result["ruleIndex"]] == result["ruleId"]
            assert result["level"] in ("none", "note", "warning", "error")
            assert result["message"]["text"]
            assert all(isinstance(value, str) for value in result["partialFingerprints"].values())
            for location in [*result["locations"], *result.get("relatedLocations", [])]:
                check_location(location)
            for flow in result.get("codeFlows", []):
                for thread in flow["threadFlows"]:
                    assert thread["locations"]
                    for step in thread["locations"]:
                        check_location(step["location"])
                        assert step["location"]["message"]["text"]
                        assert step["importance"] in ("important", "essential", "unimportant")
                        assert all(state["text"] for state in step["state"].values())


def test_the_log_describes_each_fault_as_its_question_does(model: tuple[pn.Net, Path]) -> None:
    found = [Finding(fault.rule, fault.severity, (), "found") for fault in FAULTS.values()]
    (run,) = to_sarif(Report(found), *model)["runs"]
    rules = {rule["id"]: rule["shortDescription"]["text"] for rule in run["tool"]["driver"]["rules"]}
    assert rules == {fault.rule: fault.meaning for fault in FAULTS.values()}
    assert {"not-live", "not-reversible", "no-home-marking"} <= rules.keys()


def test_the_guide_lists_every_fault() -> None:
    page = (Path(__file__).resolve().parents[3] / "docs/analysis.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (`[a-z`, -]+`) \| (error|warning|note) \|", page, flags=re.MULTILINE)
    listed = {rule: severity for rules, severity in rows for rule in re.findall("`([^`]+)`", rules)}
    assert listed == {fault.rule: fault.severity for fault in FAULTS.values()}


def results(model: pn.Net, path: Path) -> list[dict[str, Any]]:
    log = to_sarif(report(), model, path)
    check_sarif(log)
    found: list[dict[str, Any]] = log["runs"][0]["results"]
    return found


def test_a_sarif_log_has_what_the_standard_requires(model: tuple[pn.Net, Path]) -> None:
    log = to_sarif(report(), *model)
    check_sarif(log)
    (run,) = log["runs"]
    rules = [rule["id"] for rule in run["tool"]["driver"]["rules"]]
    assert rules == ["queue-overflow", "unbounded", "unused-topic"]
    assert run["artifacts"] == [{"location": {"uri": "my%20models/greeting.sym.xmi"}}]
    notifications = run["invocations"][0]["toolExecutionNotifications"]
    assert [(unknown["level"], unknown["message"]["text"]) for unknown in notifications] == [
        ("warning", "unknown: fairness: memory ran out"),
        ("note", "unknown: liveness: too much work (ask for it)"),
    ]


def test_an_empty_report_is_a_log_as_well(model: tuple[pn.Net, Path]) -> None:
    log = to_sarif(Report(), *model)
    check_sarif(log)
    assert log["runs"][0]["results"] == []


def test_findings_stand_at_the_lines_of_their_elements(model: tuple[pn.Net, Path]) -> None:
    overflow, unbounded, unused, _ = results(*model)
    path = model[1]
    region = overflow["locations"][0]["physicalLocation"]["region"]
    assert region["startLine"] == unused["locations"][0]["physicalLocation"]["region"]["startLine"]
    assert region["startLine"] == line_of(path, "Chatter")
    assert [logical["name"] for logical in overflow["locations"][0]["logicalLocations"]] == [
        "Chatter",
        "Said",
    ]
    (related,) = overflow["relatedLocations"]
    assert related["physicalLocation"]["region"]["startLine"] == line_of(path, "Said")
    assert related["logicalLocations"][0]["kind"] == "Place"
    assert "region" not in unbounded["locations"][0]["physicalLocation"]


def test_witnesses_are_code_flows(model: tuple[pn.Net, Path]) -> None:
    overflow, unbounded, unused, _ = results(*model)
    assert "codeFlows" not in unused
    steps = overflow["codeFlows"][0]["threadFlows"][0]["locations"]
    assert [step["location"]["message"]["text"] for step in steps] == ["Speak fires", "a message is lost"]
    assert steps[0]["state"] == {"Words": {"text": "-1"}, "Said": {"text": "+1"}}
    assert [step["nestingLevel"] for step in steps] == [0, 0]
    steps = unbounded["codeFlows"][0]["threadFlows"][0]["locations"]
    assert [step["location"]["message"]["text"] for step in steps] == [
        "Speak fires",
        "forever: a message is lost",
    ]
    assert [step["nestingLevel"] for step in steps] == [0, 1]


def test_fingerprints_stay_when_lines_move(model: tuple[pn.Net, Path]) -> None:
    made = to_sarif(report(), talker(), model[1])["runs"][0]["results"]
    assert "region" not in made[0]["locations"][0]["physicalLocation"]  # Python made it: no lines
    read = results(*model)
    assert [one["partialFingerprints"] for one in made] == [one["partialFingerprints"] for one in read]
    assert len({json.dumps(one["partialFingerprints"]) for one in read}) == len(read)


def test_an_absolute_path_is_a_file_uri(model: tuple[pn.Net, Path]) -> None:
    path = model[1].resolve()
    log = to_sarif(report(), load(path), path)
    uri = log["runs"][0]["results"][0]["locations"][0]["physicalLocation"]["artifactLocation"]["uri"]
    assert uri == path.as_uri()


def test_junit_has_a_case_for_each_question() -> None:
    root = etree.fromstring(to_junit(report(), talker(), Path("greeting.sym.xmi")))
    assert root.tag == "testsuites"
    (suite,) = root
    cases = suite.findall("testcase")
    for element in (root, suite):
        assert {name: element.get(name) for name in ("tests", "failures", "errors", "skipped")} == {
            "tests": str(len(cases)),
            "failures": str(len(suite.findall("testcase/failure"))),
            "errors": "0",
            "skipped": str(len(suite.findall("testcase/skipped"))),
        }
    assert [[child.tag for child in case] for case in cases] == [
        ["failure"],
        ["failure"],
        ["failure"],
        ["system-out"],
        [],
        ["skipped"],
        ["skipped"],
    ]
    assert [(case.get("classname"), case.get("name")) for case in cases[3:]] == [
        ("dineros.queue-overflow", r"only a note: <&\x00>"),
        ("dineros.proved", "no deadlock"),
        ("dineros.unknown", "fairness"),
        ("dineros.unknown", "liveness"),
    ]
    assert [skipped.get("message") for skipped in suite.findall("testcase/skipped")] == [
        "fairness: memory ran out",
        "liveness: too much work (ask for it)",
    ]
    assert {case.get("file") for case in cases} == {"greeting.sym.xmi"}


def test_junit_failures_tell_the_steps() -> None:
    root = etree.fromstring(to_junit(report(), talker(), Path("greeting.sym.xmi")))
    failures = root.findall(".//failure")
    assert failures[0].get("message") == "the queue can overflow"
    assert failures[0].text == (
        "the queue can overflow\n"
        "elements: Chatter, Said\n"
        "1. Speak fires (Words -1, Said +1)\n"
        "2. a message is lost (Said -1)"
    )
    assert failures[1].text is not None
    assert failures[1].text.endswith("2. forever: a message is lost (Said -1)")
    assert [failure.get("type") for failure in failures] == ["error", "error", "warning"]


def test_an_empty_report_is_a_suite_without_cases() -> None:
    root = etree.fromstring(to_junit(Report(), talker(), Path("greeting.sym.xmi")))
    assert [suite.get("tests") for suite in root] == ["0"]
