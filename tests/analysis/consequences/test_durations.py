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
from dineros.metamodel.build import callback, node_net, place, seconds, step
from dineros.metamodel.elements import find, node_nets
from dineros.observation.importing.building import to_model
from dineros.observation.importing.flows.labels import Step
from dineros.observation.importing.given import Given, GivenCallback, GivenNode
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


def test_a_missing_time_is_named_where_it_decides() -> None:
    """A slow timer and a subscription of one thread: all durations are given, but no latency."""
    model = sym.SystemModel(id="slow_timer", middleware="ros2")
    source = node_net(model, "source", execution="callbacks")
    worker = node_net(model, "worker", execution="callbacks", order="rclpy")
    sends, works = callback(source, "OnSend", "timer"), callback(worker, "OnProcess", "timer")
    for page in (sends, works):
        page.timer, page.duration = 0.1, seconds(0.001, 0.001)
    sent = place(sends, "Sent")
    step(sends, "Send", [], [sent])
    step(works, "Process")
    reads = callback(worker, "OnData")
    data = place(reads, "Data")
    step(reads, "Copy", [data])
    reads.duration = seconds(0.001, 0.001)
    topic = sym.TopicChannel(id="Topic", topic="/data", model=model)
    topic.publishers.append(sym.PublisherPort(place=sent))
    topic.subscribers.append(sym.SubscriberPort(place=data))
    missing = "the model gives no latency for topic /data"
    (after,) = left(model, TIMES).unknown
    assert after.reason == f"time ran out; {missing}"
    finding = Finding("queue-overflow", "error", ("Topic", "Data"), "the history can overflow")
    report = Report(findings=[finding], times=TIMES)
    (found,) = left_to_durations(model, report).findings
    assert (found.severity, found.message) == ("error", f"the history can overflow; {missing}")
    other = Outcome.left_open("what is not about time", "the guard is too large")
    assert left_to_durations(model, Report(unknown=[other], times=TIMES)).unknown == [other]
    topic.latency = seconds(0, 0.001)
    assert left(model, TIMES).unknown[0].reason == "time ran out"
    assert left_to_durations(model, report).findings == [finding]
    works.duration = None
    assert left(model, TIMES).unknown[0].reason.endswith("the duration of callback OnProcess is not given")


@pytest.mark.parametrize(
    ("period", "takes", "is_certain", "severity"),
    [
        (1.0, 1.5, True, "error"),
        (2.0, 1.5, True, "note"),
        (1.0, 1.0, True, "note"),
        (1.0, 1.5, False, "note"),
    ],
)
def test_a_reader_that_the_code_makes_too_slow(
    period: float, takes: float, is_certain: bool, severity: str
) -> None:
    given = Given(
        {
            "/lidar": GivenNode(
                timers={"tick": period},
                callbacks={"tick": GivenCallback((Step("publish", "/scan", "" if is_certain else "?"),))},
            ),
            "/log": GivenNode(
                threads=1, timers={}, callbacks={"/scan": GivenCallback((), takes=(takes, None))}
            ),
        }
    )
    model = to_model(ObservedSystem("code", NODES), given).model
    for node in node_nets(model):
        node.sourceLine = "log.py:1"
    reader = next(iter(find(model, "topic.scan", sym.TopicChannel).subscribers)).place.id
    finding = Finding("queue-overflow", "error", ("topic.scan", str(reader)), "it overflows")
    (found,) = left_to_durations(model, Report(findings=[finding])).findings
    assert found.severity == severity
    expected = "it overflows: its callback takes at least 1.5 s, and lidar.on_tick publishes each 1 s"
    assert (found.message == expected) == (severity == "error")
