"""``dineros trace``, and the pages of ``check`` and the figures of ``sweep``, through the command line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from dineros.cli.main import main
from dineros.metamodel.files import save
from dineros.metamodel.records import Header, write_records
from tests.support.programs.commands import is_one_line_of_wrong_use
from tests.support.systems.talker import talker
from tests.views.samples import lasso, save_run

Run = Callable[..., Result]


@pytest.fixture
def run() -> Run:
    return lambda *arguments: CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.fixture
def witness(tmp_path: Path) -> Path:
    return lasso().save(tmp_path / "lasso.jsonl")


@pytest.fixture
def greeting(tmp_path: Path) -> Path:
    path = tmp_path / "greeting.sym.xmi"
    save(talker(), path)
    return path


@pytest.mark.long
@pytest.mark.parametrize(
    ("suffix", "start"),
    [
        (".html", b"<!doctype html>"),
        (".svg", b"<svg "),
        (".png", b"\x89PNG"),
        (".mcap", b"\x89MCAP"),
        (".csv", b"step,time"),
    ],
)
def test_every_format(run: Run, witness: Path, tmp_path: Path, suffix: str, start: bytes) -> None:
    output = tmp_path / f"out{suffix}"
    result = run("trace", witness, "-o", output)
    assert (result.exit_code, result.stdout) == (0, f"lasso.jsonl -> {output}: 9 steps\n")
    assert output.read_bytes().startswith(start)


def test_without_output_the_steps_are_listed(run: Run, witness: Path) -> None:
    shown = run("trace", witness).stdout.splitlines()
    assert len(shown) == 10
    assert shown[2].split() == ["3", "selector", "SelectRed"]
    assert shown[7].strip() == "forever:"


def test_a_folder_of_a_run(run: Run, tmp_path: Path) -> None:
    folder = save_run(tmp_path / "run")
    shown = run("trace", folder).stdout
    assert "0.500 s" not in shown.splitlines()[0]
    assert "GetControl[2].TGet" in shown
    files = sorted(folder.glob("*.jsonl"))
    assert run("trace", *files).stdout == shown


def test_find_then_trace(run: Run, greeting: Path, tmp_path: Path) -> None:
    found, picture = tmp_path / "found.jsonl", tmp_path / "found.svg"
    assert run("find", greeting, "--marking", "Noted >= 2", "-o", found).exit_code == 0
    assert run("trace", found, "-o", picture).exit_code == 0
    text = picture.read_text(encoding="utf-8")
    for what in (
        "Button",
        "chatter",
        "publisher Said ≤ 10",
        "subscriber Heard ≤ 10",
        "Noted",
        "Listen",
        "talker",
    ):
        assert what in text, what


def test_the_model_that_is_gone_is_said_and_can_be_given(run: Run, greeting: Path, tmp_path: Path) -> None:
    found = tmp_path / "found.jsonl"
    run("find", greeting, "--marking", "Noted >= 1", "-o", found)
    moved = greeting.rename(tmp_path / "other.sym.xmi")
    result = run("trace", found, "-o", tmp_path / "a.svg")
    assert result.exit_code == 0
    assert "does not exist" in result.stderr
    assert "≤" not in (tmp_path / "a.svg").read_text(encoding="utf-8")
    result = run(
        "trace", found, "--model", moved, "--set", "Chatter.publisher.Said.limit=7", "-o", tmp_path / "b.svg"
    )
    assert result.stderr == ""
    assert "publisher Said ≤ 7" in (tmp_path / "b.svg").read_text(encoding="utf-8")


def test_the_settings_of_the_trace_are_those_of_its_model(run: Run, greeting: Path, tmp_path: Path) -> None:
    found = tmp_path / "found.jsonl"
    run("find", greeting, "--set", "Chatter.publisher.Said.limit=3", "--marking", "Noted >= 1", "-o", found)
    run("trace", found, "-o", tmp_path / "a.svg")
    assert "publisher Said ≤ 3" in (tmp_path / "a.svg").read_text(encoding="utf-8")


@pytest.mark.long
def test_comparing(run: Run, witness: Path, tmp_path: Path) -> None:
    other = lasso(differs=True).save(tmp_path / "other.jsonl")
    result = run("trace", witness, "--compare", other, "-o", tmp_path / "both.html")
    assert result.stdout.startswith(
        "first divergence at step 8: 'signal Danger becomes true', but 'signal Blue"
    )
    same = run("trace", witness, "--compare", witness, "-o", tmp_path / "both.html")
    assert same.stdout.startswith("lasso.jsonl and lasso.jsonl do not differ")


def test_wrong_use_is_one_line_and_leaves_nothing(run: Run, witness: Path, tmp_path: Path) -> None:
    nonsense = tmp_path / "nonsense.jsonl"
    nonsense.write_text("nonsense\n")
    headless = tmp_path / "headless.jsonl"
    headless.write_text('{"sequence":0,"event":"stop"}\n')
    other = tmp_path / "other.jsonl"
    write_records(other, [Header(sequence=0, kind="run", model="another")])
    output = tmp_path / "out.html"
    cases = [
        ((nonsense, "-o", output), "nonsense.jsonl:1: no JSON"),
        ((headless, "-o", output), "it does not begin with a header"),
        ((tmp_path / "missing.jsonl", "-o", output), "cannot be read"),
        ((tmp_path, "-o", output), "jsonl"),
        ((witness, other, "-o", output), "a witness cannot be combined with other traces"),
        (
            (*sorted(save_run(tmp_path / "run").glob("*.jsonl")), other, "-o", output),
            "is of the model 'another'",
        ),
        ((witness, "-o", tmp_path / "out.txt"), "'.txt' is not a format of traces"),
        ((witness, "-o", tmp_path / "out.csv", "--compare", witness), "--compare requires"),
        ((witness, "-o", output, "--fold"), "--fold requires .svg or .png"),
        ((witness, witness, "--follow"), "--follow takes one FILE or folder"),
        ((witness, "-o", tmp_path / "no" / "folder.html"), "cannot be written"),
    ]
    for arguments, text in cases:
        result = run("trace", *arguments)
        assert is_one_line_of_wrong_use(result, text), (arguments, result.stdout, result.stderr)
    assert not output.exists()
    assert not list(tmp_path.glob("out.*"))


@pytest.mark.long
def test_a_report_of_a_check(run: Run, greeting: Path, tmp_path: Path) -> None:
    output = tmp_path / "report.html"
    result = run("check", greeting, "--set", "Chatter.subscriber.Heard.limit=2", "-o", output)
    assert result.exit_code == 1
    assert result.stdout.endswith(f"-> {output}\n")
    text = output.read_text(encoding="utf-8")
    for what in ("queue-overflow", "can overflow: a message is lost", 'class="lane queue"', 'data-id="Heard"',
                 "never overflows", "fully-enabled", "Step by step"):  # fmt: skip
        assert what in text, what


@pytest.mark.long
def test_figures_of_a_sweep_and_the_table_beside(run: Run, greeting: Path, tmp_path: Path) -> None:
    output = tmp_path / "figures.svg"
    result = run(
        "sweep", greeting, "--vary", "Words.tokens=1..2", "--signals", "none,fully-enabled", "-o", output
    )
    assert result.exit_code == 0, result.stderr
    assert "fully-enabled" in output.read_text(encoding="utf-8")
    assert (tmp_path / "figures.csv").read_text().count("\n") == 5
