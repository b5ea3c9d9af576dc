"""In which order findings are printed, shown and written."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from dineros.analysis.checks.check import QUESTIONS
from dineros.analysis.checks.question import Checked
from dineros.analysis.witnesses.findings import Finding, worst_first
from tests.cli.conftest import Run

FOUND = [
    Finding("queue-overflow", "note", (), "a note"),
    Finding("unused-topic", "warning", (), "a warning"),
    Finding("queue-overflow", "error", (), "an error"),
    Finding("unused-topic", "warning", ("x",), "another warning"),
    Finding("unbounded", "error", (), "another error"),
]
WORST_FIRST = ["an error", "another error", "a warning", "another warning", "a note"]


def test_those_of_one_severity_keep_their_order() -> None:
    assert [each.message for each in worst_first(FOUND)] == WORST_FIRST


@pytest.mark.long
def test_errors_stand_before_notes_in_every_form(
    run: Run, model: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def ask(self: object, checked: Checked) -> None:
        checked.report.findings[:] = FOUND

    monkeypatch.setattr(type(QUESTIONS[-1]), "ask", ask)
    report = model.with_name("report.html")
    said = run("check", model, "-v", "-o", report)
    assert said.exit_code == 1
    order = re.compile("|".join(sorted(WORST_FIRST, key=len, reverse=True)))
    page = report.read_text()
    for text in (
        said.stdout + said.stderr.partition("proved")[0],
        page[page.index("<main>") :],
        json.dumps(
            [each["message"] for each in json.loads(run("check", model, "--json").stdout)["findings"]]
        ),
        run("check", model, "--format", "junit").stdout,
    ):
        assert list(dict.fromkeys(order.findall(text))) == WORST_FIRST
