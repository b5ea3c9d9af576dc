"""The case study's workspace: its packages can be imported as the nodes do it, and it is built once."""

from __future__ import annotations

import fcntl
import hashlib
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from dineros.generators.workspace.building import remember
from dineros.runtime.ros.process.domains import claimed_domain
from dineros.runtime.ros.wheels import prefix_of_wheels
from tests.support.programs.on_ros import keep_for_others, require_tools

ROOT = Path(__file__).resolve().parents[2]
WORKSPACE = ROOT / "case_study" / "workspace"
BUILT = ROOT / "build/tests/sorting_workspace"
# Variables by which a shell that has sourced nothing differs from this process.
SET_UP = re.compile(r"(AMENT|CMAKE|COLCON|ROS|_ROS|LD_LIBRARY|VIRTUAL_ENV|PYTHON)")

sys.path[:0] = [str(path) for path in sorted((WORKSPACE / "src").iterdir()) if path.is_dir()]


def documented_commands() -> list[str]:
    """Return what the workspace's README says about building and testing."""
    readme = (WORKSPACE / "src/sorting_bringup/README.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"^```\n(source .*?)^```$", readme, re.MULTILINE | re.DOTALL)
    return str(block).splitlines()


def in_fresh_shell(commands: list[str], folder: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run commands of the README as a developer does who has just opened a terminal."""
    environment = {**os.environ, **variables}
    prefix = prefix_of_wheels()
    if prefix is None:  # ROS 2 came in another way, and whoever runs the tests has sourced it
        commands = [line for line in commands if line != "source .venv/setup.bash"]
    else:
        commands = [line.replace(".venv/", f"{prefix}/") for line in commands]
        environment = {name: value for name, value in environment.items() if not SET_UP.match(name)}
        path = environment["PATH"].split(os.pathsep)
        environment["PATH"] = os.pathsep.join(part for part in path if Path(part) != prefix / "bin")
    environment |= {"MAKEFLAGS": "-j2", **variables}
    return subprocess.run(
        ["bash", "-e", "-c", "\n".join(commands)],
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture(scope="session")
def workspace() -> Path:
    """A copy of the workspace, built as its README says, once for all runs of the tests."""
    require_tools()
    BUILT.parent.mkdir(parents=True, exist_ok=True)
    with BUILT.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # several test processes build one workspace
        stamp, wanted = BUILT / "built-from", _content()
        if not stamp.is_file() or stamp.read_text(encoding="utf-8") != wanted:
            shutil.rmtree(BUILT, ignore_errors=True)
            outputs = shutil.ignore_patterns("build", "install", "log", "__pycache__")
            shutil.copytree(WORKSPACE, BUILT, ignore=outputs)
            commands = documented_commands()
            done = in_fresh_shell(commands[: commands.index("colcon build") + 1], BUILT)
            assert done.returncode == 0, done.stdout + done.stderr
            remember(BUILT)
            keep_for_others(BUILT)
            stamp.write_text(wanted, encoding="utf-8")
    return BUILT


def _content() -> str:
    """Return a hash of what is built, and of what it is built with."""
    digest = hashlib.sha256(f"{sys.version} {sys.prefix}".encode())
    prefix = prefix_of_wheels()
    for path in [prefix / "setup.bash"] if prefix else []:
        digest.update(path.read_bytes())
    for path in sorted((WORKSPACE / "src").rglob("*")):
        if path.is_file() and "__pycache__" not in path.parts:
            digest.update(f"\0{path.relative_to(WORKSPACE)}\0".encode() + path.read_bytes())
    return digest.hexdigest()


@pytest.fixture
def ros_domain() -> Iterator[int]:
    """Return a ROS domain that no other run on this machine has, of these tests or of others."""
    with claimed_domain() as domain:
        yield domain
