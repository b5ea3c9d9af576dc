"""`check --time`: every format says that times are taken into account, and findings have schedules."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from lxml import etree

from tests.cli.conftest import Run
from tests.cli.timed.test_find_and_verify import RACE


@pytest.fixture
def race(tmp_path: Path) -> Path:
    path = tmp_path / "race.net"
    path.write_text(RACE)
    return path


USED = "firing intervals are taken into account (2 transitions, such as fast [1,2], unit 1)"


def test_text(run: Run, race: Path) -> None:
    result = run("check", race, "--time", "--witnesses")
    assert result.exit_code == 1
    assert "transition slow gets its tokens, but never fires" in result.stdout
    assert "[never-in-time]" in result.stdout and "[dead-transition]" not in result.stdout
    assert "fast, at 1 (from 1 to 2)" in result.stdout
    assert f"note: {USED}; answered by: state classes" in result.stdout
    assert "left out" not in result.stdout
    assert "never fires" not in run("check", race).stdout


def test_json(run: Run, race: Path) -> None:
    told = json.loads(run("check", race, "--time", "--json").stdout)
    assert told["times"]["taken_into_account"] == USED
    assert (told["times"]["transitions"], told["times"]["unit"]) == (2, "1")
    assert "state classes" in told["times"]["engine"]
    (end,) = [each for each in told["findings"] if each["rule"] == "deadlock"]
    assert end["witness"]["steps"][0]["time"] == {"at": 1.0, "earliest": 1.0, "latest": 2.0}


def test_sarif(run: Run, race: Path) -> None:
    (log,) = json.loads(run("check", race, "--time", "--format", "sarif").stdout)["runs"]
    (note,) = log["invocations"][0]["toolExecutionNotifications"]
    assert note["message"]["text"].startswith(USED)
    rules = {rule["id"]: rule["shortDescription"]["text"] for rule in log["tool"]["driver"]["rules"]}
    assert rules["never-in-time"].startswith("A transition gets its tokens, but never fires")
    flows = [result["codeFlows"] for result in log["results"] if result["ruleId"] == "deadlock"]
    assert "at 1 (from 1 to 2)" in json.dumps(flows)


def test_junit(run: Run, race: Path) -> None:
    root = etree.fromstring(run("check", race, "--time", "--format", "junit").stdout.encode())
    assert root.get("name") == "dineros check"
    (times,) = root.findall(".//property[@name='times']")
    assert times.get("value", "").startswith(USED)
    assert "at 1 (from 1 to 2)" in etree.tostring(root, encoding="unicode")


@pytest.mark.long
def test_page(run: Run, race: Path, tmp_path: Path) -> None:
    page = tmp_path / "report.html"
    assert run("check", race, "--time", "-o", page).exit_code == 1
    text = page.read_text()
    assert USED in text and "never-in-time" in text
    assert "the state spaces below leave them out" in text


def test_baseline(run: Run, race: Path, tmp_path: Path) -> None:
    known = tmp_path / "known.json"
    assert run("check", race, "--time", "--write-baseline", known).exit_code == 0
    assert run("check", race, "--time", "--baseline", known).exit_code == 0


def test_without_intervals_nothing_is_said_of_times(run: Run, model: Path) -> None:
    assert run("check", model, "--time").stdout == run("check", model).stdout


@pytest.mark.parametrize("option", ["--confirm", "--suggest-capacities", "--behaviour"])
def test_what_time_does_not_go_with(run: Run, race: Path, option: str) -> None:
    result = run("check", race, "--time", option)
    assert (result.exit_code, len(result.stderr.splitlines())) == (2, 1)


@pytest.mark.parametrize("interval", ["[3,2]", "[-1,2]", "[1,1000000000000000000000000000000]"])
def test_bad_intervals_are_one_line(run: Run, tmp_path: Path, interval: str) -> None:
    path = tmp_path / "bad.net"
    path.write_text(f"net bad\ntr t {interval} p -> q\ntr u [1,2] p -> q\npl p (1)\n")
    result = run("check", path, "--time")
    assert (result.exit_code, len(result.stderr.splitlines())) == (2, 1)
