"""`find` and `verify` with `--engine tina`, from the command line to programs and back.

The programs are stand-ins of ours, executables of the same command lines: TINA itself was never tried.
"""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

import pytest

from dineros.metamodel.records import Header, read_records
from tests.analysis.tina.stand_ins import FAULTS, install
from tests.cli.conftest import Run
from tests.support.programs.commands import is_one_line_of_wrong_use, lines, uses
from tests.support.programs.processes import run_apart

TINA = ("--engine", "tina")


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory, warm: Path) -> Path:
    """Return a folder with all programs, the same for all tests: they are tried once."""
    folder = tmp_path_factory.mktemp("programs")
    install(folder, warm=warm)
    return folder


@pytest.fixture(autouse=True)
def on_the_path(programs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", f"{programs}{os.pathsep}{os.environ['PATH']}")


class TestFind:
    @pytest.mark.long
    @uses("ends")
    def test_a_way_to_a_marking(self, run: Run, net: Path, tmp_path: Path) -> None:
        result = run("find", net, "--marking", "b >= 2 & a >= 1", *TINA)
        assert (result.exit_code, lines(result)) == (
            0,
            ["reachable: b >= 2 & a >= 1", "    1  t", "    2  t"],
        )
        output = tmp_path / "trace.jsonl"
        assert run("find", net, "--marking", "deadlock", "-o", output, *TINA).exit_code == 0
        header, *steps = read_records(output)
        assert isinstance(header, Header)
        assert (header.verdict, [step.transition for step in steps]) == ("reachable", ["t"] * 3)  # type: ignore[attr-defined]

    @pytest.mark.long
    @uses("ends")
    def test_a_transition(self, run: Run, net: Path) -> None:
        assert lines(run("find", net, "--enabled", "t", *TINA))[1:] == ["    1  t"]
        result = run("find", net, "--enabled", "u", *TINA)
        assert (result.exit_code, result.stdout) == (1, "unreachable: enabled(u)\n")

    @pytest.mark.long
    def test_names_are_those_of_the_system_model(self, run: Run, model: Path) -> None:
        result = run("find", model, "--enabled", "Listen", *TINA, "--json")
        assert result.exit_code == 0
        report = json.loads(result.stdout)
        assert (report["status"], report["states"]) == ("reachable", None)
        assert report["witness"]["steps"][-1]["transition"].endswith("Listen")
        assert any("signal Button becomes true" in step["text"] for step in report["witness"]["steps"])

    @pytest.mark.long
    @pytest.mark.parametrize(
        ("fault", "goal", "says"),
        [
            ("sift fails", "c >= 1", "sift failed with exit status 3: sift: something is wrong"),
            ("selt babbles", "c >= 1", "selt answers neither TRUE nor FALSE but 'Hello.'"),
            ("pathto babbles", "c >= 1", "pathto wrote a path that cannot be read: 'Hello.'"),
            ("pathto fails", "c >= 1", "pathto failed with exit status 3"),
            (
                "pathto goes astray",
                "c >= 1",
                "the path of pathto is not a firing sequence of the net: step 0: transition 'u'",
            ),
            ("sift miscounts", "b = 2", "the path of pathto does not reach the goal"),
        ],
    )
    @uses("large")
    def test_what_goes_wrong_is_refused(
        self,
        run: Run,
        net: Path,
        fault: str,
        goal: str,
        says: str,
        tmp_path: Path,
        monkeypatch: pytest.MonkeyPatch,
    ) -> None:
        monkeypatch.setenv(FAULTS, fault)
        output = tmp_path / "trace.jsonl"
        result = run("find", net, "--marking", goal, *TINA, "-o", output)
        assert is_one_line_of_wrong_use(result, says)
        assert result.stderr.endswith("another engine)\n") or "another engine may answer" in result.stderr
        assert not output.exists()

    @uses("grows")
    def test_time_ends_the_search_of_an_unbounded_net(self, run: Run, net: Path) -> None:
        result = run("find", net, "--marking", "a >= 2", *TINA, "--timeout", "1")
        assert result.exit_code == 3
        assert re.fullmatch(r"unknown: a >= 2 \(time ran out after [0-9.]+ s, at .*\)\n", result.stdout)

    @uses("ends")
    def test_memory_bounds_the_programs(self, net: Path) -> None:
        result = run_apart("find", net, "--marking", "a >= 2", *TINA, "--memory", "321M")
        assert result.exit_code == 3
        assert result.stdout.startswith("unknown: a >= 2 (memory ran out after ")

    @pytest.mark.parametrize(
        ("arguments", "says"),
        [
            (["--marking", "nix >= 2", *TINA], "--marking, column 1: no place is named 'nix'"),
            (["--enabled", "nix", *TINA], "--enabled: no transition is named 'nix'"),
            (
                ["--marking", "F a >= 2", *TINA],
                "--marking, column 1: the temporal operator F is not allowed here",
            ),
        ],
    )
    @uses("ends")
    def test_wrong_use(self, run: Run, net: Path, arguments: list[str], says: str) -> None:
        assert is_one_line_of_wrong_use(run("find", net, *arguments), says)


class TestVerify:
    @pytest.mark.long
    @uses("cycle")
    def test_a_formula_that_holds(self, run: Run, net: Path) -> None:
        result = run("verify", net, "--ltl", "G (idle + busy = 1)", *TINA)
        assert result.exit_code == 0
        assert result.stdout.startswith("holds: G (idle + busy = 1); 2 states, ")
        assert run("verify", net, "--ltl", "G F fired(stop)", "--fair", "start", *TINA).exit_code == 0

    @pytest.mark.long
    @uses("cycle")
    def test_a_run_for_ever(self, run: Run, net: Path, tmp_path: Path) -> None:
        output = tmp_path / "trace.jsonl"
        result = run("verify", net, "--ltl", "G F fired(stop)", *TINA)
        assert result.exit_code == 1
        assert lines(result)[-4] == "  forever:"
        assert lines(result)[-3].endswith("  wait")
        assert lines(result)[-2].startswith("  enabled forever, never fired")
        assert run("verify", net, "--ltl", "G F fired(stop)", *TINA, "-o", output).exit_code == 1
        header, *steps = read_records(output)
        assert isinstance(header, Header)
        assert header.loop is not None
        assert {step.transition for step in steps if step.sequence >= header.loop} == {"wait"}  # type: ignore[attr-defined]

    @pytest.mark.long
    @uses("ends")
    def test_a_run_that_ends_stays_there(self, run: Run, net: Path) -> None:
        result = run("verify", net, "--ltl", "G F fired(t)", *TINA)
        assert result.exit_code == 1
        assert lines(result)[1:] == ["    1  t", "    2  t", "    3  t", "  then no transition is enabled"]

    @uses("ends")
    def test_an_answer_stands_without_a_run(
        self, run: Run, net: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setenv(FAULTS, "selt shows nothing")
        output = tmp_path / "trace.jsonl"
        result = run("verify", net, "--ltl", "G b <= 1", *TINA, "-o", output)
        assert result.exit_code == 1
        assert result.stdout.startswith("violated: G b <= 1 (selt shows no run); 4 states, ")
        assert result.stderr == f"{output} is not written: there is no run to show\n"

    @pytest.mark.long
    @pytest.mark.parametrize(
        ("fault", "says"),
        [
            ("tina fails", "tina failed with exit status 3"),
            ("tina babbles", "the output of tina has no digest"),
            ("selt fails", "selt failed with exit status 3: selt: something is wrong"),
            ("selt babbles", "selt answers neither TRUE nor FALSE"),
            ("selt shows another run", "the counterexample of selt is not a run of the net: step 3"),
            ("selt shows times", "selt wrote a path that cannot be read: 't@1"),
            (
                "selt shows no transition",
                "selt wrote a path with 'nix', which is not a transition of the net",
            ),
        ],
    )
    @uses("ends")
    def test_what_goes_wrong_is_refused(
        self, run: Run, net: Path, fault: str, says: str, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setenv(FAULTS, fault)
        assert is_one_line_of_wrong_use(run("verify", net, "--ltl", "G b <= 1", *TINA), says)

    @uses("ends")
    def test_time_ends_it(self, run: Run, net: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv(FAULTS, "selt sleeps")
        result = run("verify", net, "--ltl", "G b <= 1", *TINA, "--timeout", "1")
        assert (result.exit_code, "(time ran out after " in result.stdout) == (3, True)

    @uses("grows")
    def test_an_unbounded_net_is_unknown(self, run: Run, net: Path) -> None:
        result = run("verify", net, "--ltl", "G a >= 1", *TINA)
        assert result.exit_code == 3
        assert "(tina does not find the net bounded)" in result.stdout

    @uses("ends")
    def test_ctl_is_refused(self, run: Run, net: Path) -> None:
        result = run("verify", net, "--ctl", "AG a >= 0", *TINA)
        assert is_one_line_of_wrong_use(result, "its program selt verifies LTL only (omit --engine")

    @uses("ends")
    def test_a_program_that_is_missing(
        self, run: Run, net: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        install(tmp_path / "some", "tina", "sift")
        monkeypatch.setenv("PATH", str(tmp_path / "some"))
        assert is_one_line_of_wrong_use(
            run("verify", net, "--ltl", "G a >= 0", *TINA), "selt is not on the PATH"
        )
        result = run("find", net, "--marking", "a >= 0", *TINA)
        assert is_one_line_of_wrong_use(result, "selt is not on the PATH (TINA is available")
