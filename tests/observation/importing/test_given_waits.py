"""Callbacks that wait for a message or for a goal's result, or sleep, as people say it of a system."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.analysis.bounds.answers import Bounds
from dineros.analysis.checks.check import check
from dineros.metamodel import sym
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import node_nets
from dineros.metamodel.errors import DinerosError
from dineros.observation.importing.building import to_model
from dineros.observation.importing.given import Given
from dineros.observation.importing.given_reading import read_given
from dineros.observation.narrowing.written import given_text
from dineros.observation.systems import Endpoint, ObservedNode, ObservedSystem
from tests.support.systems.foreign import port, trigger

GO = "example_interfaces/action/Fibonacci"
ARM = ObservedNode("/arm", publishers=(port("/joints"),))
USER = ObservedNode("/user", clients=(trigger("/move"),))
MOVER = ObservedNode("/mover", subscribers=(port("/joints"),), servers=(trigger("/move"),))
KNOWN = """
[node."/arm"]
timers.tick = 0.1
callback.tick.does = ["publish /joints"]
[node."/user"]
timers.tick = 1.0
callback.tick.does = ["call /move"]
threads = 2
groups.answers = "exclusive"
callback."/move".group = "answers"
[node."/mover"]
timers = {}
THREADS
callback."/joints".does = []
callback."/move".does = DOES
"""


def read(folder: Path, text: str) -> Given:
    path = folder / "a.given.toml"
    path.write_text(text)
    return read_given(path)


def model(folder: Path, does: str, threads: str = "threads = 1") -> sym.SystemModel:
    text = KNOWN.replace("THREADS", threads).replace("DOES", does)
    found = to_model(ObservedSystem("nowhere", (ARM, USER, MOVER)), read(folder, text)).model
    assert [each for each in validate(found) if each.severity == "error"] == []
    return found


OWN_GROUP = 'threads = 2\ngroups.state = "exclusive"\ncallback."/joints".group = "state"'


@pytest.mark.parametrize(
    ("does", "threads", "hangs"),
    [
        ('["wait /joints"]', "threads = 1", True),
        ('["wait /joints"]', "threads = 2", True),  # the same group
        ('["wait /joints"]', OWN_GROUP, False),
        ("[]", "threads = 1", False),
    ],
)
def test_a_wait_for_a_message_needs_its_callback(
    tmp_path: Path, does: str, threads: str, hangs: bool
) -> None:
    report = check(model(tmp_path, does, threads))
    found = [each for each in report.findings if each.rule in ("callback-deadlock", "deadlock")]
    assert bool(found) == hangs, [each.message for each in report.findings]
    if hangs:
        assert "serves_move" in found[0].message


@pytest.mark.parametrize(("threads", "hangs"), [(1, True), (2, True), (3, False)])
def test_a_wait_for_a_result_needs_the_callback_of_the_result(
    tmp_path: Path, threads: int, hangs: bool
) -> None:
    server = ObservedNode("/server", action_servers=(Endpoint("/go", GO),))
    client = ObservedNode("/client", action_clients=(Endpoint("/go", GO),))
    group = 'groups.own = "exclusive"\ncallback.tick.group = "own"\n' if threads == 3 else ""
    text = (
        f'[node."/client"]\nthreads = {threads}\ntimers.tick = 1\n{group}'
        'callback.tick.does = ["goal /go", "result /go"]\ncallback."/go".does = []\n'
        '[node."/server"]\nthreads = 2\ntimers = {}\ncallback."/go".does = []\n'
    )
    found = to_model(ObservedSystem("nowhere", (server, client)), read(tmp_path, text)).model
    assert [each for each in validate(found) if each.severity == "error"] == []
    report = check(found)
    assert any("deadlock" in each.rule for each in report.findings) == hangs, [
        each.message for each in report.findings
    ]


@pytest.mark.parametrize(
    ("said", "takes"),
    [
        ('does = ["sleep 0.5", "publish /x", "sleep 1.25"]', (1.75, None)),
        ('does = ["sleep 0.5 ?"]', (0.0, None)),
        ('does = ["sleep 2"]\ntakes = [0.5, 1]', (2.5, 3.0)),
        ('does = ["sleep 2 ?"]\ntakes = [0.5, 1]', (0.5, 3.0)),
        ('does = ["publish /x"]', None),
    ],
)
def test_a_sleep_is_time_that_a_run_takes(
    tmp_path: Path, said: str, takes: tuple[float, float | None] | None
) -> None:
    callback = read(tmp_path, f'[node."/a".callback."/b"]\n{said}\n').node("/a").callbacks["/b"]
    assert callback.takes == takes
    assert callback.does is not None
    assert {step.verb for step in callback.does} <= {"publish"}


@pytest.mark.parametrize("step", ["sleep", "sleep -1", "sleep 1 *", "sleep 1e99", "wait", "result /go !"])
def test_what_is_no_step_is_refused(tmp_path: Path, step: str) -> None:
    with pytest.raises(DinerosError, match="is not a step"):
        read(tmp_path, f'[node."/a".callback."/b"]\ndoes = ["{step}"]\n')


@pytest.mark.parametrize(
    ("step", "message"), [("wait /other", "does not wait /other"), ("result /go", "does not result /go")]
)
def test_waits_for_what_the_node_does_not_have_are_refused(tmp_path: Path, step: str, message: str) -> None:
    with pytest.raises(DinerosError, match=message):
        model(tmp_path, f'["{step}"]')


def test_a_sleep_is_the_duration_of_the_page(tmp_path: Path) -> None:
    nodes = node_nets(model(tmp_path, '["sleep 0.5"]'))
    pages = [page for node in nodes for page in node.objects if isinstance(page, sym.CallbackPage)]
    (move,) = [page for page in pages if page.duration]
    assert "serves_move" in str(move.id)


STATUS = """
[node."/client"]
threads = 1
timers.tick = 1
callback.tick.does = ["goal /go ?"]
callback.tick.takes = [0.0, 0.001]
callback."/go".does = ["publish /status"]
callback."/go".takes = [0.0, 0.001]
LIMIT
[node."/server"]
threads = 2
timers = {}
callback."/go".does = []
callback."/go".takes = [0.2, 0.4]
[node."/log"]
threads = 1
timers = {}
callback."/status".does = []
callback."/status".takes = [0.0, 0.01]
[times]
latency = [0, 0.01]
"""


@pytest.mark.parametrize(("limit", "overflows"), [("", None), ('callback."/go".outstanding = 1', False)])
def test_a_program_that_sends_one_goal_at_a_time_bounds_what_it_publishes_for_results(
    tmp_path: Path, limit: str, overflows: bool | None
) -> None:
    server = ObservedNode("/server", action_servers=(Endpoint("/go", GO),))
    client = ObservedNode("/client", action_clients=(Endpoint("/go", GO),), publishers=(port("/status"),))
    log = ObservedNode("/log", subscribers=(port("/status"),))
    given = read(tmp_path, STATUS.replace("LIMIT", limit))
    found = to_model(ObservedSystem("nowhere", (server, client, log)), given).model
    assert [each for each in validate(found) if each.severity == "error"] == []
    readers = Bounds(found).everything().readers
    assert readers["log.on_status.message"][1] is overflows
    assert (readers["server.works_on_go.goal"] == (1, False)) == (overflows is False)
    written = tmp_path / "again.given.toml"
    written.write_text(given_text(given))
    assert read_given(written).nodes == given.nodes


def test_a_number_of_goals_is_a_whole_number_from_1_on(tmp_path: Path) -> None:
    with pytest.raises(DinerosError, match="outstanding: is not a whole number from 1"):
        read(tmp_path, STATUS.replace("LIMIT", 'callback."/go".outstanding = 0'))
