"""What `check` says of callbacks that wait for each other, in every format."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.metamodel.files import save
from examples.callbacks.models import battery
from tests.cli.conftest import Run
from tests.support.programs.commands import is_one_line_of_wrong_use

TWO_THREADS = ("--set", "monitor.executor=multi", "--set", "monitor.threads=2")
CIRCLE = [
    "timer callback OnTimer",
    "the response of service level to client monitor",
    "the default callback group of node monitor",
]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Return the file of a monitor that asks a battery for its level, all in the groups of the nodes."""
    save(battery(), tmp_path / "battery.sym.xmi")
    return tmp_path / "battery.sym.xmi"


def test_a_circle_in_every_format(run: Run, path: Path) -> None:
    result = run("check", path, "--witnesses", *TWO_THREADS)
    assert result.exit_code == 1
    text = (
        "deadlock in node monitor: timer callback OnTimer blocks in a call of service level; the response "
        "needs the default callback group, which OnTimer itself holds"
    )
    assert (
        f"error: {text} [6 steps] [callback-deadlock]\n    1  the timer of callback OnTimer ticks"
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
    related = [each["message"]["text"] for each in result_["relatedLocations"] if "message" in each]
    assert len(result_["relatedLocations"]) - sum(text.startswith("consequence: ") for text in related) == 2
    assert len(result_["codeFlows"][0]["threadFlows"][0]["locations"]) == 6
    assert text in run("check", path, *TWO_THREADS, "--format", "junit").stdout


def test_no_circle_with_a_group_for_the_client(run: Run, path: Path) -> None:
    result = run("check", path, *TWO_THREADS, "--set", "Level.client.monitor.group=calls", "-v")
    assert result.exit_code == 0
    assert "proved: every callback that has begun can end\n" in result.stderr


def test_the_smallest_change(run: Run, path: Path) -> None:
    result = run("check", path, "--suggest-callback-groups")
    own = "--set Level.client.monitor.group=Level_monitor_group"
    threads = "--set monitor.executor=multi --set monitor.threads=2"
    assert result.exit_code == 1
    assert result.stdout.splitlines()[1:] == [
        f"change: client monitor of service level in a callback group of its own: {own}",
        f"change: 2 threads for node net monitor: {threads}",
        "proved: no callback waits forever, and no further queue overflows; no smaller change suffices",
        f"{path}: 2 changes, 4 models checked",
    ]
    report = json.loads(run("check", path, "--suggest-callback-groups", "--json").stdout)
    assert (report["found"], report["proved"], report["checked"], report["reason"]) == (True, True, 4, "")
    assert report["mends"][0]["circle"][0] == CIRCLE[0]
    made = [
        part for change in report["changes"] for setting in change["settings"] for part in ("--set", setting)
    ]
    assert made == f"{own} {threads}".split()
    again = run("check", path, "--suggest-callback-groups", *made)
    assert (again.exit_code, again.stdout.splitlines()[0]) == (0, "proved: no callback waits forever")
    assert run("check", path, *made).exit_code == 0


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (["--format", "sarif"], "changes are not findings: they cannot be printed with --format sarif"),
        (["-o", "out.html"], "-o cannot be combined with --suggest-callback-groups"),
        (["--suggest-capacities"], "--suggest-capacities cannot be combined with --suggest-callback-groups"),
    ],
)
def test_changes_that_cannot_be_asked_for(run: Run, path: Path, options: list[str], text: str) -> None:
    assert is_one_line_of_wrong_use(run("check", path, "--suggest-callback-groups", *options), text)


def test_only_nodes_that_run_callbacks(run: Run, path: Path) -> None:
    nodes = ("--set", "monitor.execution=net", "--set", "battery.execution=net")
    result = run("check", path, "--suggest-callback-groups", *nodes)
    assert result.exit_code == 2
    assert "no node net runs callbacks under the rules of ros2" in result.stderr.splitlines()[-1]


def test_out_of_time_says_so(run: Run, path: Path) -> None:
    result = run("check", path, "--suggest-callback-groups", "--timeout", "1e-6")
    assert result.exit_code == 3
    assert "time ran out" in result.stdout + result.stderr
