"""The sorting cell with actions: its files, its handlers, a simulated run with people, one on ROS 2."""

from __future__ import annotations

import json
from pathlib import Path
from typing import get_args

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.timed_checks.timed_check import check_timed
from dineros.generators import Options, check
from dineros.metamodel.constraints import validate
from dineros.metamodel.files import save
from examples.sorting_actions.build import Version, build
from examples.sorting_actions.cell import Cell
from examples.sorting_actions.timed import LATENCY, MOTION, OPENED, REACTION, build_timed
from tests.examples.applications import (
    EXAMPLES,
    dineros,
    runs_and_conforms,
    simulated,
    system_model,
    workspace,
)
from tests.support.type_checker import strict_mypy

HOME = EXAMPLES / "sorting_actions"
MODEL = HOME / "cell.sym.xmi"
NODES = ("selector", "controller", "synchronizer", "arm", "guard", "display")
HANDLED = ("selector", "arm", "guard", "display")
APART = "PickMoving + PickBraking + PlaceMoving + PlaceBraking + GateOpen <= 1"

SIMULATED = """
from examples.sorting_actions.cell import Cell

cell = Cell(lambda node, values: application.nets[node].set_signals(values), visit_every=2, stay=0.5)
import_module("cell_arm.handlers").use(cell.command)
import_module("cell_guard.handlers").use(cell.gate)
application.every(0.05, cell.advance)
with application:
    cell.tell_all()
    outcome = application.run(lambda each: each.count("display", "Shown") == 3, timeout=300)
    shown = [token.data for token in application.nets["display"].inspect().marking["Shown"]]
print(json.dumps([outcome, cell.accidents, cell.stopped, shown]))
"""


@pytest.fixture(scope="module")
def cell_workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    handlers = {f"cell_{node}": HOME / f"handlers/cell_{node}.py" for node in HANDLED}
    return workspace(tmp_path_factory.mktemp("cell") / "ws", MODEL, handlers)


@pytest.mark.parametrize("version", get_args(Version))
def test_the_files_are_what_the_script_builds(version: Version, tmp_path: Path) -> None:
    save(build(version), tmp_path / "built.sym.xmi")
    assert (tmp_path / "built.sym.xmi").read_bytes() == (HOME / f"{version}.sym.xmi").read_bytes()


def test_the_file_with_times_is_what_the_script_builds(tmp_path: Path) -> None:
    model = build_timed()
    assert validate(model) == []
    save(model, tmp_path / "built.sym.xmi")
    assert (tmp_path / "built.sym.xmi").read_bytes() == (HOME / "cell_timed.sym.xmi").read_bytes()


@pytest.mark.long
def test_times_bound_how_soon_the_gate_opens() -> None:
    """The bound is the sum of what lies on the way, and no shorter one holds."""
    assert pytest.approx((MOTION.latest or 0) + 4 * (LATENCY + REACTION) + 6 * REACTION) == OPENED
    report = check_timed(build_timed(), Budget(seconds=120))
    assert {each.severity for each in report.findings} == {"note"}
    assert [str(each.question) for each in report.unknown] == ["whether goals can wait forever"]
    assert [each for each in report.proved if "OpensInTime" in each], report.proved
    sooner = build_timed()
    (opens,) = (each for each in sooner.properties if each.id == "OpensInTime")
    opens.text = opens.text.replace(f"within {OPENED}", "within 0.719")
    found = check_timed(sooner, Budget(seconds=120)).findings
    assert [each.rule for each in found if each.severity != "note"] == ["property-violated"]


@pytest.mark.long
def test_the_handlers_fit_the_workspace_and_pass_mypy(cell_workspace: Path) -> None:
    assert check(system_model(MODEL), cell_workspace, Options(source=MODEL.name)).changes == ()
    packages = [f"src/cell_{node}/cell_{node}" for node in HANDLED]
    assert strict_mypy(cell_workspace, *packages).startswith("Success: no issues found")


@pytest.mark.long
def test_people_come_and_go_and_everything_is_sorted(cell_workspace: Path, tmp_path: Path) -> None:
    packages = [f"cell_{node}" for node in NODES]
    outcome, accidents, stopped, shown = simulated(
        cell_workspace, packages, SIMULATED, tmp_path / "run", MODEL
    )
    assert (outcome, accidents) == ("reached", 0)
    assert all(piece["isSorted"] for piece in shown)
    assert sorted(piece["color"] for piece in shown) == ["blue", "green", "red"]
    assert sum(piece["interruptions"] for piece in shown) == stopped > 0
    replayed = dineros("conform", MODEL, tmp_path / "run", "--invariant", APART, cwd=tmp_path)
    assert replayed.returncode == 0, replayed.stdout + replayed.stderr
    assert f"{APART}: holds throughout\n" in replayed.stdout


def test_the_world_notices_an_accident() -> None:
    cell = Cell(lambda node, values: None)
    cell.command("pick", "red-1")
    cell.advance(0.1)
    assert cell.accidents == 0
    cell.gate(True)
    cell.advance(0.1)
    assert cell.accidents == 1


def test_an_arm_hears_of_rest_only_after_a_command() -> None:
    told: dict[str, dict[str, bool]] = {}
    cell = Cell(told.__setitem__)
    cell.tell_all()
    cell.advance(0.1)
    assert sorted(told) == ["guard", "selector"]
    cell.command("pick", "red-1")
    assert told["arm"] == {"AtRest": False, "Holding": False}


def test_an_arm_that_is_stopped_holds_what_it_held() -> None:
    told: dict[str, dict[str, bool]] = {}
    cell = Cell(told.__setitem__, motion_time=0.4, brake_time=0.1)
    for motion in ("pick", "place"):
        cell.command(motion, "red-1")
        assert told["arm"]["AtRest"] is False
        cell.advance(0.2)
        cell.command("brake", "red-1")
        cell.advance(0.2)
        assert told["arm"] == {"AtRest": True, "Holding": motion == "place"}
        cell.command(motion, "red-1")
        cell.advance(0.5)
    assert (told["arm"], cell.stopped) == ({"AtRest": True, "Holding": False}, 2)


@pytest.mark.long
def test_it_runs_on_ros_while_a_person_comes(cell_workspace: Path, tmp_path: Path) -> None:
    # A motion is long enough for a cancel to come while it is under way, also on a busy machine.
    world = f"{HOME / 'cell.py'} --motion-time 1 --visit-every 2 --stay 0.5"
    runs_and_conforms(cell_workspace, world, "Shown >= 3", tmp_path / "run")
    replayed = dineros("conform", cell_workspace, tmp_path / "run", "--invariant", APART, cwd=tmp_path)
    assert f"{APART}: holds throughout\n" in replayed.stdout, replayed.stdout + replayed.stderr
    ends = [json.loads(line).get("outcome") for line in (tmp_path / "run/arm.jsonl").open()]
    assert "canceled" in ends
    assert "succeeded" in ends
