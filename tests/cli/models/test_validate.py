"""``dineros validate``."""

from __future__ import annotations

import contextlib
import json
import os
import pty
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.conftest import Run


def test_a_valid_model(run: Run, model: Path) -> None:
    result = run("validate", model)
    assert (result.exit_code, result.stdout, result.stderr) == (0, f"{model}: valid\n", "")


def test_all_that_is_wrong_with_a_file(run: Run, broken: Path) -> None:
    """Where a file holds no model for several reasons, all are said, one line each; elsewhere the first."""
    wrong = broken.with_name("wrong.sym.xmi")
    wrong.write_text(broken.read_text().replace(" tokens=", " token=").replace(" limit=", " limits="))
    result = run("validate", wrong)
    assert (result.exit_code, result.stdout) == (2, "")
    said = result.stderr.splitlines()
    assert len(said) > 1
    assert all(line.startswith(f"{wrong}:") and "has no feature" in line for line in said)
    (line,) = run("flatten", wrong, "-o", wrong.with_suffix(".pnml")).stderr.splitlines()
    assert f"; and {len(said) - 1} more error" in line


def test_quiet_prints_violations_only(run: Run, model: Path, broken: Path) -> None:
    assert run("validate", model, "-q").stdout == ""
    assert run("validate", broken, "-q").stdout.count("\n") == 1


def test_verbose_says_what_is_done_on_stderr(run: Run, model: Path) -> None:
    result = run("validate", model, "-v", "--set", "Words.tokens=2")
    assert result.stderr == f"read {model}\nset Words.tokens=2\n"
    assert result.stdout == f"{model}: valid\n"


def test_a_violation_names_file_line_fix_and_constraint(run: Run, broken: Path) -> None:
    result = run("validate", broken)
    violation, summary = result.stdout.splitlines()
    assert result.exit_code == 1
    line = next(
        number
        for number, text in enumerate(broken.read_text(encoding="utf-8").splitlines(), start=1)
        if 'limit="0"' in text
    )
    assert re.fullmatch(rf"{re.escape(str(broken))}:{line}: error: .+ \(.+\) \[[\w-]+\]", violation)
    assert summary == f"{broken}: 1 error, 0 warnings"


def test_warnings_count_when_strict(run: Run, doubtful: Path) -> None:
    result = run("validate", doubtful)
    assert result.exit_code == 0
    assert ": warning: " in result.stdout
    assert result.stdout.endswith("0 errors, 1 warning\n")
    assert run("validate", doubtful, "--strict").exit_code == 1


def test_json_of_a_valid_model(run: Run, model: Path) -> None:
    result = run("validate", model, "--json")
    assert result.exit_code == 0
    assert json.loads(result.stdout) == {
        "model": str(model),
        "errors": 0,
        "warnings": 0,
        "violations": [],
    }


def test_json_of_violations(run: Run, broken: Path) -> None:
    result = run("validate", broken, "--json")
    report = json.loads(result.stdout)
    assert result.exit_code == 1
    assert list(report) == ["model", "errors", "warnings", "violations"]
    (violation,) = report["violations"]
    assert list(violation) == ["constraint", "severity", "element", "message", "fix", "file", "line"]
    assert violation["severity"] == "error"
    assert violation["file"] == str(broken)
    assert violation["line"] > 1
    assert violation["message"]
    assert violation["fix"]


def test_settings_change_what_is_checked(run: Run, model: Path, broken: Path) -> None:
    assert run("validate", model, "--set", "Chatter.publisher.Said.limit=0").exit_code == 1
    assert run("validate", broken, "--set", "Chatter.publisher.Said.limit=1").exit_code == 0
    assert run("validate", broken).exit_code == 1


@pytest.mark.parametrize(
    ("setting", "part"),
    [
        ("Wrods.tokens=2", "no element has the id or name 'Wrods' (did you mean 'Words'?)"),
        ("Words.tokens=two", "takes a whole number"),
        ("Words", "ELEMENT.FEATURE=VALUE"),
        ("Say.clause=Button &", ""),
    ],
)
def test_a_bad_setting_is_wrong_use(run: Run, model: Path, setting: str, part: str) -> None:
    result = run("validate", model, "--set", setting)
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith(f"{model}: ")
    assert part in result.stderr
    assert result.stderr.count("\n") == 1


def test_list_names_every_constraint_once(run: Run) -> None:
    result = run("validate", "--list")
    names = [line.split()[0] for line in result.stdout.splitlines()]
    assert result.exit_code == 0
    assert len(names) > 10
    assert len(set(names)) == len(names)
    listed = json.loads(run("validate", "--list", "--json").stdout)["constraints"]
    assert [constraint["constraint"] for constraint in listed] == names


def test_a_found_violation_is_listed(run: Run, broken: Path) -> None:
    (violation,) = json.loads(run("validate", broken, "--json").stdout)["violations"]
    assert violation["constraint"] in run("validate", "--list").stdout


@pytest.mark.parametrize("no_color", [None, "1"])
def test_a_terminal_gets_colours_and_whole_lines(broken: Path, no_color: str | None) -> None:
    environment = {name: value for name, value in os.environ.items() if name != "NO_COLOR"}
    environment |= {"TERM": "xterm-256color", "COLUMNS": "40"} | ({"NO_COLOR": no_color} if no_color else {})
    command = [sys.executable, "-m", "dineros.cli.main", "validate", str(broken)]
    terminal, side = pty.openpty()
    with subprocess.Popen(command, stdout=side, stderr=subprocess.PIPE, env=environment) as process:
        os.close(side)
        printed = b""
        # Linux reports an error, not the end, when the last writer has closed.
        with contextlib.suppress(OSError):
            while chunk := os.read(terminal, 4096):
                printed += chunk
    os.close(terminal)
    assert process.returncode == 1
    assert (b"\x1b[" in printed) == (no_color is None)
    plain = re.sub(rb"\x1b\[[0-9;]*m", b"", printed).decode()
    assert plain.count("\r\n") == 2
    assert plain.startswith(f"{broken}:")
