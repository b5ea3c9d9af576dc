"""``tools/audit.py`` around a pip-audit that answers as the real one does."""

import json
from pathlib import Path

import pytest

from tools.audit import main


@pytest.fixture
def program(tmp_path: Path) -> Path:
    return tmp_path / "pip-audit"


def answer(program: Path, script: str) -> str:
    program.write_text(f'#!/usr/bin/env bash\nreport="${{@: -1}}"; report=${{report#--output=}}\n{script}\n')
    program.chmod(0o755)
    return str(program)


def test_each_hole_is_one_line(program: Path, capsys: pytest.CaptureFixture[str]) -> None:
    holes = [{"id": "PYSEC-1", "fix_versions": ["1.1", "2.0"]}, {"id": "PYSEC-2", "fix_versions": []}]
    sound = {"name": "b", "version": "3", "vulns": []}
    report = {"dependencies": [{"name": "a", "version": "1.0", "vulns": holes}, sound], "fixes": []}
    assert main(answer(program, f"echo '{json.dumps(report)}' >\"$report\"; exit 1"), "lock.txt") == 1
    assert capsys.readouterr().out == (
        "a 1.0: PYSEC-1 (fixed in 1.1, 2.0)\n"
        "a 1.0: PYSEC-2 (fixed in no release)\n"
        "2 packages, 2 known vulnerabilities\n"
    )


def test_what_was_not_asked_for_is_named(program: Path, capsys: pytest.CaptureFixture[str]) -> None:
    report = {"dependencies": [{"name": "a", "skip_reason": "not found"}], "fixes": []}
    assert main(answer(program, f"echo '{json.dumps(report)}' >\"$report\"")) == 0
    assert capsys.readouterr().out == "a: not found\n1 packages, 0 known vulnerabilities\n"


def test_without_the_service_one_line_says_so(program: Path, capsys: pytest.CaptureFixture[str]) -> None:
    failing = "echo 'requests.exceptions.ConnectionError: Max retries exceeded' >&2; exit 1"
    assert main(answer(program, failing)) == 0
    assert capsys.readouterr().out == "Not audited: the advisory service cannot be reached from here\n"


def test_other_failures_are_not_hidden(program: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(answer(program, "echo 'no such option' >&2; exit 2")) == 2
    assert "no such option" in capsys.readouterr().err
