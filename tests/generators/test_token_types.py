"""A generated application whose tokens have several types, run in one process and on ROS 2."""

from __future__ import annotations

import importlib
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

from dineros.analysis.conformance import conform
from dineros.generators import Options, generate
from dineros.metamodel.records import read_trace, traces_of_runs
from dineros.runtime.application.simulation import LocalApplication
from dineros.transformations.flattening.split import split
from tests.support.programs.on_ros import build_as_before, on_ros
from tests.support.systems.shop import DRIVER, PLANNER, shop
from tests.support.type_checker import strict_mypy

REPORTS = [{"data": "nut at 7"}, {"data": " at 0"}]


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("typed") / "ws"
    generate(shop(), folder, Options(source="shop.sym.xmi"))
    for package, handlers in (("shop_planner", PLANNER), ("shop_driver", DRIVER)):
        file = folder / f"src/{package}/{package}/handlers.py"
        head = file.read_text().partition("@firings.on")[0]
        file.write_text(head.replace("import firings", "import firings, tokens") + handlers.lstrip())
    return folder


def test_messages_are_generated_for_own_types_only(workspace: Path) -> None:
    package = workspace / "src/shop_interfaces"
    assert [path.name for path in (package / "msg").iterdir()] == ["Order.msg"]
    message = (package / "msg/Order.msg").read_text()
    assert (
        "\nstring<=8 article\nuint8 count\nfloat32[<=3] sizes\nuint8 LOW=0\nuint8 HIGH=2\nuint8 urgency\n"
        in message
    )
    service = (package / "srv/Where.srv").read_text()
    assert service.endswith("\nOrder token\n---\ngeometry_msgs/PoseStamped token\nstring message_id\n")
    assert "<depend>geometry_msgs</depend>" in (package / "package.xml").read_text()
    assert "  DEPENDENCIES geometry_msgs\n)" in (package / "CMakeLists.txt").read_text()
    assert (
        "<exec_depend>geometry_msgs</exec_depend>" in (workspace / "src/shop_driver/package.xml").read_text()
    )


@pytest.mark.long
def test_handlers_are_typed_by_their_places(workspace: Path) -> None:
    """The handlers above pass strict mypy and ruff, and wrong ones are refused by the types of each side."""
    for package in ("shop_planner", "shop_driver"):
        assert strict_mypy(workspace, f"src/{package}") == "Success: no issues found in 11 source files\n"
    ruff = [sys.executable, "-m", "ruff"]
    for options in (["check", "--isolated"], ["format", "--check", "--isolated", "--line-length", "110"]):
        done = subprocess.run(
            [*ruff, *options, "src"], cwd=workspace, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stdout
    handlers = workspace / "src/shop_driver/shop_driver/handlers.py"
    good = handlers.read_text()
    try:
        handlers.write_text(
            good.replace("return None", 'return {"count": 1}').replace("['frame_id']", "['frame']")
        )
        said = strict_mypy(workspace, "src/shop_driver/shop_driver/handlers.py")
        assert 'expected "NoteChanges | Given | None"' in said
        assert 'TypedDict "Header" has no key "frame"' in said
    finally:
        handlers.write_text(good)


def test_runs_in_one_process(workspace: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    application = LocalApplication(split(shop()), seed=1)
    for package, node in (("shop_planner", "planner"), ("shop_driver", "driver")):
        monkeypatch.syspath_prepend(workspace / "src" / package)
        importlib.import_module(f"{package}.base").register(application.nets[node])
    with application:
        application.run(
            lambda app: app.count("planner", "Done") == 2 and app.count("planner", "Kept") == 1, 60
        )
        planner, driver = (application.nets[node].inspect() for node in ("planner", "driver"))
    assert not (*planner.errors, *driver.errors)
    assert sorted(str(token.data) for token in planner.marking["Done"]) == sorted(map(str, REPORTS))
    (kept,) = planner.marking["Kept"]
    assert kept.data["header"] == {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "lamp"}
    assert [token.data for token in driver.marking["Where[1].Log"]] == [{"data": "255!"}]


@pytest.mark.long
def test_runs_on_ros_as_the_model_says(workspace: Path, tmp_path: Path) -> None:
    with on_ros() as domain:
        build_as_before(workspace)
        command = [sys.executable, "-m", "dineros.cli.main", "run", str(workspace), "--trace", str(tmp_path)]
        command += ["--until", "Done >= 2 and Kept >= 1", "--timeout", "120", "--domain", str(domain)]
        done = subprocess.run([*command, "--reach", "memory"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    found = traces_of_runs([tmp_path])
    assert (
        conform(shop(), {node: partial(read_trace, files) for node, files in found.items()}).status
        == "conforms"
    )
    taken = [
        getattr(record, "data", None)
        for files in found.values()
        for record in read_trace(files)
        if record.event in ("take", "serve", "response")
    ]
    assert all(report in taken for report in REPORTS)
    assert {"article": "lamp", "count": 255, "sizes": [0.10000000149011612, 2.0], "urgency": 2} in taken
