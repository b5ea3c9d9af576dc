"""`check --time`: every format says that times are taken into account, and findings have schedules."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from lxml import etree

from dineros.metamodel import pn, sym
from dineros.metamodel.elements import find
from dineros.metamodel.files import save
from tests.cli.conftest import Run
from tests.cli.timed.test_find_and_verify import RACE
from tests.support.systems.talker import talker


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


@pytest.mark.parametrize("option", ["--suggest-capacities", "--behaviour"])
def test_what_time_does_not_go_with(run: Run, race: Path, option: str) -> None:
    result = run("check", race, "--time", option)
    assert (result.exit_code, len(result.stderr.splitlines())) == (2, 1)


@pytest.mark.parametrize("interval", ["[3,2]", "[-1,2]", "[1,1000000000000000000000000000000]"])
def test_bad_intervals_are_one_line(run: Run, tmp_path: Path, interval: str) -> None:
    path = tmp_path / "bad.net"
    path.write_text(f"net bad\ntr t {interval} p -> q\ntr u [1,2] p -> q\npl p (1)\n")
    result = run("check", path, "--time")
    assert (result.exit_code, len(result.stderr.splitlines())) == (2, 1)


def test_each_question_says_who_confirmed_it(run: Run, race: Path) -> None:
    plain, result = run("check", race, "--time"), run("check", race, "--time", "--confirm")
    assert result.exit_code == plain.exit_code == 1
    last = [line.partition(" (")[0] for line in result.stdout.splitlines()[-3:]]
    assert last == [
        "which markings are reached: confirmed by time as a counter",
        "which transitions fire: confirmed by time as a counter",
        "in which markings the net ends: confirmed by time as a counter",
    ]
    told = json.loads(run("check", race, "--time", "--confirm", "--json").stdout)
    assert sum("confirmed by time as a counter" in line for line in told["proved"]) == 3


def test_open_intervals_are_confirmed_by_strong_classes(run: Run, race: Path) -> None:
    race.write_text(RACE.replace("[1,2]", "]1,2]"))
    assert run("check", race, "--time", "--confirm").stdout.count("confirmed by strong state classes") == 3


def test_an_engine_that_is_wrong_cannot_be_missed(
    run: Run, race: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def wrong(*_: object) -> tuple[np.ndarray[tuple[int, ...], np.dtype[np.int64]], frozenset[int]]:
        return np.zeros((1, 3), dtype=np.int64), frozenset()

    monkeypatch.setattr("dineros.analysis.evidence.timed_check_confirmation.all_markings", wrong)
    result = run("check", race, "--time", "--confirm")
    assert result.exit_code == 3
    assert result.stderr.count("ERROR: ") >= 2 and "engines disagree" in result.stderr
    told = json.loads(run("check", race, "--time", "--confirm", "--json").stdout)
    assert not [line for line in told["proved"] if "confirmed" not in line]
    assert any("engines disagree" in line for line in told["unknown"])


def test_without_intervals_a_check_is_confirmed_as_ever(run: Run, model: Path) -> None:
    result = run("check", model, "--time", "--confirm")
    assert "confirmed by explicit search (" in result.stdout


def test_properties_of_branching_time(run: Run, tmp_path: Path) -> None:
    net = talker()
    find(net, "Say", sym.Transition).interval = pn.TimeInterval(earliest=1, latest=1)
    for id, text in (
        ("in", "AG (AX Noted <= 8)"),
        ("out", "AG (AX Noted <= 0)"),
        ("back", "AG EF Noted >= 2"),
    ):
        net.properties.append(sym.Property(id=id, text=text, language="ctl"))
    path = tmp_path / "talker.sym.xmi"
    save(net, path)
    result = run("check", path, "--time", "--json")
    told = json.loads(result.stdout)
    violated = {each["elements"][0] for each in told["findings"] if each["rule"] == "property-violated"}
    asked = [run("verify", path, id, "--time").exit_code for id in ("in", "out", "back")]
    assert asked == [int(id in violated) for id in ("in", "out", "back")]
    assert "out" in violated and "in" not in violated
