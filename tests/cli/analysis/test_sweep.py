"""``dineros sweep``."""

from __future__ import annotations

import csv
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from case_study.build import build
from dineros.analysis.sweeps import Axis, Figures, Grid, Point
from dineros.analysis.sweeps.journal import Journal
from dineros.analysis.sweeps.sweep import journal_path
from dineros.metamodel import pn
from dineros.metamodel.build import flow
from dineros.metamodel.files import save
from tests.cli.conftest import Run
from tests.support.programs.commands import is_one_line_of_wrong_use
from tests.support.programs.processes import run_apart


@pytest.fixture
def cycle(tmp_path: Path) -> Path:
    """Return the file of a plain net: a token goes round."""
    net = pn.Net(id="cycle", pages=[pn.Page(id="page")])
    page = net.pages[0]
    places = [pn.Place(id="p", tokens=1, page=page), pn.Place(id="q", page=page)]
    for number in range(2):
        flow(places[number], pn.Transition(id=f"t{number}", page=page), places[1 - number])
    path = tmp_path / "cycle.pnml"
    save(net, path)
    return path


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.long
def test_a_table_of_a_system_model(run: Run, model: Path, tmp_path: Path) -> None:
    output = tmp_path / "out.csv"
    result = run(
        "sweep",
        model,
        *("--vary", "Words.tokens=0,2", "--signals", "none,io-enabled", "--overflow", "inhibitor,weighted"),
        *("--workers", "2", "-o", output),
    )
    assert (result.exit_code, result.stdout) == (0, f"{model} -> {output}: 8 points\n")
    table = rows(output)
    assert list(table[0]) == [
        "Words.tokens",
        "signals",
        "overflow",
        "reduced",
        "places",
        "transitions",
        "states",
        "arcs",
        "deadlocks",
        "reduced_states",
        "seconds",
        "peak_memory_bytes",
        "engine",
        "complete",
        "error",
    ]
    assert [row["Words.tokens"] for row in table] == ["0"] * 4 + ["2"] * 4
    assert [row["overflow"] for row in table[:4]] == ["inhibitor", "weighted"] * 2
    by_variant = {(row["Words.tokens"], row["signals"], row["overflow"]): row["states"] for row in table}
    for words in ("0", "2"):
        for signals in ("none", "io-enabled"):
            assert by_variant[words, signals, "inhibitor"] == by_variant[words, signals, "weighted"]
    assert all(row["complete"] == "true" and int(row["peak_memory_bytes"]) > 0 for row in table)


@pytest.mark.long
def test_json_and_a_plain_net(run: Run, cycle: Path, tmp_path: Path) -> None:
    output = tmp_path / "out.parquet"
    result = run(
        "sweep", cycle, "--vary", "p.tokens,q.tokens=0..2", "--reduced", "both", "-o", output, "--json"
    )
    assert json.loads(result.stdout) == {
        "model": str(cycle),
        "output": str(output),
        "figures": None,
        "points": 6,
        "resumed": 0,
        "unknown": 0,
    }


@pytest.mark.long
def test_figures_overwrite_no_table_of_somebody_else(run: Run, cycle: Path, tmp_path: Path) -> None:
    table, figures = tmp_path / "out.csv", tmp_path / "out.svg"
    table.write_text("precious\n")
    arguments = ("sweep", cycle, "--vary", "p.tokens=0..1", "-o", figures)
    result = run(*arguments)
    assert result.exit_code == 2
    assert result.stderr == (
        f"{table}: already exists, and the table of out.svg would overwrite it "
        "(choose another name for the figures, or move the existing file)\n"
    )
    assert table.read_text() == "precious\n"
    table.unlink()
    assert run(*arguments).exit_code == 0
    assert run(*arguments).exit_code == 0  # its own table is written again
    assert len(rows(table)) == 2


