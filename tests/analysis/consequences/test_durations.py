"""Overflows that durations decide, which code does not say."""

from __future__ import annotations

from dataclasses import replace

import pytest

from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.consequences.durations import OPEN, left_to_durations
from dineros.analysis.model.times import UsedTimes
from dineros.analysis.timed_checks.timed_check import check_timed
from dineros.analysis.witnesses.findings import Finding, Report
from dineros.metamodel import sym
from dineros.metamodel.build import callback, place, seconds, step
from dineros.metamodel.elements import find, node_nets
from dineros.observation.importing.building import to_model
from dineros.observation.systems import ObservedNode, ObservedSystem, TopicEndpoint

SCAN = (TopicEndpoint("/scan", "sensor_msgs/msg/LaserScan"),)
NODES = (ObservedNode("/lidar", publishers=SCAN), ObservedNode("/log", subscribers=SCAN))
TIMES = UsedTimes(1, "lidar.on_timer [0,0]", "1/10")


def model_of_code() -> sym.SystemModel:
    model = to_model(ObservedSystem("code", NODES)).model
    for node in node_nets(model):
        node.sourceLine = "log.py:1"
    return model


def left(model: sym.SystemModel, times: UsedTimes | None, *about: str) -> Report:
    asks = Outcome.left_open("whether the history can overflow", "time ran out")
    unknown = replace(asks, elements=about, rule="queue-overflow")
    return left_to_durations(model, Report(unknown=[unknown], times=times))


@pytest.mark.parametrize("times", [None, TIMES], ids=["without times", "with times"])
def test_a_queue_whose_reader_may_take_any_time_is_left_to_durations(times: UsedTimes | None) -> None:
    found = left(model_of_code(), times, "topic.scan")
    assert found.unknown == []
    assert [(each.rule, each.severity, each.message) for each in found.findings] == [
        ("queue-overflow", "note", f"whether the history can overflow {OPEN}")
    ]


@pytest.mark.parametrize("times", [None, TIMES], ids=["without times", "with times"])
def test_what_durations_decide_stays_unknown_with_times(times: UsedTimes | None) -> None:
    model = model_of_code()
    reads = find(model, "log.on_scan")
    assert isinstance(reads, sym.CallbackPage)
    reads.duration = seconds(0, 0.1)
    found = left(model, times, "topic.scan")
    assert (len(found.unknown), len(found.findings)) == ((0, 1) if times is None else (1, 0))
    nothing_known = left(model, times)
    assert (len(nothing_known.unknown), nothing_known.findings) == (1, [])


def test_a_check_with_times_says_which_queue_is_open() -> None:
    from dineros.analysis.answers.budget import Budget

    model = model_of_code()
    find(model, "lidar.on_timer").duration = seconds(0, 0.1)  # type: ignore[attr-defined]
    report = check_timed(model, Budget(seconds=0.0))
    for each in report.unknown:
        assert ("topic.scan" in each.elements) == each.question.endswith("can overflow")


@pytest.mark.parametrize(("depth", "severity"), [(2, "note"), (1, "error")])
def test_the_depth_of_a_service_counts_in_one_executor(depth: int, severity: str) -> None:
    """Two timers ask once each: both requests may come before the service is served."""
    model = sym.SystemModel(id="code", middleware="ros2")
    both = sym.NodeNet(id="both", net=model, execution="callbacks", sourceLine="both.py:1")
    serves = callback(both, "OnReset", "server")
    entry, exit_ = place(serves, "Entry"), place(serves, "Exit")
    step(serves, "Serve", [entry], [exit_])
    clients = []
    for name in ("First", "Second"):
        page = callback(both, name, "timer", 0.1)
        asks, has = place(page, f"{name}Asks"), place(page, f"{name}Has")
        begin, end = step(page, f"{name}Begins", [], [asks]), step(page, f"{name}Ends", [has], [])
        begin.kind, end.kind = "start", "end"
        clients.append(sym.ClientPort(client=name, request=asks, response=has))
    server = sym.ServerPort(entry=entry, exit=exit_, page=serves)
    channel = sym.ServiceChannel(id="Reset", service="/reset", server=server, clients=clients, depth=depth)
    model.channels.append(channel)
    found = Finding("queue-overflow", "error", (channel.id,), "the history can overflow")
    (after,) = left_to_durations(model, Report(findings=[found])).findings
    assert after.severity == severity


@pytest.mark.parametrize("missing", ["", "duration", "latency", "period", "sender", "times"])
def test_an_overflow_for_all_given_times_is_an_error(missing: str) -> None:
    """A timer ticks each 50 ms, and the reader needs 100 ms."""
    model = model_of_code()
    model.times = sym.DefaultTimes(latency=seconds(0, 0.001), duration=seconds(0, 0.001))
    page = find(model, "lidar.on_timer", sym.CallbackPage)
    page.timer, page.assumed = 0.05, ""
    reads = find(model, "log.on_scan", sym.CallbackPage)
    reads.duration = seconds(0.1, None if missing == "duration" else 0.1)
    match missing:
        case "latency":
            model.times.latency = None
        case "period":
            page.timer = None
        case "sender":
            page.duration = seconds(0, None)
    found = Finding("queue-overflow", "error", ("topic.scan",), "a message is lost")
    report = Report(findings=[found], times=None if missing == "times" else TIMES)
    (after,) = left_to_durations(model, report).findings
    assert after.severity == ("note" if missing else "error")
