"""What `check` says of callbacks that wait for each other, in every format."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.metamodel.files import save
from docs.examples.callbacks.models import battery
from tests.cli.conftest import Run

TWO_THREADS = ("--set", "monitor.executor=multi", "--set", "monitor.threads=2")
CIRCLE = [
    "callback OnTimer",
    "the response of service level to client monitor",
    "the default callback group of node net monitor",
]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Return the file of a monitor that asks a battery for its level, all in the groups of the nodes."""
    save(battery(), tmp_path / "battery.sym.xmi")
    return tmp_path / "battery.sym.xmi"


def test_a_circle_in_every_format(run: Run, path: Path) -> None:
    result = run("check", path, "--witnesses", *TWO_THREADS)
    assert result.exit_code == 1
    text = f"{CIRCLE[0]} waits for {CIRCLE[1]}, which waits for {CIRCLE[2]}, which {CIRCLE[0]} has"
    assert (
        f"error: {text} [7 steps] [callback-deadlock]\n    1  the timer of callback OnTimer ticks"
        in result.stdout
    )

    found = json.loads(run("check", path, *TWO_THREADS, "--json").stdout)["findings"]
    (finding,) = [each for each in found if each["rule"] == "callback-deadlock"]
    assert (finding["message"], finding["circle"]) == (text, CIRCLE)
    assert finding["elements"] == ["OnTimer", "Level", "monitor"]
    assert finding["witness"]["steps"][1]["text"] == "AskLevel"

    log = json.loads(run("check", path, *TWO_THREADS, "--format", "sarif").stdout)["runs"][0]
    (number,) = [
        n for n, rule in enumerate(log["tool"]["driver"]["rules"]) if rule["id"] == "callback-deadlock"
    ]
    (result_,) = [each for each in log["results"] if each["ruleIndex"] == number]
    assert result_["message"]["text"] == text
    assert len(result_["relatedLocations"]) == 2
    assert len(result_["codeFlows"][0]["threadFlows"][0]["locations"]) == 7
    assert text in run("check", path, *TWO_THREADS, "--format", "junit").stdout


def test_no_circle_with_a_group_for_the_client(run: Run, path: Path) -> None:
    result = run("check", path, *TWO_THREADS, "--set", "Level.client.monitor.group=calls", "-v")
    assert result.exit_code == 0
    assert "proved: every callback that has begun can end\n" in result.stderr
