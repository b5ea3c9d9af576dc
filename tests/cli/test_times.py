"""Nets with firing intervals: each answer says that times are left out, and whether it holds with them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from lxml import etree

from tests.cli.conftest import Run

TIMED = "pl p (1)\npl r (1)\ntr t [1,2] p -> q\ntr u [5,6] p r -> late\n"
LEFT_OUT = "firing intervals are ignored (2 transitions, such as t [1,2])"
NEED_NOT = "may not hold"
HOLDS = "also holds with times"


@pytest.fixture
def timed(tmp_path: Path) -> Path:
    path = tmp_path / "timed.net"
    path.write_text(TIMED, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("arguments", "said", "holds"),
    [
        (("find", "--marking", "late >= 1"), NEED_NOT, False),
        (("find", "--enabled", "u"), NEED_NOT, False),
        (("find", "--marking", "q >= 2"), HOLDS, True),
        (("verify", "--ltl", "G (q <= 1)"), HOLDS, True),
        (("verify", "--ltl", "G (late = 0)"), NEED_NOT, False),
        (("verify", "--ctl", "EF (late >= 1)"), NEED_NOT, False),
        (("verify", "--ctl", "AG (EF deadlock)"), NEED_NOT, False),
        (("verify", "--ctl", "EF (q >= 2)"), HOLDS, True),
        (("statespace",), "may be fewer markings", False),
        (("check",), "boundedness and the absence of deadlocks also hold with times", False),
    ],
)
def test_each_answer_says_whether_it_holds_with_times(
    run: Run, timed: Path, arguments: tuple[str, ...], said: str, holds: bool
) -> None:
    command, *options = arguments
    result = run(command, timed, *options)
    (note,) = (line for line in result.stdout.splitlines() if LEFT_OUT in line)
    assert note.startswith("note: ") and said in note
    answer = json.loads(run(command, timed, *options, "--json").stdout)
    assert answer["times"] == {"left_out": LEFT_OUT, "transitions": 2, "holds_with_times": holds}


def test_properties_are_told_apart(run: Run, timed: Path) -> None:
    asked = (
        "--properties",
        "OneSafe",
        "--properties",
        "ReachabilityDeadlock",
        "--properties",
        "QuasiLiveness",
    )
    result = run("verify", timed, *asked)
    (note,) = (line for line in result.stdout.splitlines() if LEFT_OUT in line)
    assert (
        "also holds with times: OneSafe; may not hold with times: ReachabilityDeadlock, QuasiLiveness" in note
    )
    rows = json.loads(run("verify", timed, *asked, "--json").stdout)["properties"]
    assert [row["times"]["holds_with_times"] for row in rows] == [True, False, False]


def test_sarif_has_a_notification(run: Run, timed: Path) -> None:
    log = json.loads(run("check", timed, "--format", "sarif").stdout)
    texts = [
        each["message"]["text"] for each in log["runs"][0]["invocations"][0]["toolExecutionNotifications"]
    ]
    assert any(LEFT_OUT in text for text in texts)


@pytest.mark.parametrize(("latest", "said"), [("2", "boundedness"), ("w", "so all answers also hold")])
def test_reports_for_people_and_for_ci_say_so(run: Run, timed: Path, latest: str, said: str) -> None:
    text = TIMED if latest == "2" else TIMED.replace(",2]", ",w[").replace(",6]", ",w[")
    timed.write_text(text, encoding="utf-8")
    suite = etree.fromstring(run("check", timed, "--format", "junit").stdout.encode())[0]
    (noted,) = suite.iterfind("properties/property[@name='times']")
    page = timed.with_name("report.html")
    run("check", timed, "-o", page)
    for shown in (noted.get("value") or "", page.read_text(encoding="utf-8")):
        assert "firing intervals are ignored (2 transitions" in shown and said in shown


def test_reports_of_other_nets_say_nothing_of_times(run: Run, timed: Path) -> None:
    timed.write_text(TIMED.replace("[1,2] ", "").replace("[5,6] ", ""), encoding="utf-8")
    page = timed.with_name("report.html")
    assert "intervals" not in run("check", timed, "--format", "junit").stdout
    run("check", timed, "-o", page)
    assert "intervals" not in page.read_text(encoding="utf-8")


def test_a_sweep_says_what_its_figures_mean_with_times(run: Run, timed: Path) -> None:
    asked = ("sweep", timed, "--vary", "p.tokens=1..2", "-o", timed.with_name("points.csv"))
    (note,) = (line for line in run(*asked).stdout.splitlines() if LEFT_OUT in line)
    assert note.startswith("note: ") and "may be fewer markings" in note
    answer = json.loads(run(*asked, "--json").stdout)
    assert answer["times"] == {"left_out": LEFT_OUT, "transitions": 2, "holds_with_times": False}


def test_without_a_latest_time_all_answers_hold(run: Run, timed: Path) -> None:
    timed.write_text(TIMED.replace(",2]", ",w[").replace(",6]", ",w["), encoding="utf-8")
    assert HOLDS in run("find", timed, "--marking", "late >= 1").stdout
    assert "no interval has a latest time" in run("check", timed).stdout
    assert "no interval has a latest time" in run("statespace", timed).stdout


def test_a_net_without_intervals_is_answered_as_ever(run: Run, timed: Path) -> None:
    timed.write_text(TIMED.replace("[1,2] ", "").replace("[5,6] ", ""), encoding="utf-8")
    assert "times" not in run("find", timed, "--marking", "late >= 1").stdout
    assert "times" not in json.loads(run("find", timed, "--marking", "late >= 1", "--json").stdout)


def test_priorities_are_refused_not_ignored(run: Run, timed: Path) -> None:
    timed.write_text("pl p (1)\ntr t p -> q\ntr u p -> r\npr t > u\n", encoding="utf-8")
    for command in (
        ("find", "--marking", "r >= 1"),
        ("check",),
        ("statespace",),
        ("verify", "--ltl", "F (r >= 1)"),
    ):
        result = run(command[0], timed, *command[1:])
        assert result.exit_code == 2
        assert "transition t has priority over others, which only questions with times know" in result.stderr
        assert "ask with --time" in result.stderr


def test_priorities_without_intervals_are_checked_with_times(run: Run, timed: Path) -> None:
    timed.write_text("pl p (1)\ntr t p -> q\ntr u p -> r\npr t > u\n", encoding="utf-8")
    result = run("check", timed, "--time")
    assert (result.exit_code, result.stderr) == (1, "")
    assert "u gets its tokens, but never fires" in result.stdout
    assert "have priority over it" in result.stdout
    assert "note: priorities are taken into account (no transition has a firing interval)" in result.stdout
    assert "t gets its tokens" not in result.stdout
    assert run("find", timed, "--time", "--marking", "r >= 1").exit_code == 1
