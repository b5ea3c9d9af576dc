"""Whole sweeps: on this machine, and on a Dask cluster that loses a worker."""

from __future__ import annotations

import csv
import importlib.util
import os
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

from case_study.build import build
from dineros.analysis.model.subject import subject_of
from dineros.analysis.questions.state_space import state_space
from dineros.analysis.sweeps import Axis, Grid, Outcome, Progress, SweepError, SweepInterrupt, sweep
from dineros.analysis.sweeps.journal import Journal
from dineros.analysis.sweeps.sweep import journal_path
from dineros.analysis.sweeps.tables import Row
from dineros.metamodel import pn
from dineros.metamodel.build import flow
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.settings import apply

COLORS = tuple(Axis.parse(f"{color}Objects.tokens=0..1") for color in ("Red", "Blue", "Green"))
RED = Grid((Axis.parse("RedObjects.tokens=0..1"),), ("none", "input-enabled"))
TOKENS = Grid((Axis.parse("p.tokens=1..4"),), (None,), (None,))

needs_cluster = pytest.mark.skipif(
    importlib.util.find_spec("distributed") is None and not os.environ.get("CI"),
    reason="dask.distributed is not installed",
)


def counts(outcome: Outcome) -> list[Row]:
    """Return what does not depend on the machine."""
    measured = ("seconds", "peak_memory_bytes")
    return [{name: row[name] for name in row if name not in measured} for row in outcome.rows]


def cycle() -> pn.Net:
    net = pn.Net(id="cycle", pages=[pn.Page(id="page")])
    places = [pn.Place(id=id, tokens=tokens, page=net.pages[0]) for id, tokens in (("p", 1), ("q", 0))]
    for number in range(2):
        flow(places[number], pn.Transition(id=f"t{number}", page=net.pages[0]), places[1 - number])
    return net


@pytest.mark.long
def test_the_table_of_the_case_study_comes_out(local: Outcome) -> None:
    states = {
        tuple(row[f"{color}Objects.tokens"] for color in ("Red", "Blue", "Green")): row["states"]
        for row in local.rows
    }
    assert (states[1, 0, 0], states[1, 1, 0], states[1, 1, 1]) == (432, 9640, 330112)
    assert list(states) == sorted(states)  # grid order, whichever point was finished first
    assert (local.resumed, local.unknown) == (0, 0)


@pytest.mark.long
def test_every_point_is_told_and_the_file_holds_the_rows(tmp_path: Path) -> None:
    output = tmp_path / "sweep.csv"
    told: list[Progress] = []
    outcome = sweep(cycle(), TOKENS, output, workers=2, progress=told.append)
    assert [progress.done for progress in told] == list(range(5))
    with output.open(newline="") as file:
        written = list(csv.DictReader(file))
    assert [row["states"] for row in written] == [str(row["states"]) for row in outcome.rows]
    assert [path.name for path in tmp_path.iterdir()] == ["sweep.csv"]


@pytest.mark.long
def test_a_row_says_what_a_state_space_of_its_own_says(tmp_path: Path) -> None:
    model = build()
    grid = Grid((Axis.parse("GreenObjects.tokens=0"),), ("io-enabled",), ("inhibitor",), (False, True))
    plain, reduced = sweep(model, grid, tmp_path / "sweep.csv", workers=1).rows
    apply(model, "GreenObjects.tokens=0")
    alone = state_space(subject_of(model, "io-enabled", "inhibitor").net)
    for name in ("places", "transitions", "states", "arcs", "deadlocks", "engine", "complete"):
        assert plain[name] == getattr(alone, name)
    assert isinstance(reduced["places"], int)
    assert reduced["places"] < alone.places
    assert (reduced["states"], reduced["deadlocks"]) == (alone.states, alone.deadlocks)
    assert isinstance(reduced["reduced_states"], int) and alone.states is not None
    assert reduced["reduced_states"] < alone.states
    assert (reduced["arcs"], plain["reduced_states"]) == (None, None)


def test_a_plain_net_is_swept_as_well(tmp_path: Path) -> None:
    outcome = sweep(cycle(), TOKENS, tmp_path / "sweep.parquet", workers=1)
    assert [row["states"] for row in outcome.rows] == [2, 3, 4, 5]
    assert {row["signals"] for row in outcome.rows} == {None}


@pytest.fixture(scope="module")
def local(tmp_path_factory: pytest.TempPathFactory) -> Outcome:
    """Return the sweep over none or one object of each colour, counted here."""
    return sweep(build(), Grid(COLORS, ("none",)), tmp_path_factory.mktemp("local") / "sweep.csv", workers=2)


class StopError(Exception):
    """Ends a sweep on its way."""


@pytest.mark.long
def test_an_interrupted_sweep_goes_on_where_it_was(tmp_path: Path) -> None:
    output = tmp_path / "sweep.csv"

    def stop(progress: Progress) -> None:
        if progress.done == 2:
            raise StopError

    with pytest.raises(StopError):
        sweep(cycle(), TOKENS, output, workers=1, progress=stop)
    assert not output.exists()
    journal = journal_path(output)
    journal.write_bytes(journal.read_bytes() + b'{"point": "torn')
    told: list[Progress] = []
    outcome = sweep(cycle(), TOKENS, output, workers=1, progress=told.append)
    assert told[0] == Progress(done=2, points=4, resumed=2, unknown=0)
    assert outcome.resumed == 2
    assert not journal.exists()
    assert counts(outcome) == counts(sweep(cycle(), TOKENS, tmp_path / "again.csv", workers=1))


