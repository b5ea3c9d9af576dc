"""A search that would continue forever, or take all memory, ends as promised, with what was answered.

How late it ends is measured by `random_budgets`; here a machine may be as slow as it likes.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import click
import pytest

from dineros.cli.options import Invocation
from dineros.cli.searching import Limits, Search, Whereabouts
from dineros.cli.supervising import ASKED, ENDED, Watch
from tests.cli.budgets.random_budgets import SLACK_PART, SLACK_SECONDS, random_runs
from tests.cli.conftest import Run
from tests.support.programs.bags import write_bag
from tests.support.programs.commands import uses

# The clock stands still until the search is stuck, and then time is up, however slow the machine is.
STUCK = """
import os, signal, sys, tempfile, time
from pathlib import Path
from dineros.cli import supervising
from dineros.cli.main import main
from dineros.cli.searching import Limits

folder = tempfile.TemporaryDirectory()
flag = Path(folder.name, "stuck")

def stuck(*_, **__):
    flag.touch()
    if {said!r}:
        print({said!r}, file=sys.stderr, flush=True)
    kept = []
    while True:
        try:
            {does}
        except KeyboardInterrupt:
            pass

signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background has it ignored
if any(text.startswith("--timeout") for text in sys.argv):
    Limits.spent = property(lambda _: 100.0 if flag.exists() else 10.0)
