"""``dineros run --simulate --times``: quantiles as text and as JSON, and wrong use."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.metamodel.files import save
from tests.analysis.timed_runs.test_simulating import overloaded
from tests.cli.conftest import Run
from tests.support.programs.commands import is_one_line_of_wrong_use
from tests.support.timed_systems.models import model_of


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    path = tmp_path / "robot.sym.xmi"
    save(model_of(overloaded(), 0.001), path)
    return path


def test_quantiles(run: Run, robot: Path) -> None:
    words = ("run", robot, "--simulate", "--times", "--seed", 3, "--timeout", 5)
    text = run(*words)
    assert text.exit_code == 0, text.output
    lines = text.stdout.splitlines()
    assert lines[0].startswith("callback log responds: ") and "99 %" in lines[0]
    assert any(line.startswith("tick to log: ") for line in lines)
    assert any(line.startswith("reader log.heard lost ") for line in lines)
    assert lines[-1].startswith(f"{robot}: simulated 5 s, seed 3: ")
    report = json.loads(run(*words, "--json").stdout)
    (chain,) = report["chains"]
    assert (chain["from"], chain["to"]) == ("tick", "log")
    assert 0.005 <= chain["least"] <= chain["median"] <= chain["q95"] <= chain["q99"] <= chain["greatest"]
    assert report["lost"]["log.heard"] > 100
    assert sum(chain["histogram"]["counts"]) == chain["count"]


def test_a_page(run: Run, robot: Path, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    words = ("run", robot, "--simulate", "--times", "--seed", 3, "--timeout", 5, "--report", page)
    assert run(*words).exit_code == 0
    text = page.read_text()
    assert text.count('class="bars"') == 3 and "<h2>tick to log</h2>" in text
    assert "reader log.heard lost " in text and "The beginning of the run" in text and "<svg" in text
    assert "time of the schedule" in text and "first cause" not in text


def test_wrong_use(run: Run, robot: Path, model: Path) -> None:
    for words, text in (
        (("--report", "page.html"), "--report needs --times"),
        (("--times", "--simulate", "--report", "page.txt"), "page.txt"),
        (("--times",), "--times needs --simulate"),
        (("--times", "--local"), "--times needs --simulate"),
        (("--times", "--simulate", "--monitor"), "--times cannot be combined with --monitor"),
    ):
        assert is_one_line_of_wrong_use(run("run", robot, *words), text), words
    assert is_one_line_of_wrong_use(
        run("run", model, "--simulate", "--times"), "latencies are defined for ROS 2 only"
    )
