"""Processes that count points: killed, too slow, and never left behind."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from case_study.build import build
from dineros.analysis.sweeps import Axis, Figures, Grid
from dineros.analysis.sweeps.parts import Part
from dineros.analysis.sweeps.point import Job, PointDiedError, count
from dineros.analysis.sweeps.workers import (
    ATTEMPTS,
    PointProcess,
    PointProcesses,
    PointTimeoutError,
    local_figures,
)
from dineros.metamodel.files.xmi import xmi_bytes

COLORS = "RedObjects.tokens,BlueObjects.tokens,GreenObjects.tokens"


def job(tokens: int, timeout: float | None = None) -> Job:
    (point,) = Grid((Axis.parse(f"{COLORS}={tokens}"),))
    return Job(xmi_bytes(build()).decode(), point, timeout=timeout)


def small() -> Job:
    return job(0)


def large() -> Job:
    """Return what takes far longer than any of these tests."""
    return job(60)


def children(pid: int) -> list[int]:
    """Return the processes that a process, any thread of it, has started and not reaped."""
    found = []
    for thread in Path(f"/proc/{pid}/task").glob("*/children"):
        with suppress(OSError):
            found += [int(child) for child in thread.read_text().split()]
    return found


def runs(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


def wait_for(condition: Callable[[], object]) -> None:
    end = time.monotonic() + 20
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


@pytest.fixture
def process() -> Iterator[PointProcess]:
    made = PointProcess()
    yield made
    made.kill()


def pid_of(process: PointProcess) -> int:
    assert process._process is not None
    return process._process.pid


@pytest.mark.long
def test_each_point_has_a_process_of_its_own(process: PointProcess) -> None:
    here = count(small())
    process.start(small())
    first = process.answer(None)
    server = pid_of(process)
    process.start(small())
    again = process.answer(None)
    assert pid_of(process) == server
    for there in (first, again):
        assert (there.states, there.arcs, there.complete, there.error) == (here.states, here.arcs, True, "")
        assert there.peak_memory_bytes is not None
        assert 20 << 20 < there.peak_memory_bytes < 1 << 30


@pytest.mark.long
def test_a_killed_point_is_noticed_and_the_process_goes_on(process: PointProcess) -> None:
    process.start(large())
    server = pid_of(process)
    wait_for(lambda: children(server))
    (point,) = children(server)
    os.kill(point, signal.SIGKILL)
    with pytest.raises(PointDiedError, match="killed by SIGKILL"):
        process.answer(None)
    process.start(small())
    assert process.answer(None).complete
    assert pid_of(process) == server


@pytest.mark.long
def test_a_point_that_takes_too_long_ends_with_its_process(process: PointProcess) -> None:
    process.start(large())
    server = pid_of(process)
    wait_for(lambda: children(server))
    (point,) = children(server)
    with pytest.raises(PointTimeoutError):
        process.answer(0.1)
    process.kill()
    wait_for(lambda: not runs(server) and not runs(point))
    process.start(small())
    assert process.answer(None).complete


def test_a_killed_process_takes_its_point_along(process: PointProcess) -> None:
    process.start(large())
    server = pid_of(process)
    wait_for(lambda: children(server))
    (point,) = children(server)
    os.kill(server, signal.SIGKILL)
    with pytest.raises(PointDiedError):
        process.answer(None)
    wait_for(lambda: not runs(point))


class Fragile(PointProcess):
    """Dies a number of times."""

    deaths = 0

    def start(self, job: Job | Part) -> None:
        pass

    def answer(self, timeout: float | None) -> Figures:
        if type(self).deaths:
            type(self).deaths -= 1
            raise PointDiedError("it was killed by SIGKILL")
        return Figures(states=1, complete=True)


@pytest.mark.parametrize("deaths", range(ATTEMPTS + 1))
def test_a_point_is_tried_again_but_not_for_ever(deaths: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dineros.analysis.sweeps.workers.PointProcess", Fragile)
    monkeypatch.setattr(Fragile, "deaths", deaths)
    figures = PointProcesses().count(small())
    if deaths < ATTEMPTS:
        assert figures == Figures(states=1, complete=True)
    else:
        assert figures == Figures(error=f"its process died {ATTEMPTS} times: it was killed by SIGKILL")


@pytest.mark.long
def test_a_slow_point_holds_nobody_up_and_nothing_is_left_behind() -> None:
    before = set(children(os.getpid()))
    jobs = [job(60, timeout=1.0), small()]
    found = {done.timeout: figures for done, figures in local_figures(jobs, 2)}
    assert found[None].complete
    assert found[1.0] == Figures(seconds=1.0, error="timeout after 1 s")
    wait_for(lambda: set(children(os.getpid())) <= before)


@pytest.mark.long
def test_a_sweep_that_is_given_up_ends_its_processes() -> None:
    before = set(children(os.getpid()))
    figures = local_figures([small(), large(), large()], 2)
    assert next(figures)[1].complete
    started = set(children(os.getpid())) - before
    assert started
    figures.close()
    wait_for(lambda: not any(map(runs, started)))


def test_what_fails_is_an_error_of_its_point(process: PointProcess) -> None:
    (point,) = Grid((Axis.parse("RedObjects.tokens=-1"),))
    process.start(Job(small().model, point))
    figures = process.answer(None)
    assert not figures.complete
    assert "place 'RedObjects' holds -1 tokens" in figures.error
