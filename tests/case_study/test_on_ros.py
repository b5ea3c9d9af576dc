"""The case study on real ROS 2: six nodes and the simulated cell, each a process of its own."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.case_study.conftest import WORKSPACE

PATIENCE = 120.0

Seen = Callable[[], bool]


class Run:
    """`dineros run` on the workspace, in the background."""

    def __init__(self, workspace: Path, folder: Path, domain: int) -> None:
        self.traces = folder / "traces"
        self._output = (folder / "output.txt").open("w+")
        command = [sys.executable, "-m", "dineros.cli.main", "run", str(workspace)]
        command += ["--with", "python -m sorting_cell --visit 3", "--until", "Shown >= 3"]
        command += ["--timeout", str(PATIENCE), "--domain", str(domain), "--reach", "memory", "--monitor"]
        self.popen = subprocess.Popen(
            [*command, "--trace", str(self.traces)],
            stdin=subprocess.DEVNULL,
            stdout=self._output,
            stderr=subprocess.STDOUT,
            cwd=folder,
        )

    def events(self, name: str) -> list[dict[str, object]]:
        """Return what the supervisor did to a process."""
        path = self.traces / "supervisor.log.jsonl"
        lines = path.read_text().splitlines() if path.is_file() else []
        return [event for event in map(json.loads, lines) if event["name"] == name]

    def wait_for(self, seen: Seen) -> None:
        deadline = time.monotonic() + PATIENCE
        while not seen():
            assert self.popen.poll() is None, self.output()
            assert time.monotonic() < deadline, self.output()
            time.sleep(0.02)

    def finish(self) -> int:
        try:
            return self.popen.wait(PATIENCE)
        finally:
            if self.popen.poll() is None:
                self.popen.terminate()
                self.popen.wait(PATIENCE)

    def output(self) -> str:
        self._output.seek(0)
        return self._output.read()


def conformance(traces: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "dineros.cli.main", "conform", str(WORKSPACE), str(traces)]
    return subprocess.run(
        [*command, "--invariant", "PickRun + PlaceRun <= 1"], capture_output=True, text=True, check=False
    )


def is_there(process: object) -> bool:
    try:
        os.kill(int(str(process)), 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.long
def test_a_killed_node_goes_on_and_all_objects_are_sorted(
    workspace: Path, tmp_path: Path, ros_domain: int
) -> None:
    run = Run(workspace, tmp_path, ros_domain)
    trace = run.traces / "executor.jsonl"
    try:
        run.wait_for(lambda: trace.is_file() and "TPickSuccess" in trace.read_text(errors="replace"))
        (started,) = run.events("executor")
        os.kill(int(str(started["process"])), signal.SIGKILL)
    finally:
        status = run.finish()
    assert status == 0, run.output()
    assert "executor ended with signal SIGKILL" in run.output()
    assert "executor is started again" in run.output()
    assert "the condition holds; marked: " in run.output()
    assert "\nconformance: conforms, " in run.output()  # on the model that the workspace holds
    assert [event["event"] for event in run.events("executor")] == [
        "started",
        "failed",
        "restarted",
        "stopped",
    ]
    replayed = conformance(run.traces)
    said = [line for line in replayed.stderr.splitlines() if "by the rules of ros2" not in line]
    assert (replayed.returncode, said) == (0, []), replayed.stdout
    assert "holds throughout" in replayed.stdout
    shown = [json.loads(line) for line in (run.traces / "feedback.jsonl").open()]
    data = [
        fields
        for record in shown
        if record["event"] == "fire"
        for tokens in record["made"].values()
        for _, fields in tokens
    ]
    assert sorted(fields["color"] for fields in data) == ["blue", "green", "red"]
    assert len({fields["name"] for fields in data}) == 3
    names = ("selector", "controller", "synchronizer", "executor", "sensorics", "feedback", "program-1")
    assert not any(is_there(event["process"]) for name in names for event in run.events(name))
