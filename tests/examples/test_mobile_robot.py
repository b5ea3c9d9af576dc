"""The mobile robot of `examples/mobile_robot` through the whole chain: check, generate, run, be killed."""

from __future__ import annotations

import os
import re
import runpy
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from benchmarks.endurance import stops_and_kills
from benchmarks.endurance.applications import APPLICATIONS
from dineros.analysis.answers.budget import Budget
from dineros.analysis.checks.check import check
from dineros.analysis.requirements.asking import question_of
from dineros.analysis.requirements.stored import Asked, asked
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.cli.main import main
from dineros.generators import Options
from dineros.generators import check as compare
from dineros.generators.workspace.building import environment
from dineros.metamodel import sym
from dineros.metamodel.constraints import validate
from dineros.metamodel.files import save
from dineros.runtime.ros.process.environment import ros_environment
from examples.mobile_robot.build import PATIENCE as PATIENCE_OF_MISSION
from examples.mobile_robot.timed import ASKED, CHARGED, DEADLINES, LATENCY, REACTION, build_timed
from tests.support.programs.launching import commands
from tests.support.programs.on_ros import on_ros
from tests.support.type_checker import strict_mypy

HOME = Path(__file__).resolve().parents[2] / "examples/mobile_robot"
MODEL, EARLIER = HOME / "mobile_robot.sym.xmi", HOME / "mobile_robot_earlier.sym.xmi"
ROBOT = APPLICATIONS["mobile_robot"]
PATIENCE = 120.0
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


def test_the_timed_file_is_what_its_script_builds(tmp_path: Path) -> None:
    save(build_timed(), tmp_path / "timed.sym.xmi")
    assert (tmp_path / "timed.sym.xmi").read_bytes() == (HOME / "mobile_robot_timed.sym.xmi").read_bytes()
    found = {each.constraint for each in validate(build_timed())}
    assert found == {"topic-survives-restarts"}


@pytest.mark.long
def test_deadlines_are_sums_of_what_lies_on_the_way() -> None:
    """Some nodes prove them, and no bound that is 10 ms shorter."""
    arrives, sooner = REACTION + LATENCY, 0.01
    again = PATIENCE_OF_MISSION + REACTION
    assert pytest.approx(again + 4 * arrives + 4 * REACTION) == ASKED
    assert pytest.approx(2 * arrives + 6 * REACTION) == CHARGED
    model = build_timed()
    subject = timed_base_subject(model)
    for id, bound in (("AsksForTheDockInTime", ASKED), ("IsChargedInTime", CHARGED)):
        (property,) = (each for each in model.properties if each.id == id)
        for seconds in (bound, bound - sooner):
            property.text = DEADLINES[id].replace(f"within {bound}", f"within {seconds:g}")
            found = asked(property, subject).by_parts(Budget(seconds=120))
            assert (found is not None) == (seconds == bound), property.text


@pytest.mark.long
def test_with_times_some_nodes_prove_all_properties() -> None:
    model = build_timed()
    subject = timed_base_subject(model)
    for property in model.properties:
        question = question_of(property, subject)
        if isinstance(question, Asked):
            found = question.by_parts(Budget(seconds=240))
        else:
            found = question.by_bounds()
        assert found is not None, property.text


def test_what_validate_says_is_meant() -> None:
    """Sensors are volatile, and a handler makes the feedback."""
    found = sorted((each.constraint, getattr(each.element, "id", "")) for each in validate(built()))
    assert found == [
        ("topic-survives-restarts", "Images"),
        ("topic-survives-restarts", "Markers"),
        ("topic-survives-restarts", "Scans"),
        ("type-change-has-handler", "TProceed"),
    ]


@pytest.mark.long
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
    assert "every goal that was sent can end" in report.proved