def test_points_that_stay_unknown_give_exit_status_3(run: Run, tmp_path: Path) -> None:
    model, output = tmp_path / "sorting.sym.xmi", tmp_path / "out.csv"
    save(build(), model)
    result = run("sweep", model, "--vary", "RedObjects.tokens=60", "--point-timeout", "0.01", "-o", output)
    assert (result.exit_code, result.stdout) == (3, f"{model} -> {output}: 1 point; 1 unknown\n")
    (row,) = rows(output)
    assert (row["states"], row["complete"], row["error"]) == ("", "false", "timeout after 0.01 s")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--vary", "Word.tokens=1"], "no element has the id or name 'Word' (did you mean 'Words'"),
        (["--vary", "Words.tokens=2..1"], "'2..1' is an empty range"),
        (["--vary", "Words.tokens=-1"], "with Words.tokens=-1, place 'Words' holds -1 tokens"),
        (["--vary", "Words.tokens=1", "--signals", "some"], "'some' is not one of none, "),
        (
            ["--vary", "Words.tokens=1", "--workers", "1", "--scheduler", "x"],
            "--workers counts processes of this machine",
        ),
        ([], "missing option '--vary'"),
    ],
)
def test_wrong_use_is_one_line(
    run: Run, model: Path, tmp_path: Path, arguments: list[str], says: str
) -> None:
    before = sorted(tmp_path.iterdir())
    result = run("sweep", model, *arguments, "-o", tmp_path / "out.csv")
    assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1)
    assert says in result.stderr
    assert sorted(tmp_path.iterdir()) == before


def test_variants_of_a_plain_net_are_wrong_use(run: Run, cycle: Path, tmp_path: Path) -> None:
    result = run("sweep", cycle, "--vary", "p.tokens=1", "--signals", "none", "-o", tmp_path / "out.csv")
    assert result.exit_code == 2
    assert "this is a plain net" in result.stderr


