"""Packages of clients that give up, or ask several times at once, and their tests from traces."""

from __future__ import annotations

import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

from dineros.generators import Options, generate
from dineros.generators.application.collecting import application_of
from dineros.generators.workspace.steps import ScriptError
from dineros.metamodel import sym
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.journal import JournalRecorder
from dineros.transformations.flattening.split import split
from tests.support.systems.ovens import oven


def recorded(model: sym.SystemModel, folder: Path, seconds: float) -> Path:
    recorder = partial(JournalRecorder, folder)
    application = LocalApplication(split(model), seed=1, recorder=recorder)
    application.open()
    application.run(lambda _: False, seconds)
    application.close()
    return folder


def test_ports_say_how_a_service_is_asked(tmp_path: Path) -> None:
    model = oven(2, 3, outstanding=2, timeout=0.5, tells=True)
    first, *_ = model.channels[0].clients  # type: ignore[attr-defined]
    first.outstanding, first.timedOut = 1, None
    said = {port.client: port.quality for node in application_of(model).nodes for port in node.ports}
    assert said == {
        None: "limit 3",
        "baker0": "gives up after 0.5 s",
        "baker1": "2 requests under way, gives up after 0.5 s: Late1",
    }
    generate(model, tmp_path / "ws", Options(source="bakery.sym.xmi"))
    readme = (tmp_path / "ws/src/baker1/README.md").read_text(encoding="utf-8")
    assert "| 2 requests under way, gives up after 0.5 s: Late1 |" in readme
    parameters = (tmp_path / "ws/src/bakery_bringup/config/baker1.yaml").read_text(encoding="utf-8")
    assert "# client of /bake at Ask1: 2 requests under way, gives up after 0.5 s: Late1" in parameters
    model.middleware = "ros1"
    said = {port.client: port.quality for node in application_of(model).nodes for port in node.ports}
    assert set(said.values()) == {""}


def test_tests_from_traces_with_several_requests_of_a_client(tmp_path: Path) -> None:
    """What a full history loses, they lose, too."""
    model = oven(2, 1, outstanding=3, again=False)
    run = recorded(model, tmp_path / "run", 1.0)
    assert '"event":"drop"' in (run / "oven.jsonl").read_text()
    generate(model, tmp_path / "ws", Options(source="bakery.sym.xmi", tests=(run,)))
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"],
        cwd=tmp_path / "ws/src/bakery_bringup",
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout


def test_a_trace_in_which_a_client_gives_up_makes_no_test(tmp_path: Path) -> None:
    """Nothing is there to wait by."""
    model = oven(2, 1, timeout=0.005, tells=True)
    run = recorded(model, tmp_path / "run", 0.3)
    with pytest.raises(ScriptError, match="gives up a request") as caught:
        generate(model, tmp_path / "ws", Options(source="bakery.sym.xmi", tests=(run,)))
    assert caught.value.location is not None
