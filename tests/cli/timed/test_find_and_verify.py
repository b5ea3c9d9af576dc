"""`find --time` and `verify --time`: answers about the net with its times, with a schedule."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.metamodel import pn, sym
from dineros.metamodel.elements import find
from dineros.metamodel.files import save
from tests.cli.conftest import Run
from tests.support.systems.talker import talker

RACE = """net race
tr fast [1,2] p -> a
tr slow [3,4] p -> b
pl p (1)
"""


@pytest.fixture
def race(tmp_path: Path) -> Path:
    path = tmp_path / "race.net"
    path.write_text(RACE)
    return path


@pytest.mark.parametrize(
    ("question", "without", "with_time"),
    [
        (("find", "--marking", "b >= 1"), 0, 1),
        (("find", "--enabled", "slow"), 0, 1),
        (("find", "--marking", "a >= 1"), 0, 0),
        (("find", "--marking", "deadlock & a >= 1"), 0, 0),
        (("verify", "--ltl", "G (b == 0)"), 1, 0),
        (("verify", "--ltl", "F fired(fast)"), 1, 0),
        (("verify", "--ctl", "AF (a >= 1)"), 1, 0),
        (("verify", "--ctl", "EF (b >= 1)"), 0, 1),
    ],
)
def test_times_decide(run: Run, race: Path, question: tuple[str, ...], without: int, with_time: int) -> None:
    command, *asked = question
    assert run(command, race, *asked).exit_code == without
    result = run(command, race, *asked, "--time")
    assert result.exit_code == with_time
    assert "left out" not in result.stdout


def test_a_way_has_a_schedule(run: Run, race: Path, tmp_path: Path) -> None:
    assert "fast, at 1 (from 1 to 2)" in run("find", race, "--time", "--marking", "a >= 1").stdout
    told = json.loads(run("find", race, "--time", "--marking", "a >= 1", "--json").stdout)
    (step,) = told["witness"]["steps"]
    assert step["time"] == {"at": 1.0, "earliest": 1.0, "latest": 2.0}
    trace = tmp_path / "way.jsonl"
    assert run("find", race, "--time", "--marking", "a >= 1", "-o", trace).exit_code == 0
    assert json.loads(trace.read_text().splitlines()[1])["time"] == 1.0
    assert run("trace", trace).stdout.split() == ["1", "fast,", "at", "1", "(from", "1", "to", "2)"]
    untimed = json.loads(run("find", race, "--marking", "a >= 1", "--json").stdout)
    assert "time" not in untimed["witness"]["steps"][0]


def test_bounds_of_times(run: Run, race: Path) -> None:
    formula = "G (p >= 1 -> F[<=2] fired(fast))"
    assert run("verify", race, "--time", "--ltl", formula).exit_code == 0
    result = run("verify", race, "--time", "--ltl", formula.replace("<=2", "<2"))
    assert result.exit_code == 1
    assert "(fired(fast) does not come in [<2], counted from 0)" in result.stdout
    result = run("verify", race, "--ltl", formula)
    assert result.exit_code == 2
    assert "--time takes firing intervals into account" in result.stderr
    result = run("verify", race, "--time", "--ltl", "F[<=2] F[<=1] (a >= 1)")
    assert (result.exit_code, len(result.stderr.splitlines())) == (2, 1)


def test_stored_bounds_of_times(run: Run, tmp_path: Path) -> None:
    net = talker()
    find(net, "Say", sym.Transition).interval = pn.TimeInterval(earliest=2, latest=3)
    net.properties.append(sym.Property(id="soon", text="never Noted >= 1 within 1.9"))
    net.properties.append(sym.Property(id="late", text="never Noted >= 1 within 2"))
    path = tmp_path / "talker.sym.xmi"
    save(net, path)
    assert run("verify", path, "soon", "--time").exit_code == 0
    result = run("verify", path, "late", "--time")
    assert result.exit_code == 1
    assert "Say, at 2" in result.stdout
    assert run("verify", path, "late").exit_code == 2
    checked = run("check", path, "--time", "-v")
    assert "property soon holds" in checked.stderr
    assert "property late does not hold: never Noted >= 1 within 2" in checked.stdout
    assert "whether property late holds: it bounds times, which requires --time" in run("check", path).stdout


def test_the_quickest_way(run: Run, race: Path) -> None:
    result = run("find", race, "--time", "--quickest", "--enabled", "fast")
    assert result.exit_code == 0
    assert "reachable: enabled(fast) (the quickest firing sequence takes 1)" in result.stdout
    told = json.loads(run("find", race, "--time", "--quickest", "--marking", "a >= 1", "--json").stdout)
    assert told["quickest"] == {"time": "1", "attained": True, "least": True}
    assert run("find", race, "--time", "--quickest", "--marking", "b >= 1").exit_code == 1
    assert run("find", race, "--quickest", "--marking", "a >= 1").exit_code == 2


@pytest.mark.parametrize(
    "options",
    [
        ("find", "--marking", "a >= 1", "--quickest", "--certificate", "c.json"),
        ("find", "--marking", "a >= 1", "--quickest", "--confirm"),
        ("find", "--marking", "a >= 1", "--engine", "tina"),
        ("verify", "--ltl", "F (a >= 1)", "--fair", "all"),
    ],
)
def test_what_time_does_not_go_with(run: Run, race: Path, options: tuple[str, ...]) -> None:
    command, *asked = options
    result = run(command, race, *asked, "--time")
    assert (result.exit_code, len(result.stderr.splitlines())) == (2, 1)


def test_answers_are_confirmed(run: Run, race: Path) -> None:
    result = run("find", race, "--time", "--confirm", "--marking", "b >= 1")
    assert result.exit_code == 1
    assert "confirmed by time as a counter" in result.stdout
    result = run("verify", race, "--time", "--confirm", "--ltl", "F fired(fast)", "--json")
    told = json.loads(result.stdout)
    assert (told["status"], told["confirmation"]["agrees"]) == ("holds", True)
    assert told["confirmation"]["by"][0].startswith("strong state classes")


def test_a_schedule_needs_no_confirmation(run: Run, race: Path) -> None:
    result = run("find", race, "--time", "--confirm", "--marking", "a >= 1", "--json")
    assert result.exit_code == 0
    assert json.loads(result.stdout)["confirmation"] is None


def test_ctl_has_one_engine(run: Run, race: Path) -> None:
    result = run("verify", race, "--time", "--confirm", "--ctl", "AF (a >= 1)")
    assert result.exit_code == 0
    assert "not confirmed: only atomic classes determine the next steps" in result.stderr