@pytest.mark.long
def test_an_interrupt_before_the_bar_moves_says_what_is_kept(
    run: Run, cycle: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    add = Journal.add

    def interrupted(journal: Journal, point: Point, figures: Figures) -> None:
        add(journal, point, figures)
        raise KeyboardInterrupt

    arguments = ["sweep", cycle, "--vary", "p.tokens=1..3", "--workers", "1", "-o", tmp_path / "out.csv"]
    monkeypatch.setattr(Journal, "add", interrupted)
    for points in (1, 2):
        result = run(*arguments)
        assert (result.exit_code, result.stderr) == (3, "")
        unknown, summary = result.stdout.splitlines()
        assert unknown.startswith("unknown: all other points: interrupted after ")
        assert summary.endswith(
            f": {points} of 3 points done and kept in {tmp_path}/out.csv.partial.jsonl; "
            "run the same command again to continue"
        )
    monkeypatch.undo()
    assert run(*arguments).stdout.endswith(": 3 points, 2 of them from the interrupted run\n")


# A shell's background job, as CI may be, starts with interrupts ignored.
LISTENING = (
    "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); "
    "from dineros.cli.main import main; main()"
)


@pytest.mark.long
def test_interrupted_then_killed_then_finished(run: Run, tmp_path: Path) -> None:
    model, output = tmp_path / "sorting.sym.xmi", tmp_path / "out.csv"
    save(build(), model)
    journal = tmp_path / "out.csv.partial.jsonl"
    colors = "RedObjects.tokens,BlueObjects.tokens,GreenObjects.tokens"
    arguments = [
        "sweep",
        model,
        "--vary",
        f"{colors}=0..3",
        "--signals",
        "none",
        "--workers",
        "1",
        "-o",
        output,
    ]

    def end_after(points: int, how: signal.Signals) -> tuple[int, str]:
        command = [sys.executable, "-c", LISTENING, *map(str, arguments)]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        end = time.monotonic() + 300  # a first run compiles
        while not journal.exists() or journal.read_bytes().count(b"\n") < 1 + points:
            assert time.monotonic() < end
            assert process.poll() is None
            time.sleep(0.01)
        process.send_signal(how)
        printed, _ = process.communicate()
        return process.returncode, printed

    status, printed = end_after(1, signal.SIGINT)
    assert status == 3
    # One point was done when the signal was sent; another may be by the time it arrives.
    kept = re.search(r": ([123]) of 4 points done and kept in .*; run the same .* to continue\n", printed)
    assert kept, printed
    status, printed = end_after(2, signal.SIGKILL)
    assert (status, printed) == (-signal.SIGKILL, "")
    assert not output.exists()
    result = run(*arguments)
    assert re.search(r": 4 points, ([23]) of them from the interrupted run$", result.stdout.strip())
    assert [row["states"] for row in rows(output)][:2] == ["8", "330112"]
    assert not journal.exists()


@pytest.mark.long
def test_memory_that_runs_out_is_said(cycle: Path, tmp_path: Path) -> None:
    output = tmp_path / "out.csv"
    many = ("--vary", "p.tokens=50000000", "--engine", "explicit")
    result = run_apart("sweep", cycle, *many, "--memory", "700M", "-o", output)
    assert result.exit_code == 3
    (row,) = rows(output)
    assert (row["complete"], row["error"]) == ("false", "memory ran out")


@pytest.mark.parametrize("kind", ["link", "pipe", "figures"])
def test_a_journal_from_somebody_else(run: Run, cycle: Path, tmp_path: Path, kind: str) -> None:
    output = tmp_path / "out.csv"
    arguments = ("sweep", cycle, "--vary", "p.tokens=1,2", "--workers", "1", "-o", output)
    journal = journal_path(output)
    if kind == "link":
        (tmp_path / "victim").write_bytes(b"")
        journal.symlink_to("victim")
    elif kind == "pipe":
        os.mkfifo(journal)
    else:
        grid = Grid((Axis.parse("p.tokens=1,2"),))
        with Journal(journal, "", grid, "auto", []) as begun, journal.open("ab") as file:
            file.write(b'{"point":"a","limits":[],"figures":{"complete":true,"nonsense":1}}\n')
            file.write(b'{"point":"a"}\n{"point":[],"limits":[],"figures":[]}\n' + b"[" * 100_000 + b"\n")
            file.flush()
            assert begun.kept() == {}
        return
    result = run(*arguments)
    said = "is a symbolic link, which is not followed here" if kind == "link" else "is not a plain file"
    assert is_one_line_of_wrong_use(result, said)
    assert kind == "pipe" or (tmp_path / "victim").read_bytes() == b""


PROGRAM = """
from dineros.metamodel import pn
from dineros.metamodel.build import flow

def build(lamps: int = 2):
    page = pn.Page(id="page")
    for number in range(lamps):
        off, on = pn.Place(id=f"off{number}", tokens=1, page=page), pn.Place(id=f"on{number}", page=page)
        flow(off, pn.Transition(id=f"press{number}", page=page), on)
    return pn.Net(id="lamps", pages=[page])
"""


@pytest.mark.long
def test_a_parameter_of_a_program_is_varied_like_a_feature(run: Run, tmp_path: Path) -> None:
    program, table = tmp_path / "lamps.py", tmp_path / "lamps.csv"
    program.write_text(PROGRAM, encoding="utf-8")
    result = run("sweep", program, "--vary", "lamps=1..4", "--workers", 1, "-o", table)
    assert result.exit_code == 0, result.stderr
    assert [row["lamps"] + ":" + row["states"] for row in rows(table)] == [
        f"{lamps}:{2**lamps}" for lamps in range(1, 5)
    ]
    both = tmp_path / "both.csv"
    result = run("sweep", program, "--vary", "lamps=1,2", "--vary", "off0.tokens=1..2", "-o", both)
    assert result.exit_code == 0, result.stderr
    assert [int(row["states"]) for row in rows(both)] == [2, 3, 4, 6]


@pytest.mark.parametrize(
    ("vary", "message"),
    [
        ("lamp=1..2", "build has no parameter 'lamp' (did you mean 'lamps'?)"),
        ("lamps=1,many", "lamps: takes a whole number, not 'many'"),
        ("off7.tokens=1..2", "no element has the id or name 'off7'"),
    ],
)
def test_what_a_program_does_not_have_is_refused(run: Run, tmp_path: Path, vary: str, message: str) -> None:
    program, table = tmp_path / "lamps.py", tmp_path / "lamps.csv"
    program.write_text(PROGRAM, encoding="utf-8")
    result = run("sweep", program, "--vary", vary, "-o", table)
    assert (result.exit_code, message in result.stderr, table.exists()) == (2, True, False), result.stderr


def test_a_file_has_no_parameters(run: Run, cycle: Path, tmp_path: Path) -> None:
    result = run("sweep", cycle, "--vary", "robots=1..2", "-o", tmp_path / "t.csv")
    assert result.exit_code == 2
    assert "robots is not a feature of an element" in result.stderr
