"""The fleet of `examples/fleet` through the whole chain: check, generate, build, run."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from dineros.cli.main import main
from dineros.generators import Options, check, generate
from dineros.generators.workspace.building import build_interfaces, environment, missing_tools
from dineros.metamodel import sym
from dineros.metamodel.constraints import validate
from dineros.metamodel.files import load
from dineros.metamodel.records import read_trace
from tests.support.type_checker import strict_mypy

ROOT = Path(__file__).resolve().parents[2]
FLEET = ROOT / "examples/fleet"
PACKAGES = ["fleet_dispatcher", "fleet_ada", "fleet_bob", "fleet_map", "fleet_dock", "fleet_charger"]
SWITCHED_ON = {
    "map_server": "MapAvailable",
    "ada": "AdaAtGoal",
    "bob": "BobAtGoal",
    "dock": "BatteryFull",
    "dispatcher": "NewOrder",
}

needs_compiler = pytest.mark.skipif(
    bool(missing_tools()) and not os.environ.get("CI"), reason=f"missing: {', '.join(missing_tools())}"
)


def model() -> sym.SystemModel:
    loaded = load(FLEET / "fleet.sym.xmi")
    assert isinstance(loaded, sym.SystemModel)
    return loaded


def command(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the fleet's workspace, with the handlers that its developers wrote."""
    folder = tmp_path_factory.mktemp("fleet") / "ws"
    generate(model(), folder, Options(source="fleet.sym.xmi"))
    for package in PACKAGES:
        shutil.copy(FLEET / f"handlers/{package}.py", folder / f"src/{package}/{package}/handlers.py")
    return folder


def program(folder: Path, *arguments: object, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *map(str, arguments)],
        cwd=folder,
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1", **environment},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )


def test_the_file_is_what_its_script_builds(tmp_path: Path) -> None:
    shutil.copy(FLEET / "build.py", tmp_path)
    assert program(tmp_path, "build.py").returncode == 0
    assert (tmp_path / "fleet.sym.xmi").read_bytes() == (FLEET / "fleet.sym.xmi").read_bytes()


def test_it_is_as_large_as_it_should_be() -> None:
    fleet = model()
    assert validate(fleet) == []
    topics = [channel for channel in fleet.channels if isinstance(channel, sym.TopicChannel)]
    services = [channel for channel in fleet.channels if isinstance(channel, sym.ServiceChannel)]
    signals = [signal for node in fleet.pages if isinstance(node, sym.NodeNet) for signal in node.signals]
    assert (len(topics), len(services), len(signals)) == (3, 3, 10)
    assert [channel.type for channel in fleet.channels if channel.type] == [
        "geometry_msgs/msg/PoseStamped",
        "std_srvs/srv/SetBool",
    ]


def test_nothing_is_wrong_with_it() -> None:
    result = command("check", FLEET / "fleet.sym.xmi")
    assert result.exit_code == 0
    assert re.search(r": 0 found, 1\d proved, 0 unknown\n$", result.stdout)


