"""One run of a program: its limits, and that nothing of it stays."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.tina.programs import (
    LONGEST_ARGUMENT,
    TinaBudgetError,
    TinaError,
    workplace,
)
from dineros.metamodel.files import load

NET = CompiledNet.build({"a": 1}, [("t", {"a": 1})])


def program(folder: Path, monkeypatch: pytest.MonkeyPatch, script: str) -> None:
    path = folder / "sift"
    path.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
    path.chmod(0o755)
    monkeypatch.setenv("PATH", str(folder), prepend=":")


def test_it_runs_where_the_net_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program(tmp_path, monkeypatch, 'pwd; cat "$1"; echo careful >&2')
    with workplace(NET) as place:
        printed = place.run("sift", "net.net")
        assert load(place.folder / "net.net").pages
    assert printed.stdout.startswith(f"{place.folder}\n")
    assert "tr t a ->" in printed.stdout
    assert printed.stderr == "careful\n"
    assert not place.folder.exists()


def test_time_ends_it_with_what_it_started(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program(tmp_path, monkeypatch, f"sleep 60 & echo $! > {tmp_path}/started; wait")
    with (
        workplace(NET, Budget(seconds=1)) as place,
        pytest.raises(TinaBudgetError, match="sift took more than 1 s"),
    ):
        place.run("sift")
    stat = Path("/proc", (tmp_path / "started").read_text().strip(), "stat")
    for _ in range(100):
        if (
            not stat.exists() or stat.read_text().rpartition(")")[2].split()[0] == "Z"
        ):  # ended, not yet reaped
            break
        time.sleep(0.05)
    else:
        pytest.fail("what the program started still runs")


def test_memory_is_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The limit may reach a program when it runs already, so that it waits for it."""
    program(tmp_path, monkeypatch, "while [ $(ulimit -v) = unlimited ]; do :; done; ulimit -v")
    with workplace(NET, Budget(1 << 30, seconds=20)) as place:
        assert place.run("sift").stdout == "1048576\n"


@pytest.mark.parametrize("limit", [1 << 30, None])
@pytest.mark.parametrize(
    "ending",
    [
        "echo 'libc.so.6: failed to map segment from shared object' >&2; exit 127",
        "echo 'Fatal Python error: _PyRuntimeState_Init: memory allocation failed' >&2; exit 1",
        "kill -SEGV $$",
    ],
)
def test_too_little_memory_is_no_failure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, limit: int | None, ending: str
) -> None:
    """It is the end of a budget; without a limit of ours, it is a failure."""
    program(tmp_path, monkeypatch, ending)
    with workplace(NET, Budget(limit)) as place, pytest.raises(TinaError) as caught:
        place.run("sift")
    assert isinstance(caught.value, TinaBudgetError) == (limit is not None)


@pytest.mark.parametrize(
    ("script", "says"),
    [
        ("exit 7", "sift failed with exit status 7: no message"),
        ("echo first; echo last; exit 1", "sift failed with exit status 1: last"),
        ("echo out; echo wrong >&2; exit 1", "sift failed with exit status 1: wrong"),
        ("kill -11 $$", "sift failed with exit status -11"),
    ],
)
def test_a_failure_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, script: str, says: str) -> None:
    program(tmp_path, monkeypatch, script)
    with workplace(NET) as place, pytest.raises(TinaError, match=says) as error:
        place.run("sift")
    assert error.value.hint


def test_what_is_no_program_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program(tmp_path, monkeypatch, "")
    (tmp_path / "sift").write_bytes(b"\x7fELF nothing")
    with workplace(NET) as place, pytest.raises(TinaError, match="sift does not run: Exec format error"):
        place.run("sift")


def test_an_argument_that_no_program_takes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program(tmp_path, monkeypatch, "")
    with workplace(NET) as place, pytest.raises(TinaError, match="too long for the command line of sift"):
        place.run("sift", "x" * (LONGEST_ARGUMENT + 1))
