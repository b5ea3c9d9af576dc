"""Answers about clients that share a service state their assumption, in each format."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.metamodel.files import save
from tests.cli.conftest import Run
from tests.support.ros2_systems.shared_services import shared_model

ASSUMES = (
    "fewer than 10 responses to other clients of service /battery arrive"
    " while a response waits for the executor of clients user0, user1"
)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "shared.sym.xmi"
    save(shared_model(), path)
    return path


def test_a_check_states_the_assumption_of_its_proofs_in_each_format(
    run: Run, file: Path, tmp_path: Path
) -> None:
    report = tmp_path / "report.html"
    shown = run("check", file, "-o", report)
    assert f"assumes: {ASSUMES}\n" in shown.stdout and "0 found" in shown.stdout
    assert ASSUMES in report.read_text()
    assert json.loads(run("check", file, "--json").stdout)["assumes"] == [ASSUMES]
    assert f'name="assumes" value="{ASSUMES}"' in run("check", file, "--format", "junit").stdout
    notes = json.loads(run("check", file, "--format", "sarif").stdout)["runs"][0]["invocations"][0]
    assert f"assumes: {ASSUMES}" in [each["message"]["text"] for each in notes["toolExecutionNotifications"]]


@pytest.mark.parametrize(
    ("asked", "is_named"),
    [
        (("verify", "--ctl", "AG !deadlock"), True),
        (("find", "--marking", "Asked >= 9"), True),
        (("verify", "--ctl", "EF (Battery.client.user0.requests >= 1)"), False),
    ],
)
def test_answers_that_a_lost_response_could_change_state_it(
    run: Run, file: Path, asked: tuple[str, ...], is_named: bool
) -> None:
    command, *options = asked
    told = json.loads(run(command, file, *options, "--json").stdout)
    assert told["status"] != "unknown"
    assert told.get("assumes") == ([ASSUMES] if is_named else None)
