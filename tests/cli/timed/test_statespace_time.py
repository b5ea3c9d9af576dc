"""`--time`: questions about nets with their firing intervals, on the command line."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from tests.cli.conftest import Run

RACE = """net race
tr fast [1,2] p -> a
tr slow [3,4] p -> b
pl p (1)
"""
OPEN = RACE.replace("[1,2]", "]1,2]")


@pytest.fixture
def race(tmp_path: Path) -> Path:
    path = tmp_path / "race.net"
    path.write_text(RACE)
    return path


def test_counts_with_and_without_time(run: Run, race: Path) -> None:
    done = run("statespace", str(race), "--time", "--json")
    assert done.exit_code == 0
    space = json.loads(done.stdout)
    figures = {
        key: space[key] for key in ("construction", "classes", "edges", "markings", "deadlocks", "engine")
    }
    assert figures == {
        "construction": "W", "classes": 2, "edges": 1, "markings": 2, "deadlocks": 1, "engine": "classes",
    }  # fmt: skip
    assert json.loads(run("statespace", str(race), "--json").stdout)["states"] == 3


@pytest.mark.parametrize("classes", ["W", "M", "S", "E", "A"])
def test_each_construction_is_confirmed_by_counted_time(run: Run, race: Path, classes: str) -> None:
    done = run("statespace", str(race), "--time", "--classes", classes, "--confirm", "--json")
    assert done.exit_code == 0
    space = json.loads(done.stdout)
    assert (space["confirmed_by"], space["agrees"], space["markings"]) == ("integer", True, 2)


def test_time_as_a_counter(run: Run, race: Path) -> None:
    space = json.loads(run("statespace", str(race), "--time", "--engine", "integer", "--json").stdout)
    assert (space["engine"], space["markings"], space["classes"]) == ("integer", 2, None)


TINA = """#!/bin/sh
[ "$1 $2" = "-M -q" ] && grep -q 'tr fast .1,2. p -> a' "$3" || exit 9
echo '# net race, 3 places, 2 transitions, 4 arcs'
echo '# bounded, not live, not reversible'
echo '# classes 2 2 2 1 2'
echo '# transitions {edges} 2 2 0 1'
"""


@pytest.mark.parametrize(("edges", "status"), [(1, 0), (2, 3)])
def test_tina_counts_and_is_confirmed(
    run: Run, tmp_path: Path, race: Path, monkeypatch: pytest.MonkeyPatch, edges: int, status: int
) -> None:
    program = tmp_path / "tina"
    program.write_text(TINA.format(edges=edges))
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    done = run("statespace", str(race), "--time", "--classes", "M", "--engine", "tina", "--confirm", "--json")
    assert done.exit_code == status
    space = json.loads(done.stdout)
    assert (space["engine"], space["classes"], space["edges"]) == ("tina", 2, edges)
    assert (space["confirmed_by"], space["agrees"]) == ("classes", edges == 1)
    reason = "tina counts 2 edges, classes 1: one of the engines is wrong"
    assert space["reason"] == ("" if edges == 1 else reason)


def test_open_intervals_are_not_counted(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "open.net"
    path.write_text(OPEN)
    done = run("statespace", str(path), "--time", "--engine", "integer")
    assert done.exit_code == 2
    assert "the interval ]1,2] of transition fast is open" in done.stderr


def test_open_intervals_are_not_confirmed(run: Run, tmp_path: Path) -> None:
    """The figures of the classes are there all the same."""
    path = tmp_path / "open.net"
    path.write_text(OPEN)
    done = run("statespace", str(path), "--time", "--confirm", "--json")
    space = json.loads(done.stdout)
    assert (done.exit_code, space["classes"], space["agrees"]) == (0, 2, None)
    assert "the interval ]1,2] of transition fast is open" in space["not_confirmed"]


@pytest.mark.parametrize(
    "options",
    [
        ["--time", "--engine", "integer", "--classes", "A"],
        ["--classes", "W"],
        ["--engine", "integer"],
        ["--time", "--reduce"],
        ["--time", "--engine", "symbolic"],
    ],
)
def test_options_that_do_not_go_together(run: Run, race: Path, options: list[str]) -> None:
    done = run("statespace", str(race), *options)
    assert (done.exit_code, len(done.stderr.splitlines())) == (2, 1)
