"""Nodes that begin their work together."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from dineros.runtime.application.gate import GATE, Gate, inherited_gate, new_gate
from dineros.runtime.application.supervisor import ProcessPlan, RestartPolicy, Supervisor

NODE = """
import os, pathlib, sys, time
from dineros.runtime.application.gate import inherited_gate
name, seconds, limit, status = sys.argv[1], float(sys.argv[2]), float(sys.argv[3]), int(sys.argv[4])
gate = inherited_gate()
time.sleep(seconds)
pathlib.Path(name + ".ready").touch()
if status:
    again = pathlib.Path(name + ".failed")
    if not again.exists():
        again.touch()
        sys.exit(status)
if gate is not None:
    assert gate.wait(limit, lambda: False) is (limit > 1)
found = ",".join(sorted(each.name for each in pathlib.Path(".").glob("*.ready")))
pathlib.Path(name + ".found").write_text(f"{gate is not None} {found}")
"""


def plan(folder: Path, name: str, *, after: float = 0, limit: float = 60, status: int = 0) -> ProcessPlan:
    command = [sys.executable, "-c", NODE, name, str(after), str(limit), str(status)]
    log = folder / f"{name}.log"
    return ProcessPlan(name, command, dict(os.environ), log, folder=folder, starts_together=True)


def found(folder: Path, *plans: ProcessPlan) -> dict[str, str]:
    """Run the nodes; return whether each had a gate, and which nodes were ready when it began its work."""
    with Supervisor(plans, RestartPolicy(delay=0.01)) as supervisor:
        deadline = time.monotonic() + 120
        while supervisor.poll():
            assert time.monotonic() < deadline
            time.sleep(0.01)
    return {each.name: (folder / f"{each.name}.found").read_text() for each in plans}


def test_nodes_begin_when_the_slowest_is_ready(tmp_path: Path) -> None:
    nodes = found(tmp_path, plan(tmp_path, "quick"), plan(tmp_path, "slow", after=1.5))
    assert nodes == dict.fromkeys(("quick", "slow"), "True quick.ready,slow.ready")


def test_a_node_that_fails_holds_up_no_other_and_starts_again_without_a_gate(tmp_path: Path) -> None:
    nodes = found(tmp_path, plan(tmp_path, "good"), plan(tmp_path, "bad", after=0.5, status=1))
    assert nodes == {"good": "True bad.ready,good.ready", "bad": "False bad.ready,good.ready"}


def test_a_node_waits_for_a_limited_time(tmp_path: Path) -> None:
    nodes = found(tmp_path, plan(tmp_path, "quick", limit=0.1), plan(tmp_path, "slow", after=3))
    assert nodes["quick"] == "True quick.ready"


def test_a_node_that_is_to_end_stops_waiting() -> None:
    with new_gate() as shared:
        gate = Gate(*(os.dup(number) for number in shared.descriptors))
        assert not gate.wait(60, lambda: True)
        assert gate.wait(60, lambda: True)  # passed before


def test_a_managed_node_leaves_at_once() -> None:
    with new_gate() as shared:
        managed, other = (Gate(*(os.dup(each) for each in shared.descriptors)) for _ in range(2))
        managed.leave()
        managed.leave()
    assert other.wait(60, lambda: False)


def test_programs_of_a_handler_do_not_hold_up_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    with new_gate() as shared:
        ends = [os.dup(number) for number in shared.descriptors]
        for end in ends:
            os.set_inheritable(end, True)
        monkeypatch.setenv(GATE, ",".join(map(str, ends)))
        gate = inherited_gate()
    assert gate is not None and GATE not in os.environ
    program = "import sys; sys.stdin.read()"
    with subprocess.Popen([sys.executable, "-c", program], stdin=subprocess.PIPE, close_fds=False):
        assert gate.wait(60, lambda: False)


@pytest.mark.parametrize("given", ["", "1", "a,b", "1,2,3", "-1,-1", "99999999999999999999,0"])
def test_an_invalid_gate_is_ignored(monkeypatch: pytest.MonkeyPatch, given: str) -> None:
    monkeypatch.setenv(GATE, given)
    assert inherited_gate() is None


def test_other_files_are_not_a_gate(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    with (tmp_path / "file").open("w") as file:
        monkeypatch.setenv(GATE, f"{file.fileno()},{file.fileno()}")
        assert inherited_gate() is None
        file.write("still open")
