"""The dispatcher and its robots: n as a parameter, a simulated run with recalls, one on ROS 2."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import pytest

from dineros.analysis.timed_checks.timed_check import check_timed
from dineros.generators import Options, check
from dineros.metamodel import sym
from dineros.metamodel.constraints import validate
from dineros.metamodel.files import save
from examples.dispatch.build import build
from examples.dispatch.floor import phases
from examples.dispatch.timed import ENTERED, FREED, LATENCY, REACTION, build_timed
from tests.examples.applications import (
    EXAMPLES,
    dineros,
    runs_and_conforms,
    simulated,
    system_model,
    workspace,
)
from tests.support.type_checker import strict_mypy

HOME = EXAMPLES / "dispatch"
MODEL = HOME / "dispatch.sym.xmi"
ROBOTS = ("robot1", "robot2", "robot3")
NODES = ("dispatcher", "traffic", "board", *ROBOTS)
HANDLERS = {
    **{f"dispatch_{robot}": HOME / "handlers/robot.py" for robot in ROBOTS},
    **{f"dispatch_{node}": HOME / f"handlers/{node}.py" for node in ("dispatcher", "board")},
}
ALONE = "InAisle1 + InAisle2 + InAisle3 <= 1"

SIMULATED = """
from examples.dispatch.floor import phases

floor = phases(3)

def change(seconds):
    for node, values in next(floor).items():
        application.nets[node].set_signals(values)

application.every(0.15, change)
with application:
    outcome = application.run(lambda each: each.count("board", "Listed") == 3, timeout=300)
    listed = [token.data for token in application.nets["board"].inspect().marking["Listed"]]
print(json.dumps([outcome, listed]))
"""


@pytest.fixture(scope="module")
def floor_workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return workspace(tmp_path_factory.mktemp("floor") / "ws", MODEL, HANDLERS)


def test_the_files_are_what_the_script_builds(tmp_path: Path) -> None:
    for model in (build(), build(robots=2, orders=1, gives_up_waiting=True)):
        save(model, tmp_path / "built.sym.xmi")
        assert (tmp_path / "built.sym.xmi").read_bytes() == (HOME / f"{model.id}.sym.xmi").read_bytes()


@pytest.mark.parametrize("robots", [1, 2, 7])
def test_it_has_as_many_robots_as_it_is_told(robots: int) -> None:
    model = build(robots=robots)
    assert validate(model) == []
    actions = [channel.action for channel in model.channels if isinstance(channel, sym.ActionChannel)]
    assert actions == [f"/robot{n}/deliver" for n in range(1, robots + 1)]
    assert len(model.pages) == robots + 3


def test_the_handlers_fit_the_workspace_and_pass_mypy(floor_workspace: Path) -> None:
    assert check(system_model(MODEL), floor_workspace, Options(source=MODEL.name)).changes == ()
    packages = [f"src/{package}/{package}" for package in HANDLERS]
    assert strict_mypy(floor_workspace, *packages).startswith("Success: no issues found")


def test_the_floor_stops_now_and_then_and_blocks_one_robot_at_a_time() -> None:
    seen = list(islice(phases(2), 12))
    blocked = [sum(value for node in phase.values() for value in node.values()) for phase in seen[::2]]
    assert blocked == [0, 1, 0, 1, 0, 1]
    assert [phase["dispatcher"]["FloorStopped"] for phase in seen[1::2]] == [False, False, True] * 2


def test_the_file_with_times_is_what_the_script_builds(tmp_path: Path) -> None:
    save(build_timed(), tmp_path / "built.sym.xmi")
    assert (tmp_path / "built.sym.xmi").read_bytes() == (HOME / "dispatch_timed.sym.xmi").read_bytes()


@pytest.mark.long
def test_times_bound_how_soon_a_robot_is_in_the_aisle_and_out() -> None:
    """The bounds are the sums of what lies on the way, and no shorter ones hold."""
    entered, freed = 2 * LATENCY + 4 * REACTION, LATENCY + 2 * REACTION
    assert pytest.approx(entered) == ENTERED and pytest.approx(freed) == FREED
    report = check_timed(build_timed())
    assert not report.findings or {each.severity for each in report.findings} == {"note"}
    assert [str(each.question) for each in report.unknown] == ["whether goals can wait forever"]
    for id in ("EntersAFreeAisle", "AisleIsFreed"):
        assert [each for each in report.proved if id in each], report.proved
    sooner = build_timed()
    for each in sooner.properties:
        each.text = each.text.replace(f"within {ENTERED}", "within 0.089").replace(
            f"within {FREED}", "within 0.044"
        )
    broken = [each for each in check_timed(sooner).findings if each.rule == "property-violated"]
    assert len(broken) == 2


@pytest.mark.long
def test_all_orders_are_delivered_whoever_is_recalled(floor_workspace: Path, tmp_path: Path) -> None:
    packages = [f"dispatch_{node}" for node in NODES]
    outcome, listed = simulated(floor_workspace, packages, SIMULATED, tmp_path / "run", MODEL)
    assert outcome == "reached"
    assert sorted(errand["number"] for errand in listed) == [1, 2, 3]
    assert {errand["robot"] for errand in listed} <= set(ROBOTS)
    replayed = dineros("conform", MODEL, tmp_path / "run", "--invariant", ALONE, cwd=tmp_path)
    assert f"{ALONE}: holds throughout\n" in replayed.stdout, replayed.stdout + replayed.stderr


@pytest.mark.long
def test_it_runs_on_ros(floor_workspace: Path, tmp_path: Path) -> None:
    runs_and_conforms(floor_workspace, f"{HOME / 'floor.py'} --robots 3", "Listed >= 1", tmp_path / "run")