import {module} as module
module.{name} = stuck
main()
"""
SLEEPS = "time.sleep(600)"
TAKES = "kept.append(bytearray(b'x' * (4 << 20))); time.sleep(0.001)"
DIES = "os.kill(os.getpid(), signal.SIGSEGV)"
LAYOUT = ("dineros.analysis.explicit.layout", "flows_and_bounds")
BOUNDS = ("dineros.analysis.symbolic.engine", "encode")


def start(
    *arguments: object, does: str = SLEEPS, where: tuple[str, str] = BOUNDS, said: str = ""
) -> subprocess.Popen[str]:
    script = STUCK.format(said=said, does=does, module=where[0], name=where[1])
    command = [sys.executable, "-c", script, *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def ended(process: subprocess.Popen[str]) -> tuple[int, str, str]:
    output, errors = process.communicate(timeout=300)
    return process.returncode, output, errors


def test_a_check_that_is_stuck_says_what_it_knows(model: Path) -> None:
    status, output, errors = ended(start("check", model, "--timeout", "50", "-v"))
    unknown, summary = output.splitlines()
    assert status == 3
    assert unknown.startswith("unknown: everything else: time ran out after ")
    assert unknown.endswith(" s, at bounds of places")
    assert summary == f"{model}: 0 found, 1 proved, 1 unknown"
    assert "proved: every clause can be true\n" in errors


@pytest.mark.parametrize("seconds", [0.5, 1.0, 4.0, 5.0, 8.0, 20.0, 60.0, 3600.0])
def test_a_search_is_ended_early_enough_for_the_promise(seconds: float) -> None:
    asked, ended = (seconds * factor + more for factor, more in (ASKED, ENDED))
    promised = seconds + max(SLACK_PART * seconds, SLACK_SECONDS)
    assert seconds < asked < ended < promised - 0.19


@pytest.mark.long
@pytest.mark.parametrize("format", ["json", "sarif", "junit"])
def test_machines_read_it_too(model: Path, format: str) -> None:
    status, output, errors = ended(start("check", model, "--timeout", "50", "--format", format))
    assert (status, errors) == (3, "")
    assert "everything else: time ran out after " in output
    if format == "json":
        assert json.loads(output)["proved"] == ["every clause can be true"]


@pytest.mark.long
@pytest.mark.parametrize(
    ("arguments", "where", "says"),
    [
        (["statespace"], BOUNDS, "reason                 time ran out after "),
        (["verify", "--ctl", "AG EF a >= 1"], BOUNDS, "unknown: AG EF a >= 1 (time ran out "),
        (["verify", "--ltl", "G a >= 0"], LAYOUT, "unknown: G a"),
        (
            ["find", "--enabled", "t"],
            LAYOUT,
            "unknown: enabled(t)",
        ),
        (
            ["verify", "--properties", "ReachabilityDeadlock"],
            LAYOUT,
            "unknown: ReachabilityDeadlock; time ran out after ",
        ),
    ],
)
@uses("large")
def test_every_question_says_where_it_was(
    net: Path, arguments: list[str], where: tuple[str, str], says: str
) -> None:
    status, output, errors = ended(start(arguments[0], net, "--timeout=50", *arguments[1:], where=where))
    assert (status, errors) == (3, "")
    assert says in output


@uses("ends")
def test_a_file_is_written_as_a_whole_or_not_at_all(net: Path, tmp_path: Path) -> None:
    where = ("dineros.analysis.reductions", "reduce")
    output = tmp_path / "small.net"
    process = start("reduce", net, "-o", output, "--timeout=50", where=where)
    status, printed, errors = ended(process)
    assert (status, printed) == (3, "")
    assert errors.startswith(f"{output} is not written: time ran out after ")
    assert not output.exists()


@uses("ends")
def test_memory_is_kept_by_all_processes_together(net: Path) -> None:
    status, output, errors = ended(start("statespace", net, "--memory=400M", does=TAKES))
    assert (status, errors) == (3, "")
    assert "reason                 memory ran out after " in output


@uses("ends")
def test_without_anything_to_say_it_is_one_line(net: Path) -> None:
    where = ("dineros.cli.analysing", "load_named")
    status, output, errors = ended(start("statespace", net, "--memory=400M", does=TAKES, where=where))
    assert (status, output) == (3, "")
    assert errors.startswith("dineros: memory ran out after ")
    assert errors.endswith(
        "at reading the model; the process may use 400 MiB (allow more with --memory, or make the model "
        "smaller)\n"
    )


@pytest.mark.long
@pytest.mark.parametrize("budget", ["--timeout=50", "--memory=400M"])
@pytest.mark.parametrize("command", ["import", "diff", "narrow", "conform"])
def test_a_recording_that_cannot_be_read_in_time_ends_in_one_line(
    command: str, budget: str, tmp_path: Path, run: Run
) -> None:
    bag, model = write_bag(tmp_path / "bag", [("/a", 1)]), tmp_path / "a.sym.xmi"
    assert run("import", "--bag", bag, "-o", model).exit_code == 0
    output = tmp_path / "b.sym.xmi"
    words = ["import", "-o", output] if command == "import" else [command, model]
    where = ("dineros.observation.recordings.storages", "opened")
    does = SLEEPS if "timeout" in budget else TAKES
    status, printed, errors = ended(start(*words, "--bag", bag, budget, does=does, where=where))
    why = "time" if "timeout" in budget else "memory"
    assert status == 3
    assert f"{why} ran out after " in printed + errors
    assert "at reading bag" in printed + errors
    assert not output.exists()


@pytest.mark.long
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_it_gives_the_same_report(model: Path, number: signal.Signals) -> None:
    process = start("check", model, said="stuck now")
    assert process.stderr is not None
    assert process.stderr.readline() == "stuck now\n"
    process.send_signal(number)
    status, output, _ = ended(process)
    assert status == 3
    assert output.startswith("unknown: everything else: interrupted after ")
    assert output.endswith(f"{model}: 0 found, 1 proved, 1 unknown\n")


def test_what_fails_because_it_was_interrupted_is_no_failure() -> None:
    """As Python 3.11 makes an error of its own of what interrupts it while it makes a class."""

    def work(search: Search) -> int:
        search.draft(lambda ending: 3)
        try:
            os.kill(os.getpid(), signal.SIGTERM)
            time.sleep(600)
        except KeyboardInterrupt as interrupt:
            raise RuntimeError("error calling __set_name__") from interrupt
        return 0

    with click.Context(click.Command("check"), obj=Invocation()):
        assert Watch(Limits(time.monotonic(), None, None)).run(work) == 3


def test_off_a_terminal_it_says_now_and_then_where_it_is(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with click.Context(click.Command("check"), obj=Invocation(verbosity=1)):
        watch = Watch(Limits(0.0, None, None))
    spent = iter([3.0, 10.5, 11.0, 20.2, 30.4])
    monkeypatch.setattr(Limits, "spent", property(lambda _: next(spent)))
    watch.at = Whereabouts("saturation", "12 nodes, 1 MiB")
    for _ in range(5):
        watch.show()
    assert capsys.readouterr().err == (
        "10 s: saturation (12 nodes, 1 MiB)\n20 s: saturation (12 nodes, 1 MiB)\n"
        "30 s: saturation (12 nodes, 1 MiB)\n"
    )


def test_a_search_that_crashes_asks_for_a_report(model: Path) -> None:
    status, output, errors = ended(start("check", model, does=DIES))
    assert status == 2
    assert "unknown: everything else: the worker process ended early: signal 11" in output
    assert errors.startswith("dineros: unexpected ApartDiedError: ")
    assert "please report it" in errors


def test_called_from_python_an_interrupt_gives_the_report(
    run: Run, model: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("dineros.analysis.symbolic.engine.encode", interrupted)
    result = run("check", model)
    assert result.exit_code == 3
    assert result.stdout.startswith("unknown: everything else: interrupted after ")


@pytest.mark.long
def test_random_budgets_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DINEROS_QUIET_COMPILATION", "1")
    for ran in random_runs(4, seed=os.getpid(), most_seconds=2.0):
        assert [fault for fault in ran.faults if not fault.endswith(" s")] == [], (ran, ran.printed)
        assert ran.took < ran.seconds + 120


@pytest.mark.parametrize(("seconds", "why"), [(1.0, "time ran out"), (None, "interrupted")])
def test_an_engine_that_looks_at_its_time_too_late_is_told_to_end(seconds: float | None, why: str) -> None:
    """It says that it was interrupted; what is reported is whether that was Ctrl-C or the promise."""
    search = Search(Limits(began=0.0, seconds=seconds, memory=None))
    assert search.reason("interrupted").startswith(f"{why} after ")
