"""The journal: what an interrupted sweep keeps."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.analysis.sweeps import Axis, Figures, Grid, SweepError
from dineros.analysis.sweeps.journal import Journal

GRID = Grid((Axis.parse("A.tokens=0..3"),))
POINTS = list(GRID)
DONE = Figures(places=2, transitions=1, states=10**30, arcs=3, seconds=0.25, engine="symbolic", complete=True)
UNKNOWN = Figures(error="timeout after 5 s")


def journal(
    path: Path, *, model: str = "m", grid: Grid = GRID, limits: list[float | None] | None = None
) -> Journal:
    return Journal(path, model, grid, "auto", limits or [None, 5.0])


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Return a journal with two finished points and one that ended without an answer."""
    path = tmp_path / "out.csv.partial.jsonl"
    with journal(path) as written:
        written.add(POINTS[0], DONE)
        written.add(POINTS[1], UNKNOWN)
        written.add(POINTS[2], DONE)
    return path


def test_finished_points_are_there_again(path: Path) -> None:
    with journal(path) as read:
        assert read.finished == {POINTS[0].key: DONE, POINTS[1].key: UNKNOWN, POINTS[2].key: DONE}


def test_other_limits_give_points_without_an_answer_another_chance(path: Path) -> None:
    with journal(path, limits=[None, 50.0]) as read:
        assert set(read.finished) == {POINTS[0].key, POINTS[2].key}


@pytest.mark.long
def test_a_torn_last_line_is_dropped_wherever_it_was_torn(path: Path) -> None:
    content = path.read_bytes()
    kept = content[: content.rstrip(b"\n").rfind(b"\n") + 1]
    for end in range(len(kept), len(content)):
        path.write_bytes(content[:end])
        with journal(path) as read:
            assert set(read.finished) == {POINTS[0].key, POINTS[1].key}
            read.add(POINTS[3], DONE)
        with journal(path) as again:
            assert set(again.finished) == {POINTS[0].key, POINTS[1].key, POINTS[3].key}


def test_a_torn_first_line_is_an_empty_journal(path: Path) -> None:
    header = path.read_bytes().partition(b"\n")[0]
    for end in range(len(header)):
        path.write_bytes(header[:end])
        with journal(path) as read:
            assert read.finished == {}
            read.add(POINTS[0], DONE)


def test_a_damaged_line_costs_only_its_point(path: Path) -> None:
    lines = path.read_bytes().split(b"\n")
    lines[1] = b"\0" * len(lines[1])
    path.write_bytes(b"\n".join(lines))
    with journal(path) as read:
        assert set(read.finished) == {POINTS[1].key, POINTS[2].key}


@pytest.mark.parametrize(
    "figures",
    [{"complete": True, "states": "x"}, {"complete": 1}, {"complete": True, "arcs": True}, {"other": 1}, []],
)
def test_figures_of_other_types_are_counted_again(path: Path, figures: object) -> None:
    lines = path.read_text(encoding="utf-8").splitlines()
    entry = json.loads(lines[1])
    path.write_text("\n".join([lines[0], json.dumps(entry | {"figures": figures}), *lines[2:], ""]))
    with journal(path) as read:
        assert set(read.finished) == {POINTS[1].key, POINTS[2].key}


@pytest.mark.parametrize(
    "other", [{"model": "n"}, {"grid": Grid((Axis.parse("A.tokens=0..4"),))}], ids=["model", "grid"]
)
def test_the_journal_of_another_sweep_is_refused_and_left_alone(path: Path, other: dict[str, object]) -> None:
    before = path.read_bytes()
    with pytest.raises(SweepError, match="is the journal of another sweep"):
        journal(path, **other)  # type: ignore[arg-type]
    assert path.read_bytes() == before


def test_a_file_of_somebody_else_is_refused_and_left_alone(path: Path) -> None:
    for content in (b"my notes", b"my notes\n", b"[1]\n"):
        path.write_bytes(content)
        with pytest.raises(SweepError, match="is the journal of another sweep"):
            journal(path)
        assert path.read_bytes() == content


def test_two_sweeps_cannot_write_the_same_journal(path: Path) -> None:
    with journal(path), pytest.raises(SweepError, match="is running"):
        journal(path)
    with journal(path) as read:
        assert len(read.finished) == 3


def test_a_journal_without_points_is_not_left_behind(tmp_path: Path) -> None:
    with journal(tmp_path / "journal"):
        pass
    assert list(tmp_path.iterdir()) == []


def test_what_is_kept_is_what_the_file_holds(path: Path) -> None:
    with journal(path) as read:
        read.add(POINTS[3], DONE)
        assert read.kept() == read.finished
        with path.open("ab") as other:
            other.write(b'{"point": "torn')
        assert read.kept() == read.finished
    with journal(path, limits=[None, 50.0]) as read:
        assert set(read.kept()) == {POINTS[number].key for number in (0, 2, 3)}


def test_types_are_looked_up_once_for_all_lines(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with journal(path):
        pass
    monkeypatch.setattr(
        "dineros.analysis.sweeps.point.get_type_hints", None
    )  # 2 ms for each of a million lines
    with journal(path) as read:
        assert len(read.finished) == 3