def interrupted(*_: object) -> None:
    raise KeyboardInterrupt


def before_a_point_is_noted(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Journal, "add", interrupted)


def before_a_line_is_written(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Journal, "_append", interrupted)


def before_a_line_is_on_the_disk(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(os, "fsync", interrupted)


def after_a_point_is_noted(patch: pytest.MonkeyPatch) -> None:
    add = Journal.add
    patch.setattr(Journal, "add", lambda *arguments: interrupted(add(*arguments)))


@pytest.mark.long
@pytest.mark.parametrize(
    ("moment", "kept"),
    [
        (before_a_point_is_noted, 1),
        (before_a_line_is_written, 1),
        (before_a_line_is_on_the_disk, 2),
        (after_a_point_is_noted, 2),
    ],
)
def test_an_interrupt_tells_what_the_next_run_finds(
    moment: Callable[[pytest.MonkeyPatch], None], kept: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    output = tmp_path / "sweep.csv"

    def arm(progress: Progress) -> None:
        if progress.done == 1:
            moment(monkeypatch)

    with pytest.raises(SweepInterrupt) as interrupt:
        sweep(cycle(), TOKENS, output, workers=1, progress=arm)
    monkeypatch.undo()
    assert interrupt.value.progress == Progress(done=kept, points=4, resumed=0, unknown=0)
    told: list[Progress] = []
    outcome = sweep(cycle(), TOKENS, output, workers=1, progress=told.append)
    assert told[0] == Progress(done=kept, points=4, resumed=kept, unknown=0)
    assert counts(outcome) == counts(sweep(cycle(), TOKENS, tmp_path / "again.csv", workers=1))


@pytest.mark.long
def test_an_interrupt_of_the_first_point_that_is_noted_loses_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    output = tmp_path / "sweep.csv"
    after_a_point_is_noted(monkeypatch)
    with pytest.raises(SweepInterrupt) as interrupt:
        sweep(cycle(), TOKENS, output, workers=1)
    monkeypatch.undo()
    assert interrupt.value.progress.done == 1
    assert sweep(cycle(), TOKENS, output, workers=1).resumed == 1


def test_a_sweep_of_another_model_does_not_take_the_points(tmp_path: Path) -> None:
    output = tmp_path / "sweep.csv"

    def stop(progress: Progress) -> None:
        if progress.done == 1:
            raise StopError

    with pytest.raises(StopError):
        sweep(cycle(), TOKENS, output, workers=1, progress=stop)
    other = cycle()
    apply(other, "q.tokens=3")
    with pytest.raises(SweepError, match="another sweep"):
        sweep(other, TOKENS, output, workers=1)
    assert journal_path(output).exists()


@pytest.mark.long
def test_points_without_an_answer_are_rows_with_the_reason(tmp_path: Path) -> None:
    # The first point of all compiles the engines, which takes longer than the limit allows.
    sweep(build(), Grid((Axis.parse("RedObjects.tokens=0"),)), tmp_path / "warm.csv", workers=1)
    grid = Grid((Axis.parse("RedObjects.tokens,BlueObjects.tokens,GreenObjects.tokens=0,60"),))
    outcome = sweep(build(), grid, tmp_path / "sweep.csv", workers=1, timeout=8)
    small, large = outcome.rows
    assert (small["states"], small["complete"], small["error"]) == (21, True, "")
    assert (large["states"], large["complete"], large["error"]) == (None, False, "timeout after 8 s")
    assert outcome.unknown == 1


def test_an_output_that_cannot_be_written_is_refused_before_the_work(tmp_path: Path) -> None:
    for output in (tmp_path / "sweep.txt", tmp_path / "missing" / "sweep.csv", tmp_path):
        with pytest.raises(DinerosError):
            sweep(build(), RED, output)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.long
@needs_cluster
def test_a_cluster_that_loses_a_worker_counts_the_same(local: Outcome, tmp_path: Path) -> None:
    from distributed import LocalCluster

    cluster = LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, host="127.0.0.1"
    )
    with cluster:
        victims = [worker.pid for worker in cluster.workers.values()]
        killed: list[int] = []

        def kill_one(progress: Progress) -> None:
            if progress.done == 2 and not killed:
                killed.append(victims[0])
                os.kill(victims[0], signal.SIGKILL)

        outcome = sweep(
            build(),
            Grid(COLORS, ("none",)),
            tmp_path / "cluster.csv",
            scheduler=cluster.scheduler_address,
            progress=kill_one,
        )
        assert killed
        assert [worker.pid for worker in cluster.workers.values()] != victims  # the nanny started another one
    assert counts(outcome) == counts(local)
    assert outcome.unknown == 0


@needs_cluster
def test_a_scheduler_that_is_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dineros.analysis.sweeps.cluster.PATIENCE", 0.5)
    with pytest.raises(SweepError, match=r"no scheduler at 'tcp://127\.0\.0\.1:9'"):
        sweep(build(), RED, tmp_path / "sweep.csv", scheduler="tcp://127.0.0.1:9")
    assert list(tmp_path.iterdir()) == []
