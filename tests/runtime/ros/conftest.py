"""Real ROS 2 processes for tests: interfaces built once, a domain and a folder per test."""

from __future__ import annotations

import fcntl
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from dineros.generators import Options, generate
from dineros.generators.workspace.building import build_interfaces, environment
from dineros.metamodel.files import save
from dineros.runtime.ros.process.domains import claimed_domain
from dineros.runtime.ros.process.environment import Reach, ros_environment
from dineros.runtime.ros.process.memory import remove_abandoned
from dineros.transformations.flattening.split import split
from tests.runtime.ros.post import post
from tests.runtime.ros.sockets import bound_addresses
from tests.support.programs.on_ros import require_tools

ROOT = Path(__file__).resolve().parents[3]
WORKSPACE = ROOT / "build/tests/post_workspace"
PATIENCE = 60.0
"""Seconds: machines that run the tests may be slow; nobody waits that long on a good day."""


@pytest.fixture(scope="session")
def workspace() -> Path:
    """A workspace with the interfaces of the model `post`, built by the first run that needs it."""
    require_tools()
    WORKSPACE.mkdir(parents=True, exist_ok=True)
    with (WORKSPACE.parent / "post_workspace.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # several test processes build one workspace
        generate(post(), WORKSPACE, Options(source="post.sym.xmi"))
        build_interfaces(WORKSPACE)
    return WORKSPACE


@dataclass
class Process:
    """A process of the test."""

    name: str
    popen: subprocess.Popen[bytes]
    log: Path

    def output(self) -> str:
        return self.log.read_text(errors="replace")

    def interrupt(self) -> int:
        """Ask it to end, and return its exit status."""
        self.popen.send_signal(signal.SIGINT)
        return self.popen.wait(PATIENCE)


@dataclass
class Ros:
    """ROS processes of one test, on a domain of their own."""

    folder: Path
    environment: dict[str, str]
    processes: list[Process] = field(default_factory=list)

    def start(self, name: str, *command: str | Path) -> Process:
        log = self.folder / f"{name}.log"
        with log.open("ab") as output:
            popen = subprocess.Popen(
                [sys.executable, *map(str, command)],
                env=self.environment,
                cwd=self.folder,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        process = Process(name, popen, log)
        self.processes.append(process)
        return process

    def node(
        self,
        name: str,
        parameters: Mapping[str, object] | None = None,
        handlers: str | None = None,
        arguments: Sequence[str] = (),
        options: Sequence[str] = (),
    ) -> Process:
        """Start the node of a node net; it keeps its journal in the folder of the test."""
        command: list[str | Path] = ["-m", "dineros.runtime.ros.node_main", self.folder / f"{name}.rtm.xmi"]
        if handlers is not None:
            file = self.folder / f"{name}_handlers.py"
            file.write_text(handlers)
            command += ["--handlers", file]
        command += [*options, "--ros-args"]
        for key, value in {"journal": self.folder / "journal", "seed": 1, **(parameters or {})}.items():
            text = str(value).lower() if isinstance(value, bool) else str(value)
            command += ["-p", f"{key}:={text}"]
        return self.start(name, *command, *arguments)

    def script(self, text: str) -> str:
        """Run a Python program to its end, and return what it prints."""
        file = self.folder / "script.py"
        file.write_text(text)
        done = subprocess.run(
            [sys.executable, file],
            env=self.environment,
            cwd=self.folder,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    def records(self, node: str, event: str | None = None) -> list[dict[str, Any]]:
        """Return what a node has recorded so far."""
        file = self.folder / "journal" / f"{node}.jsonl"
        lines = file.read_text().split("\n")[:-1] if file.exists() else []
        found = [json.loads(line) for line in lines]
        return [record for record in found if event is None or record["event"] == event]

    def fired(self, node: str, transition: str) -> list[dict[str, Any]]:
        return [record for record in self.records(node, "fire") if record["transition"] == transition]

    def wait(self, condition: Callable[[], Any], what: str) -> None:
        """Wait until something holds; say what the processes said where it does not."""
        end = time.monotonic() + PATIENCE
        while not condition():
            dead = [process.name for process in self.processes if process.popen.poll() not in (None, 0)]
            if dead or time.monotonic() > end:
                outputs = "\n".join(f"== {each.name}\n{each.output()}" for each in self.processes)
                pytest.fail(f"{what} did not happen; ended: {dead}\n{outputs}")
            time.sleep(0.02)

    def addresses(self) -> set[str]:
        """Return the local addresses of all sockets that the processes have open."""
        return set().union(*(bound_addresses(process.popen.pid) for process in self.processes))


@pytest.fixture
def reach() -> Reach:
    """How far the test's processes talk; tests override it."""
    return "memory"


@pytest.fixture
def ros(workspace: Path, tmp_path: Path, reach: Reach) -> Iterator[Ros]:
    """Processes on a domain of their own, ended at the end."""
    for part in split(post()):
        save(part, tmp_path / f"{part.node.id}.rtm.xmi")
    base = environment(workspace)
    with claimed_domain() as domain:
        made = Ros(tmp_path, ros_environment(tmp_path / "ros", domain, reach, base))
        yield made
        for process in made.processes:
            if process.popen.poll() is None:
                process.popen.send_signal(signal.SIGINT)
        for process in made.processes:
            try:
                process.popen.wait(10)
            except subprocess.TimeoutExpired:
                os.killpg(process.popen.pid, signal.SIGKILL)
                process.popen.wait()
    remove_abandoned()  # what those that were killed could not remove