@pytest.mark.long
def test_the_handlers_fit_the_workspace(workspace: Path) -> None:
    assert check(model(), workspace, Options(source="fleet.sym.xmi")).changes == ()
    tests = [f"src/{package}" for package in PACKAGES]
    result = program(workspace, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", *tests)
    assert "23 passed" in result.stdout, result.stdout


def test_the_handlers_pass_mypy(workspace: Path) -> None:
    packages = [f"src/{package}/{package}" for package in (*PACKAGES, "fleet_bringup")]
    assert strict_mypy(workspace, *packages) == "Success: no issues found in 38 source files\n"


IN_PROCESS = """
import json, sys
from importlib import import_module
from dineros.runtime.application.simulation import LocalApplication

bases = [import_module(f"{package}.base") for package in json.loads(sys.argv[1])]
fleet = LocalApplication([base.runtime_model() for base in bases], seed=5)
for base in bases:
    base.register(fleet.nets[base.NODE])
arrivals = []

@fleet.nets["dispatcher"].on_change
def note(change):
    if change.event == "take":
        arrivals.append([change.fields["data"][name] for name in ("robot", "x", "y")])

with fleet:
    for node, signal in json.loads(sys.argv[2]).items():
        fleet.nets[node].signal(signal).set(True)
    outcome = fleet.run(lambda fleet: len(arrivals) == 12, timeout=600)
print(json.dumps([outcome, arrivals]))
"""


def test_it_runs_in_process(workspace: Path) -> None:
    path = os.pathsep.join(str(workspace / "src" / package) for package in PACKAGES)
    run = program(workspace, "-c", IN_PROCESS, json.dumps(PACKAGES), json.dumps(SWITCHED_ON), PYTHONPATH=path)
    assert run.returncode == 0, run.stderr
    outcome, arrivals = json.loads(run.stdout)
    assert outcome == "reached"
    check_arrivals(arrivals)


def check_arrivals(arrivals: list[list[Any]]) -> None:
    """Each arrival is at the place of an order, by one of the robots."""
    assert {tuple(place) for _, *place in arrivals} <= {(4.0, 1.0), (2.5, 3.0), (0.5, 2.0)}
    assert {robot for robot, *_ in arrivals} <= {"ada", "bob"}
    assert len({tuple(place) for _, *place in arrivals}) > 1


@pytest.mark.long
@pytest.mark.parametrize(
    ("goal", "variant"),
    [("ChargeResAda >= 1 & Closed >= 2", "none"), ("DrivingAda >= 1 & DrivingBob >= 1", "input-enabled")],
)
def test_witnesses_become_tests(workspace: Path, tmp_path: Path, goal: str, variant: str) -> None:
    copy = tmp_path / "ws"
    shutil.copytree(workspace / "src", copy / "src", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(workspace / ".dineros", copy / ".dineros")
    witness = tmp_path / "some-witness.jsonl"
    fleet = FLEET / "fleet.sym.xmi"
    rules = "--middleware", "ros2"  # those of the nodes that are generated
    found = command("find", fleet, *rules, "--marking", goal, "--signals", variant, "-o", witness)
    assert found.exit_code == 0, found.stderr
    made = command("generate", fleet, "-o", copy, "--tests", witness)
    assert made.exit_code == 0, made.stderr
    test = "src/fleet_bringup/test/test_some_witness.py"
    run = program(copy, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", test)
    assert "1 passed" in run.stdout, run.stdout
    assert command("generate", FLEET / "fleet.sym.xmi", "-o", copy, "--check").exit_code == 0
    steps = copy / "src/fleet_bringup/test/steps/some_witness.json"
    assert '"fire"' in steps.read_text()
    text = (copy / test).read_text()
    (copy / test).write_text(text.replace('"Idle', '"Idel', 1).replace("TAccept", "TArrive", 1))
    run = program(copy, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", test)
    assert "1 failed" in run.stdout, run.stdout


def test_a_trace_of_another_model_or_marking_is_refused(workspace: Path, tmp_path: Path) -> None:
    witness = tmp_path / "w.jsonl"
    fleet = FLEET / "fleet.sym.xmi"
    settings = ["--set", "Orders.tokens=4"]
    found = command("find", fleet, "--marking", "SendAda >= 1", "--signals", "none", "-o", witness, *settings)
    assert found.exit_code == 0, found.stderr
    result = command("generate", fleet, "-o", tmp_path / "ws", "--tests", witness)
    assert result.exit_code == 2
    assert (
        "w.jsonl: starts with 4 tokens on Orders, the model with 3 (generate with the settings"
        in result.stderr
    )
    result = command(
        "generate", ROOT / "case_study/sorting.sym.xmi", "-o", tmp_path / "ws", "--tests", witness
    )
    assert (result.exit_code, "is a trace of 'fleet', not of 'sorting'" in result.stderr) == (2, True)
    assert not (tmp_path / "ws").exists()


@pytest.mark.long
@needs_compiler
def test_it_is_built_and_runs_on_ros(workspace: Path, tmp_path: Path) -> None:
    """One build for all: the interfaces; the nodes run from their sources."""
    installed = build_interfaces(workspace)
    assert installed == workspace / "install/fleet_interfaces"
    assert (installed / "share/fleet_interfaces/package.xml").is_file()

    before = (installed / "share").stat().st_ino
    assert build_interfaces(workspace) == installed
    for settings in (["--set", "Orders.tokens=4"], []):  # which change no interface
        assert command("generate", FLEET / "fleet.sym.xmi", "-o", workspace, *settings).exit_code == 0
        build_interfaces(workspace)
    assert (installed / "share").stat().st_ino == before, "built twice"
    runs_on_ros(workspace, tmp_path)


def runs_on_ros(workspace: Path, folder: Path) -> None:
    """Six processes; a seventh that knows nothing of DiNeROS switches signals on and sees who arrives."""
    from dineros.runtime.ros.process.environment import ros_environment

    variables = ros_environment(folder, 62, "memory", environment(workspace))
    runner = subprocess.Popen(
        [sys.executable, "-m", "fleet_bringup.runner", "--journal", str(folder / "journal")],
        env=variables,
        cwd=folder,
    )
    try:
        watch = subprocess.run(
            [sys.executable, str(FLEET / "watch.py"), "6"],
            env=variables,
            capture_output=True,
            text=True,
            check=False,
            timeout=180,
        )
        assert watch.returncode == 0, watch.stderr
        check_arrivals(json.loads(watch.stdout))
    finally:
        runner.send_signal(signal.SIGTERM)
        assert runner.wait(60) == 0
    traces = sorted((folder / "journal").glob("*.jsonl"))
    assert [path.stem for path in traces] == ["ada", "bob", "charger", "dispatcher", "dock", "map_server"]
    for path in traces:
        events = {record.event for record in read_trace(path)}
        assert {"header", "start", "fire", "stop"} <= events
        assert "error" not in events
    conform = command("conform", FLEET / "fleet.sym.xmi", folder / "journal")
    assert conform.exit_code == 0, conform.stdout + conform.stderr
    assert "fleet.sym.xmi: conforms; " in conform.stdout
    made = command("generate", FLEET / "fleet.sym.xmi", "-o", workspace, "--tests", folder / "journal")
    assert made.exit_code == 0, made.stderr
    test = "src/fleet_bringup/test/test_journal.py"
    run = program(workspace, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", test)
    assert "1 passed" in run.stdout, run.stdout
