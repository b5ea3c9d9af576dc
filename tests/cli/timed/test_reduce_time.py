"""`reduce --time`: the smaller net keeps its times; without it, a line says that they are left out."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.analysis.timed.nets import compile_timed_net
from dineros.metamodel.files import load
from tests.cli.conftest import Run

NET = """net line
pl p (1)
pl copy (1)
pl lock (1)
tr soon ]1/3,2] p copy lock?1 -> q
tr late [3,4] p copy -> r
tr never [0,1] r r2 -> p
tr again [0,0] q -> p copy
tr same [0,5] q -> p copy
pr soon > again same
"""


@pytest.fixture
def line(tmp_path: Path) -> Path:
    path = tmp_path / "line.net"
    path.write_text(NET)
    return path


def test_what_is_left_keeps_its_times(run: Run, line: Path, tmp_path: Path) -> None:
    small = tmp_path / "small.net"
    result = run("reduce", line, "--time", "--keep", "p", "--keep", "q", "-o", small)
    assert result.exit_code == 0
    assert f"{line} -> {small}: 6 -> 2 places, 5 -> 2 transitions" in result.stdout
    net = compile_timed_net(load(small))
    assert dict(zip(net.untimed.transitions, map(str, net.intervals), strict=True)) == {
        "soon": "]1/3,2]",
        "again": "[0,0]",
    }
    assert net.has_priorities and "left out" not in result.stdout
    for goal in ("q >= 1", "p + q >= 2", "p + q = 0"):
        asked = [run("find", one, "--time", "--marking", goal).exit_code for one in (line, small)]
        assert asked[0] == asked[1]


def test_what_is_kept(run: Run, line: Path, tmp_path: Path) -> None:
    small = tmp_path / "small.net"
    names = ("p", "q", "r", "copy", "lock", "late", "never", "same")
    told = json.loads(
        run(
            "reduce",
            line,
            "--time",
            "-o",
            small,
            "--json",
            *(word for name in names for word in ("--keep", name)),
        ).stdout
    )
    assert {one["elements"][0] for one in told["steps"]}.isdisjoint(names)
    assert told["times"]["transitions"] == 5 and told["reason"] == ""
    # A read arc stays one: a loop would disturb clocks.
    net = compile_timed_net(load(small))
    soon = net.untimed.transitions.index("soon")
    lock = net.untimed.places.index("lock")
    assert lock not in dict(net.take.row(soon)) and lock in dict(net.untimed.pre.row(soon))


def test_without_time_the_times_are_left_out_with_a_word(run: Run, line: Path, tmp_path: Path) -> None:
    line.write_text(NET.replace("pr soon > again same\n", ""))
    small = tmp_path / "small.net"
    result = run("reduce", line, "-o", small)
    assert "firing intervals are ignored (5 transitions" in result.stdout
    assert "--time keeps them" in result.stdout
    assert "[" not in small.read_text()
    told = json.loads(run("reduce", line, "-o", small, "--json").stdout)
    assert told["times"]["left_out"].startswith("firing intervals are ignored")


def test_what_time_does_not_go_with(run: Run, line: Path, tmp_path: Path) -> None:
    result = run("reduce", line, "--time", "--preserve", "deadlocks", "-o", tmp_path / "small.net")
    assert (result.exit_code, len(result.stderr.splitlines())) == (2, 1)
    result = run("reduce", line, "--time", "--keep", "x", "-o", tmp_path / "small.net")
    assert (result.exit_code, len(result.stderr.splitlines())) == (2, 1)
    assert not (tmp_path / "small.net").exists()
