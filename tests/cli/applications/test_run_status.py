"""The exit status of a run in which a node was halted by a failure, or never came up."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Literal

import pytest

from dineros.cli.running import ros
from dineros.cli.running.running import Outcome
from dineros.cli.running.watching import Options
from dineros.metamodel.records import Checkpoint, Error, Fire, Start
from dineros.runtime.application.observer import Observer
from dineros.runtime.application.supervisor import ProcessEvent
from tests.cli.conftest import Run

HANDLERS = """
from dineros.runtime import Aside, Halt
def configure(net):
    if net.id == "talker":
        net.signal("Button").set(True)
        @net.handler("Say", policy={policy}())
        def say(firing):
            raise ValueError("no voice")
"""


@pytest.mark.parametrize("way", ["--local", "--simulate"])
@pytest.mark.parametrize(("policy", "status"), [("Halt", 1), ("Aside", 0)])
def test_a_node_that_a_failed_handler_halts(
    run: Run, model: Path, monkeypatch: pytest.MonkeyPatch, way: str, policy: str, status: int
) -> None:
    model.with_name("handlers.py").write_text(HANDLERS.format(policy=policy))
    monkeypatch.chdir(model.parent)
    result = run("run", model, way, "--timeout", 1)
    assert result.exit_code == status, result.output
    failure = "node talker is halted by a failure: ValueError: no voice (handler "
    assert (failure in result.stderr) == bool(status)
    if status:
        said = json.loads(run("run", model, way, "--timeout", 1, "--json").stdout)
        assert list(said["halted"]) == ["talker"]
        assert said["missing"] == []


def outcome(ending: str, observer: Observer, until: str | None = None) -> Outcome:
    models = [SimpleNamespace(node=SimpleNamespace(id=id)) for id in ("talker", "listener")]
    application: Any = SimpleNamespace(models=models)
    seen: Any = observer
    return Outcome(application, Options(until=until), ending, seen, None)  # type: ignore[arg-type]


def seen(*nodes: str, halted: str = "") -> Observer:
    observer = Observer()
    observer.see([Start(sequence=0, node=node) for node in nodes])
    if halted:
        observer.see([Error(sequence=1, node=halted, error="it broke", policy="halt")])
    return observer


@pytest.mark.parametrize("ending", ["timeout", "ended", "idle", "interrupted", "reached", "failed"])
def test_a_node_that_never_came_up(ending: str) -> None:
    assert outcome(ending, seen("talker")).status == 2
    assert outcome(ending, seen("talker")).missing == ["listener"]
    assert outcome(ending, seen("talker", "listener")).missing == []


def test_an_interruption_before_any_node_came_up_is_no_failure() -> None:
    assert outcome("interrupted", seen()).status == 0
    assert outcome("timeout", seen()).status == 2


def test_a_halted_node_does_not_hide_a_worse_status() -> None:
    both = "talker", "listener"
    assert outcome("timeout", seen(*both, halted="talker")).status == 1
    assert outcome("reached", seen(*both, halted="talker"), "Noted >= 1").status == 1
    assert outcome("timeout", seen(*both, halted="talker"), "Noted >= 1").status == 3
    assert outcome("failed", seen(*both, halted="talker")).status == 2
    assert outcome("timeout", seen(*both)).status == 0


def test_a_node_that_goes_on_from_a_checkpoint_has_come_up() -> None:
    observer = Observer()
    observer.see([Checkpoint(sequence=0, node=node) for node in ("talker", "listener")])
    assert outcome("timeout", observer).status == 0


@pytest.mark.parametrize("has_acted", [False, True])
def test_a_node_whose_process_cannot_start_has_not_come_up(has_acted: bool) -> None:
    """It records its first marking before it has what ROS lacks; one that acted before only failed later."""
    observer = seen("talker", "listener")
    observer.refused.add("listener")
    if has_acted:
        observer.see([Fire(sequence=1, node="listener", transition="Listen", change={"Heard": -1})])
    assert outcome("timeout", observer).missing == ([] if has_acted else ["listener"])
    assert outcome("timeout", observer).status == (0 if has_acted else 2)


@pytest.mark.parametrize("ending", ["failed", "stopped"])
def test_the_supervisor_reports_which_processes_cannot_start(
    tmp_path: Path, ending: Literal["failed", "stopped"], capsys: pytest.CaptureFixture[str]
) -> None:
    """A run may end while a process has its first marking and not yet what ROS refuses: it is stopped."""
    observer, announcer = Observer(), SimpleNamespace(tell=lambda _: None)
    with (tmp_path / "log").open("w") as log:
        tell = ros._teller(log, announcer, {}, observer)  # type: ignore[arg-type]
        for name, status in (("talker", 2), ("listener", 1)):
            tell(ProcessEvent(0.0, name, ending, 1, status, "no such interface"))
    assert observer.refused == {"talker"}
    assert "talker ended with exit status 2: no such interface" in capsys.readouterr().err
