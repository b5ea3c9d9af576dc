"""Workspaces of the applications in `examples`, with the handlers that their developers wrote."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from dineros.generators import Options, generate
from dineros.metamodel import sym
from dineros.metamodel.files import load
from tests.support.programs.on_ros import build_as_before, on_ros

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def system_model(path: Path) -> sym.SystemModel:
    """Return the model in a file."""
    model = load(path)
    assert isinstance(model, sym.SystemModel)
    return model


SIMULATION = """
import json, sys
from importlib import import_module
from pathlib import Path
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.journal import JournalRecorder

packages, folder, source = json.loads(sys.argv[1]), Path(sys.argv[2]), sys.argv[3]
bases = [import_module(f"{package}.base") for package in packages]
application = LocalApplication(
    [base.runtime_model() for base in bases],
    seed=1,
    recorder=lambda node: JournalRecorder(folder, node, source=source),
)
for base in bases:
    base.register(application.nets[base.NODE])
"""
"""Makes an application of a workspace's packages, in simulated time, that records into a folder."""


def workspace(folder: Path, model: Path, handlers: Mapping[str, Path]) -> Path:
    """Generate a workspace around handlers, given by their package."""
    generate(system_model(model), folder, Options(source=model.name))
    for package, file in handlers.items():
        shutil.copy(file, folder / "src" / package / package / "handlers.py")
    return folder


def dineros(*arguments: object, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run a command of DiNeROS."""
    return subprocess.run(
        [sys.executable, "-P", "-m", "dineros.cli.main", *map(str, arguments)],
        cwd=cwd,
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
        timeout=500,
    )


def simulated(workspace: Path, packages: Iterable[str], script: str, traces: Path, model: Path) -> Any:
    """Run a script that has an `application` of packages of a workspace; return the JSON that it prints."""
    chosen = list(packages)
    path = [str(workspace / "src" / package) for package in chosen]
    run = subprocess.run(
        [sys.executable, "-c", SIMULATION + script, json.dumps(chosen), str(traces), model.name],
        env={**os.environ, "PYTHONPATH": os.pathsep.join([*path, str(EXAMPLES.parent)])},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)


def runs_and_conforms(workspace: Path, world: str, until: str, traces: Path) -> None:
    """Run a workspace on ROS beside its world until something holds: what it does conforms meanwhile."""
    with on_ros() as domain:
        build_as_before(workspace)
        options = ("--domain", domain, "--reach", "memory", "--trace", traces, "--monitor")
        run = dineros(
            *("run", workspace, "--with", f"{sys.executable} {world}", "--until", until),
            *("--timeout", 300, *options),
            cwd=traces.parent,
        )
    assert run.returncode == 0, run.stdout + run.stderr
    assert "\nconformance: conforms, " in run.stdout
