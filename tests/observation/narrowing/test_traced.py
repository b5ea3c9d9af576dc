"""What tracing files show stands above what times would have it; the narrowed model explains the messages."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dineros.metamodel.constraints import validate
from dineros.observation.explaining import explain
from dineros.observation.importing.flows.labels import Step
from dineros.observation.narrowing import (
    Narrowed,
    Proposal,
    Traced,
    narrowed,
    proposals,
    publications,
    traced,
    with_traced,
)
from dineros.observation.systems import Endpoint, ObservedNode, ObservedSystem, TopicEndpoint
from dineros.observation.tracing import Tracing
from tests.support.traces import MILLISECOND, Trace


def ends(*topics: str) -> tuple[TopicEndpoint, ...]:
    return tuple(TopicEndpoint(topic, "std_msgs/msg/String", depth=3) for topic in topics)


ROBOT = ObservedSystem(
    "a test",
    (
        ObservedNode("/driver", ends("/odom"), ends("/speed")),
        ObservedNode("/lidar", ends("/scan")),
        ObservedNode(
            "/mapper", ends("/map", "/speed"), ends("/odom", "/scan"), (Endpoint("/where", "a/srv/B"),)
        ),
    ),
)


class Robot(Trace):
    """The nodes of `ROBOT`, but for the driver, whose node is not rclcpp: callbacks of it are not told."""

    def __init__(self) -> None:
        super().__init__()
        self.lidar, self.mapper, self.driver = (
            self.node(f"/{each}") for each in ("lidar", "mapper", "driver")
        )
        self.scan = self.publisher(self.lidar, "/scan")
        self.map, self.speed = (self.publisher(self.mapper, each) for each in ("/map", "/speed"))
        self.odom = self.publisher(self.driver, "/odom")
        self.tick = self.timer(self.lidar, 100 * MILLISECOND)
        self.on_scan, self.on_odom = (self.subscription(self.mapper, each) for each in ("/scan", "/odom"))
        self.rounds = 0

    def round(self, *, maps: int = 1, speeds: int = 1, odoms: int = 1) -> None:
        """Let 100 ms pass: a scan is worked on for 50 ms, and a message on /odom comes meanwhile.

        So a map comes right after /odom, and long after its scan: by their times, /odom would lead to maps.
        """
        self.rounds += 1
        start = self.rounds * 100 * MILLISECOND
        self.at(start)
        self.run(self.tick, [self.scan], thread=2)
        self.at(start + 2 * MILLISECOND)
        self.start(self.on_scan, thread=3)
        self.at(start + 49 * MILLISECOND)
        if odoms:
            self.publish(self.odom, thread=9)
            self.start(self.on_odom, thread=4)
        self.at(start + 50 * MILLISECOND)
        for _ in range(maps):
            self.publish(self.map, thread=3)
        self.end(self.on_scan, thread=3)
        self.at(start + 60 * MILLISECOND)
        if odoms:
            for _ in range(speeds):
                self.publish(self.speed, thread=4)
            self.end(self.on_odom, thread=4)


@pytest.fixture
def robot() -> Robot:
    return Robot()


def counts(trace: Trace, tmp_path: Path) -> tuple[Traced, Tracing]:
    files = Tracing(trace.write(tmp_path / "trace.txt"))
    return traced(ROBOT, files), files


def found(trace: Trace, tmp_path: Path) -> list[Proposal]:
    counted, files = counts(trace, tmp_path)
    return with_traced(proposals(ROBOT, publications(ROBOT, files)), counted)


def kinds(these: list[Proposal]) -> dict[tuple[str, str], str]:
    return {(each.callback, each.topic): each.kind for each in these if each.kind != "never"}


def make(trace: Trace, tmp_path: Path, accepted: list[Proposal]) -> Narrowed:
    counted, files = counts(trace, tmp_path)
    return narrowed(ROBOT, counted.recorded(), lambda: publications(ROBOT, files), accepted)


def errors(made: Narrowed) -> list[object]:
    return [each for each in validate(made.imported.model) if each.severity == "error"]


def test_who_published_is_known_where_times_mislead(robot: Robot, tmp_path: Path) -> None:
    for number in range(20):
        robot.round(maps=int(number in (0, 1, 2, 6, 7, 8, 9, 15, 18, 19)))
    _, files = counts(robot, tmp_path)
    by_times = kinds(proposals(ROBOT, publications(ROBOT, files)))
    assert by_times["/odom", "/map"] == "sometimes"
    assert ("/scan", "/map") not in by_times
    told = found(robot, tmp_path)
    assert kinds(told) == {
        ("/odom", "/odom"): "timer",  # by their times, as of this node no callback is told
        ("timer_100ms", "/scan"): "always",
        ("/scan", "/map"): "sometimes",
        ("/odom", "/speed"): "always",
    }
    (maps,) = (each for each in told if (each.callback, each.topic) == ("/scan", "/map"))
    assert (maps.triggers, maps.followed, maps.messages, maps.explained) == (20, 10, 10, 10)
    assert 0.047 < maps.least <= maps.mean <= maps.most < 0.049
    assert (maps.source, maps.period, maps.repeats) == ("tracing", 0, 1)
    assert str(maps) == (
        "0.95  /mapper: /scan sometimes leads to /map (in 10 of 20 runs, after 48 ms to 48 ms; "
        "10 of 10 messages; traced)"
    )
    nevers = [str(each) for each in told if each.kind == "never" and each.source == "tracing"]
    assert nevers == [
        "0.95  /mapper: /odom never leads to /map (in none of 20 runs; traced)",
        "0.95  /mapper: /scan never leads to /speed (in none of 20 runs; traced)",
    ]


def test_the_model_has_the_callbacks_and_explains_the_messages(robot: Robot, tmp_path: Path) -> None:
    for number in range(12):
        robot.round(maps=number % 2)
    made = make(robot, tmp_path, [each for each in found(robot, tmp_path) if each.source == "tracing"])
    assert (made.verdict.status, made.dropped) == ("conforms", ())
    assert made.verdict.messages == 12 + 12 + 12 + 6
    nodes = made.given.nodes
    assert nodes["/lidar"].timers == {"timer_100ms": 0.1}
    assert nodes["/lidar"].callbacks["timer_100ms"].does == (Step("publish", "/scan"),)
    assert nodes["/mapper"].timers == {}
    assert nodes["/mapper"].callbacks["/scan"].does == (Step("publish", "/map", "?"),)
    assert nodes["/mapper"].callbacks["/odom"].does == (Step("publish", "/speed"),)
    assert errors(made) == []
    topics = counts(robot, tmp_path)[0].recorded()
    for odd in ([("/map", 5)], [("/scan", 5), ("/map", 6), ("/map", 7)], [("/scan", 5), ("/speed", 6)]):
        assert explain(made.imported.model, topics, odd).status == "violated"


def test_a_wrong_attribution_does_not_explain_them(robot: Robot, tmp_path: Path) -> None:
    """The same with the two callbacks exchanged is taken back, as maps come without a message on /odom."""
    for number in range(12):
        robot.round(odoms=int(number < 6))
    right = [each for each in found(robot, tmp_path) if each.source == "tracing"]
    assert make(robot, tmp_path, right).dropped == ()
    other = {"/scan": "/odom", "/odom": "/scan"}
    wrong = [replace(each, callback=other.get(each.callback, each.callback)) for each in right]
    made = make(robot, tmp_path, wrong)
    assert made.verdict.status == "conforms"
    assert ("/odom", "/map", "always") in {(each.callback, each.topic, each.kind) for each in wrong}
    assert {each.topic for each in made.dropped} == {"/map"}


def test_several_messages_of_a_run(robot: Robot, tmp_path: Path) -> None:
    for number in range(9):
        robot.round(maps=1 + number % 3, speeds=2 * (number % 2))
    told = found(robot, tmp_path)
    assert "(in 9 of 9 runs, up to 3 each, after 48 ms to 48 ms; 18 of 18 messages; traced)" in "\n".join(
        map(str, told)
    )
    made = make(robot, tmp_path, [each for each in told if each.source == "tracing"])
    assert (made.verdict.status, made.verdict.messages, made.dropped) == ("conforms", 9 + 9 + 18 + 8, ())
    callbacks = made.given.nodes["/mapper"].callbacks
    assert callbacks["/scan"].does == (Step("publish", "/map"), Step("publish", "/map", "*"))
    assert callbacks["/odom"].does == (Step("publish", "/speed", "*"),)


def test_messages_from_elsewhere_leave_the_node_open(robot: Robot, tmp_path: Path) -> None:
    """From a thread of its own, or the callback of a client: a timer that nobody saw may publish them."""
    for _ in range(8):
        robot.round()
        robot.publish(robot.map, thread=77)
    counted, _ = counts(robot, tmp_path)
    assert counted.outside == 8 + 8  # and those of the driver
    told = found(robot, tmp_path)
    (maps,) = (each for each in told if (each.callback, each.topic) == ("/scan", "/map"))
    assert (maps.kind, maps.messages, maps.explained) == ("always", 16, 8)
    made = make(robot, tmp_path, [each for each in told if each.source == "tracing"])
    assert (made.verdict.status, made.dropped) == ("conforms", ())
    assert made.given.nodes["/mapper"].timers == {"timer": 1.0}
    assert made.given.nodes["/mapper"].callbacks["timer"].does == (Step("publish", "/map", "*"),)
    assert made.given.nodes["/mapper"].callbacks["/where"].does == (Step("publish", "/map", "*"),)


def test_what_only_a_thread_publishes_may_come_of_a_timer(robot: Robot, tmp_path: Path) -> None:
    for number in range(1, 13):
        robot.at(number * 100 * MILLISECOND)
        robot.publish(robot.map, thread=77)
        if number in (2, 3, 7):
            robot.at((number * 100 + 7 * number) * MILLISECOND)
            robot.publish(robot.scan, thread=9)
            robot.run(robot.on_scan, thread=3)
    told = [each for each in found(robot, tmp_path) if each.topic == "/map"]
    kinds = {(each.callback, each.kind, each.source) for each in told}
    assert kinds == {("/scan", "never", "tracing"), ("/map", "timer", "times")}
    made = make(robot, tmp_path, told)
    assert (made.verdict.status, made.dropped) == ("conforms", ())
    assert made.given.nodes["/mapper"].timers == {"timer": 1.0, "timer_map": 0.1}
    # A timer that is traced is all there is: its messages are no others' as well.
    for _ in range(6):
        robot.run(robot.timer(robot.mapper, 50 * MILLISECOND), [robot.map], thread=3)
    sources = {(each.callback, each.source) for each in found(robot, tmp_path) if each.topic == "/map"}
    assert sources == {("/scan", "tracing"), ("timer_50ms", "tracing")}


def test_some_callbacks_of_a_topic_accepted_and_others_not(robot: Robot, tmp_path: Path) -> None:
    """Two callbacks publish on it: where one of them is accepted, the other may still do anything."""
    for _ in range(6):
        robot.round()
        robot.run(robot.on_odom, [robot.map], thread=4)
    told = found(robot, tmp_path)
    for callback in ("/scan", "/odom"):
        accepted = [each for each in told if (each.callback, each.topic) == (callback, "/map")]
        made = make(robot, tmp_path, accepted)
        assert (made.verdict.status, made.dropped) == ("conforms", ()), callback
        other = "/odom" if callback == "/scan" else "/scan"
        assert Step("publish", "/map", "*") in (made.given.nodes["/mapper"].callbacks[other].does or ())


def test_timers_of_one_period_are_apart_by_their_functions(robot: Robot, tmp_path: Path) -> None:
    first = robot.timer(robot.lidar, 1_500_000, "first()")
    other = [robot.timer(robot.lidar, 1_500_000, "second()") for _ in range(2)]  # made again
    for _ in range(6):
        robot.round()
        robot.run(first)
        robot.run(other[0])
    robot.run(other[1])
    names = {each.callback: each.triggers for each in found(robot, tmp_path) if each.node == "/lidar"}
    assert names == {"timer_100ms": 6, "timer_1_5ms": 6, "timer_1_5ms_2": 7}


@pytest.mark.parametrize("period", [0, -5, 10**19])
def test_odd_periods_are_periods_all_the_same(period: int, robot: Robot, tmp_path: Path) -> None:
    odd = robot.timer(robot.lidar, period)
    for _ in range(6):
        robot.run(odd, [robot.scan])
    (scans,) = (each for each in found(robot, tmp_path) if each.kind == "always")
    assert 0 < scans.period < 1e9
    made = make(robot, tmp_path, [scans])
    assert made.verdict.status == "conforms" and not errors(made)


def test_a_run_that_the_trace_cuts_off_may_still_publish(robot: Robot, tmp_path: Path) -> None:
    for _ in range(6):
        robot.round()
    robot.start(robot.on_scan, thread=3)
    assert kinds(found(robot, tmp_path))["/scan", "/map"] == "always"
    robot.publish(robot.map, thread=3)
    (maps,) = (each for each in found(robot, tmp_path) if (each.callback, each.topic) == ("/scan", "/map"))
    assert (maps.kind, maps.triggers, maps.followed, maps.explained, maps.messages) == ("always", 7, 7, 7, 7)


def test_a_service_without_an_end_that_does_not_publish_counts(robot: Robot, tmp_path: Path) -> None:
    where = robot.service(robot.mapper, "/where")
    for number in range(10):
        robot.start(where)
        if number % 2:
            robot.publish(robot.map)
        robot.executor()
    assert kinds(found(robot, tmp_path))["/where", "/map"] == "sometimes"


def test_what_another_node_publishes_is_not_of_the_callback(robot: Robot, tmp_path: Path) -> None:
    """Nodes of one process may share publishers; in a model, a callback has those of its node."""
    for _ in range(6):
        robot.run(robot.on_scan, [robot.scan, robot.map], thread=3)
    told = found(robot, tmp_path)
    assert kinds([each for each in told if each.source == "tracing"]) == {("/scan", "/map"): "always"}
    assert make(robot, tmp_path, told).verdict.status != "violated"


def test_a_topic_is_recorded_where_all_that_publish_are_traced(robot: Robot, tmp_path: Path) -> None:
    robot.round()
    counted, _ = counts(robot, tmp_path)
    assert {each.name: each.messages for each in counted.recorded()} == {
        "/map": 1,
        "/odom": 1,
        "/scan": 1,
        "/speed": 1,
    }
    shared = ObservedSystem("a test", (*ROBOT.nodes, ObservedNode("/other", ends("/map", "/none"))))
    again = traced(shared, Tracing(tmp_path / "trace.txt"))
    assert {each.name for each in again.recorded()} == {"/odom", "/scan", "/speed"}
    assert again.nodes == {"/driver", "/lidar", "/mapper"}


@settings(max_examples=6, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.data())
def test_whatever_is_accepted_the_model_explains_the_messages(tmp_path: Path, data: st.DataObject) -> None:
    robot = Robot()
    for _ in range(data.draw(st.integers(5, 9))):
        robot.round(maps=data.draw(st.integers(0, 2)), speeds=data.draw(st.integers(0, 2)))
        if data.draw(st.booleans()):
            robot.publish(robot.speed, thread=77)
        if data.draw(st.booleans()):
            robot.run(robot.on_odom, data.draw(st.sampled_from([[], [robot.map], [robot.map, robot.speed]])))
    told = found(robot, tmp_path)
    accepted = data.draw(st.lists(st.sampled_from(told), unique=True))
    assert make(robot, tmp_path, accepted).verdict.status == "conforms"
