"""The mobile robot of `examples/mobile_robot` through the whole chain: check, generate, run, be killed."""

from __future__ import annotations

import os
import runpy
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from benchmarks.endurance import stops_and_kills
from benchmarks.endurance.applications import APPLICATIONS
from dineros.analysis.checks.check import check
from dineros.cli.main import main
from dineros.generators import Options
from dineros.generators import check as compare
from dineros.metamodel import sym
from dineros.metamodel.constraints import validate
from dineros.metamodel.files import save
from tests.support.on_ros import on_ros
from tests.support.type_checker import strict_mypy

HOME = Path(__file__).resolve().parents[2] / "examples/mobile_robot"
MODEL, EARLIER = HOME / "mobile_robot.sym.xmi", HOME / "mobile_robot_earlier.sym.xmi"
ROBOT = APPLICATIONS["mobile_robot"]
PACKAGES = sorted(path.stem for path in (HOME / "handlers").glob("*.py"))


def command(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def built(mistake: str = "") -> sym.SystemModel:
    model = runpy.run_path(str(HOME / "build.py"))["build"](mistake)
    assert isinstance(model, sym.SystemModel)
    return model


def test_the_files_are_what_the_script_builds(tmp_path: Path) -> None:
    for path, mistake in ((MODEL, ""), (EARLIER, "asks once")):
        save(built(mistake), tmp_path / path.name)
        assert (tmp_path / path.name).read_bytes() == path.read_bytes()


def test_what_validate_says_is_meant() -> None:
    """Sensors are volatile, and a handler makes the feedback."""
    found = sorted((each.constraint, getattr(each.element, "id", "")) for each in validate(built()))
    assert found == [
        ("topic-survives-restarts", "Images"),
        ("topic-survives-restarts", "Markers"),
        ("topic-survives-restarts", "Scans"),
        ("type-change-has-handler", "TProceed"),
    ]


def test_all_that_matters_is_proved() -> None:
    report = check(built())
    assert report.unknown == []
    assert {finding.rule: finding.severity for finding in report.findings} == {
        "sample-lost": "note",
        "published-while-inactive": "warning",
        "cancel-too-late": "note",
        "not-live": "note",
        "not-reversible": "note",
    }
    for name in runpy.run_path(str(HOME / "build.py"))["PROPERTIES"]:
        assert any(said.startswith(f"property {name} holds") for said in report.proved)
    assert "no deadlock" in report.proved
    assert "every goal that was sent can be over" in report.proved


def test_in_the_earlier_version_a_canceled_goal_may_never_end() -> None:
    result = command("verify", EARLIER, "GoalsEnd")
    assert result.exit_code == 1
    steps = result.stdout.splitlines()
    gone = next(number for number, step in enumerate(steps) if "asks to cancel, and has no goal" in step)
    assert steps[gone - 1].endswith("TRecall")
    assert "sends a goal" in steps[gone + 1]


def test_a_robot_that_docks_at_once_drives_at_the_dock(tmp_path: Path) -> None:
    save(built("docks at once"), tmp_path / "hasty.sym.xmi")
    result = command("verify", tmp_path / "hasty.sym.xmi", "NeverDrivesAtTheDock")
    assert (result.exit_code, "violated" in result.stdout) == (1, True)


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the robot's workspace, with the handlers that its developers wrote."""
    folder = tmp_path_factory.mktemp("robot") / "ws"
    ROBOT.workspace(folder, [])
    return folder


def test_the_handlers_fit_the_workspace(workspace: Path) -> None:
    assert compare(built(), workspace, Options(source=MODEL.name)).changes == ()
    run = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:xdist"]
        + [f"src/{package}" for package in PACKAGES],
        cwd=workspace,
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stdout


def test_the_handlers_pass_mypy(workspace: Path) -> None:
    packages = [f"src/{package}/{package}" for package in PACKAGES]
    assert strict_mypy(workspace, *packages).startswith("Success: no issues found")


def test_it_runs_on_ros_and_loses_nothing_when_it_is_killed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every goal is over once, every waypoint is closed once, and the run conforms: `stress` says so."""
    monkeypatch.setattr(stops_and_kills, "KINDS", ("SIGKILL", "node SIGKILL"))
    with on_ros() as domain:
        lines: list[dict[str, Any]] = list(
            stops_and_kills.stress(ROBOT, tmp_path, 2, 5, 4, domain, longest=3.0)
        )
    shutil.rmtree(tmp_path / "workspace")
    assert sum("stop" in line for line in lines) == 2
    assert sum(line.get("goal", 0) for line in lines) >= 4
    assert sum(line.get("finish", 0) for line in lines) >= 4