@pytest.mark.long
def test_in_the_earlier_version_a_canceled_goal_may_never_end() -> None:
    result = command("verify", EARLIER, "GoalsEnd")
    assert result.exit_code == 1
    steps = result.stdout.splitlines()
    gone = next(number for number, step in enumerate(steps) if "asks to cancel, and has no goal" in step)
    assert steps[gone - 1].endswith("TRecall")
    assert "sends a goal" in steps[gone + 1]


@pytest.mark.long
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


@pytest.mark.long
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


@pytest.mark.long
def test_it_runs_on_ros_and_loses_nothing_when_it_is_killed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every goal is over once, every waypoint is closed once, and the run conforms: `stress` says so.

    Interfaces are built once: what the launch file starts runs in the same workspace.
    """
    monkeypatch.setattr(stops_and_kills, "KINDS", ("SIGKILL", "node SIGKILL"))
    with on_ros() as domain:
        lines: list[dict[str, Any]] = list(
            stops_and_kills.stress(ROBOT, tmp_path, 2, 5, 4, domain, longest=3.0)
        )
        runs_as_launched(tmp_path / "workspace", tmp_path / "launched", domain)
    assert sum("stop" in line for line in lines) == 2
    assert sum(line.get("goal", 0) for line in lines) >= 4
    assert sum(line.get("finish", 0) for line in lines) >= 4


def runs_as_launched(workspace: Path, folder: Path, domain: int) -> None:
    """All that the launch file starts, until the camera is active and a waypoint is reached."""
    path = workspace / "src/mobile_robot_bringup/launch/mobile_robot.launch.py"
    journal = folder / "journal"
    programs = commands(path, workspace, {"journal": str(journal)})
    assert sorted(programs) == sorted(["bringup", *(name.removeprefix("robot_") for name in PACKAGES)])
    programs["world"] = [sys.executable, str(HOME / "world.py"), "--every", "0"]
    variables = ros_environment(folder, domain, "memory", environment(workspace))
    with ExitStack() as stack:
        started = {
            name: stack.enter_context(running(command, folder / f"{name}.log", variables))
            for name, command in programs.items()
        }
        end = time.monotonic() + PATIENCE
        while not (
            '"transition":"TDone"' in (text := content(journal / "mission.jsonl"))
            and '"state":"active"' in content(journal / "camera.jsonl")
        ):
            assert time.monotonic() < end, text
            ended = {name: each.poll() for name, each in started.items()}
            assert not {name: code for name, code in ended.items() if code}, ended
            time.sleep(0.1)
    assert {name: each.returncode for name, each in started.items()} == dict.fromkeys(started, 0)
    result = command("conform", workspace, journal, "--allowance", "1")  # ticks come late on a busy machine
    assert (result.exit_code, ": conforms; " in result.stdout) == (0, True), result.stdout


@contextmanager
def running(command: list[str], log: Path, variables: dict[str, str]) -> Iterator[subprocess.Popen[bytes]]:
    """Run a program, and tell it to end as `ros2 launch` does."""
    with log.open("wb") as file:
        process = subprocess.Popen(
            command, env=variables, stdin=subprocess.DEVNULL, stdout=file, stderr=file, cwd=log.parent
        )
    try:
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(PATIENCE)


def content(path: Path) -> str:
    """Return what a file holds so far."""
    return path.read_text(encoding="utf-8", errors="replace") if path.is_file() else ""


def test_the_pictures_are_those_of_the_model(tmp_path: Path) -> None:
    for name, options in (
        ("nodes", ["--collapse", "all"]),
        ("navigator", ["--around", "TDrive", "--steps", "3"]),
    ):
        drawn = tmp_path / f"{name}.svg"
        assert command("view", MODEL, *options, "-o", drawn).exit_code == 0
        assert words(drawn) == words(HOME / f"pictures/{name}.svg")


def words(picture: Path) -> list[str]:
    """Return what stands in a picture, wherever it does."""
    return sorted(re.findall(r">([^<>\s][^<>]*)<", picture.read_text(encoding="utf-8")))
