"""Answers that rest on the number of goals an action works on name that, on the command line and in JSON."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.metamodel import sym
from dineros.metamodel.elements import find
from dineros.metamodel.files import save
from tests.cli.conftest import Run
from tests.support.ros2_systems.hasty_clients import hasty

ASSUMES = "action /deliver works on at most 2 goals at once"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "hasty.sym.xmi"
    model, _ = hasty()
    find(model, "robot", sym.NodeNet).execution = "callbacks"
    find(model, "Deliver", sym.CallbackPage).awaits = True
    save(model, path)
    return path


def test_a_check_says_under_which_assumption_something_is_proved(run: Run, file: Path) -> None:
    shown = run("check", file, "-v")
    assert f"the answers assume that {ASSUMES}" in shown.stdout
    assert "proved under an assumption: no deadlock" in shown.stderr
    told = json.loads(run("check", file, "--json").stdout)
    assert told["proved"] == [] and "no deadlock" in told["assumed"]


@pytest.mark.parametrize(
    ("asked", "is_named"),
    [
        (("verify", "--ctl", "EF (Delivery.goals.Load >= 2)"), False),
        (("verify", "--ctl", "AG (Delivered0 >= 0)"), True),
        (("verify", "--ctl", "AG !deadlock"), True),
        (("find", "--marking", "Delivery.goals.Load >= 2"), False),
        (("find", "--marking", "deadlock"), True),
    ],
)
def test_answers_that_more_runs_could_change_name_the_assumption(
    run: Run, file: Path, asked: tuple[str, ...], is_named: bool
) -> None:
    command, *options = asked
    assert (f"assumes: {ASSUMES}" in run(command, file, *options).stdout) is is_named
    told = json.loads(run(command, file, *options, "--json").stdout)
    assert told["status"] != "unknown"
    assert (ASSUMES in told.get("assumes", [])) is is_named
