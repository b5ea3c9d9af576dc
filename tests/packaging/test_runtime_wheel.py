"""The wheel of a robot: a node runs with it and what it depends on, where nothing else is installed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from importlib.metadata import distribution
from pathlib import Path
from zipfile import ZipFile

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.files import save
from dineros.runtime.ros.process.domains import claimed_domain
from dineros.runtime.ros.process.environment import ros_environment
from dineros.transformations.flattening.split import split
from tests.support.programs.on_ros import require_tools
from tools.runtime_wheel import ROOT, build

HEAVY = ("numba", "llvmlite", "scipy", "pyarrow", "highspy", "pysat", "distributed", "dask", "py_mini_racer")
MODELLERS = ("click", "rich", "jinja2", "networkx", "matplotlib", "mkdocs", "starlette", "uvicorn")
SHADOWED = {"lark-parser"}
"""What the wheels of ROS 2 ask for, and run with lark instead of; see tools/lock.py."""

HANDLERS = """
import json, sys
from pathlib import Path
def configure(net):
    @net.handler("Work")
    def work(firing):
        Path("modules.json").write_text(json.dumps(sorted(sys.modules)))
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build(tmp_path_factory.mktemp("wheel"))


def requirements(wheel: Path) -> list[Requirement]:
    with ZipFile(wheel) as archive:
        (name,) = (each for each in archive.namelist() if each.endswith(".dist-info/METADATA"))
        lines = archive.read(name).decode().splitlines()
    return [Requirement(line.removeprefix("Requires-Dist: ")) for line in lines if "Requires-Dist" in line]


def needed(wheel: Path, extra: str) -> set[str]:
    """Return the names of all distributions that an installation brings."""
    todo = [(each, extra) for each in requirements(wheel)]
    found: set[str] = set()
    while todo:
        requirement, asked = todo.pop()
        name: str = canonicalize_name(requirement.name)
        if requirement.marker is not None and not requirement.marker.evaluate({"extra": asked}):
            continue
        name = "lark" if name in SHADOWED else name
        new = name not in found
        found.add(name)
        for extra_ in requirement.extras or ({""} if new else ()):
            todo += [(Requirement(each), extra_) for each in distribution(name).requires or ()]
    return found


@pytest.mark.long
def test_it_holds_its_rooms_and_nothing_of_the_others(wheel: Path) -> None:
    inside = {name for name in ZipFile(wheel).namelist() if name.startswith("dineros/")}
    assert {name.split("/")[1] for name in inside} == {"metamodel", "runtime"}
    for room in ("metamodel", "runtime"):
        files = [
            each for each in (ROOT / room).rglob("*") if each.is_file() and "__pycache__" not in each.parts
        ]
        assert {f"dineros/{each.relative_to(ROOT).as_posix()}" for each in files} <= inside


@pytest.mark.long
def test_it_needs_little_and_runs_where_there_are_wheels(wheel: Path) -> None:
    """On ARM, all of it is there: ROS 2 itself comes from elsewhere, and the rest has wheels."""
    arm = {"platform_machine": "aarch64", "sys_platform": "linux", "extra": "ros"}
    own = [each for each in requirements(wheel) if each.marker is None]
    assert {each.name for each in own} == {"lxml", "pyecore"}
    on_arm = [each.name for each in requirements(wheel) if each.marker and each.marker.evaluate(arm)]
    assert on_arm == []
    assert needed(wheel, "ros").isdisjoint({*HEAVY, *MODELLERS, "mini-racer"})


@pytest.mark.long
def test_a_node_runs_with_it_alone(wheel: Path, tmp_path: Path) -> None:
    """Only the files of what it needs are on Python's path, as in an environment made for it."""
    require_tools()
    site = tmp_path / "site"
    site.mkdir()
    for name in needed(wheel, "ros"):
        for file in distribution(name).files or ():
            top = Path(file).parts[0]
            if top not in ("..", "__pycache__") and not top.endswith(".pth") and not (site / top).exists():
                (site / top).symlink_to(Path(str(distribution(name).locate_file(top))))
    ZipFile(wheel).extractall(site)

    todo, work, done = sym.Place(id="Todo", tokens=1), sym.Transition(id="Work"), sym.Place(id="Done")
    worker = sym.NodeNet(id="worker", objects=[todo, work, done])
    flow(todo, work, done)
    (part,) = split(sym.SystemModel(id="alone", pages=[worker]))
    save(part, tmp_path / "worker.rtm.xmi")
    (tmp_path / "handlers.py").write_text(HANDLERS)
    with claimed_domain() as domain:
        environment = ros_environment(tmp_path / "ros", domain, "memory", {**os.environ})
        environment |= {"PYTHONPATH": str(site), "AMENT_PREFIX_PATH": sys.prefix}
        command = [sys.executable, "-S", "-m", "dineros.runtime.ros.node_main", "worker.rtm.xmi"]
        command += ["--handlers", "handlers.py", "--ros-args", "-p", "journal:=journal"]
        with (tmp_path / "log").open("wb") as log:
            node = subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=log, stderr=log)
        try:
            end = time.monotonic() + 60
            while not (tmp_path / "modules.json").exists():
                assert node.poll() is None, (tmp_path / "log").read_text()
                assert time.monotonic() < end
                time.sleep(0.05)
            node.send_signal(signal.SIGINT)
            assert node.wait(30) == 0, (tmp_path / "log").read_text()
        finally:
            if node.poll() is None:
                node.kill()
                node.wait()
    modules = set(json.loads((tmp_path / "modules.json").read_text()))
    assert "dineros.runtime.ros.diagnostics" in modules
    assert {name.split(".")[0] for name in modules}.isdisjoint({*HEAVY, *MODELLERS})
    assert {name.split(".")[1] for name in modules if name.startswith("dineros.")} <= {"metamodel", "runtime"}
