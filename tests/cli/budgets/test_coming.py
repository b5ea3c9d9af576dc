"""Answers of a check are told on standard error as they come; the report follows on standard output."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.analysis.checks.question import Checked
from dineros.analysis.checks.unused import Use
from dineros.cli.searching import FOLLOW_AFTER
from tests.cli.conftest import Run
from tests.support.programs.commands import uses


@uses("grows")
def test_answers_are_told_once_before_the_report(
    run: Run, net: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(FOLLOW_AFTER, "0")
    result = run("-v", "check", net)
    grows = [line for line in result.stderr.splitlines() if "[unbounded]" in line]
    assert grows == ["so far: error: tokens grow without bound: b [unbounded]"]
    assert "so far" not in result.stdout
    assert "error: tokens grow without bound: b [1 step] [unbounded]" in result.stdout


@uses("grows")
def test_they_are_told_before_the_last_question(run: Run, net: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[str] = []
    at_the_question: list[list[str]] = []
    ask = Use.ask

    def asked(self: Use, checked: Checked) -> None:
        at_the_question.append(list(told))
        ask(self, checked)

    monkeypatch.setattr(Use, "ask", asked)
    monkeypatch.setattr("dineros.cli.presentation.findings.warn", told.append)
    monkeypatch.setenv(FOLLOW_AFTER, "0")
    run("-v", "check", net)
    assert at_the_question == [["so far: error: tokens grow without bound: b [unbounded]"]]


@pytest.mark.parametrize("more", [("--json",), ("--format", "sarif")])
@uses("grows")
def test_machines_get_the_report_alone(
    run: Run, net: Path, more: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(FOLLOW_AFTER, "0")
    assert run("check", net, *more).stderr == ""
