"""A message is of the callback that runs on its thread, and of no other one that runs at that time."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from dineros.observation.tracing import (
    Callback,
    Publication,
    Run,
    Tracing,
    TracingError,
    Uncertain,
    attributing,
    runs,
)
from tests.observation.tracing.test_reading import TEXT
from tests.support.traces import MILLISECOND, Trace

Told = list[tuple[str, list[tuple[str, int]], bool]]


def told(trace: Trace, tmp_path: Path) -> tuple[Told, list[str], Uncertain]:
    """Return the runs with what they published, the topics of all messages, and what is not told."""
    uncertain = Uncertain()
    found: Told = []
    topics = []
    for each in runs(Tracing(trace.write(tmp_path / "trace.txt")), uncertain):
        if isinstance(each, Run):
            published = [(topic, sent.count) for (_, topic), sent in each.published.items()]
            found.append((each.callback.name, published, each.ended))
        else:
            topics.append(each.topic)
    return found, topics, uncertain


class Mapper(Trace):
    """A node with two subscriptions and a service, and publishers."""

    def __init__(self) -> None:
        super().__init__()
        self.mapper = self.node("/mapper")
        self.map, self.log = (self.publisher(self.mapper, f"/{name}") for name in ("map", "log"))
        self.scan, self.odom = (self.subscription(self.mapper, f"/{name}") for name in ("scan", "odom"))
        self.where = self.service(self.mapper, "/where")


@pytest.fixture
def mapper() -> Mapper:
    return Mapper()


def test_a_real_trace() -> None:
    """What ``demo.c`` does: nested and concurrent callbacks, ends that are not told, others' messages."""
    found: Counter[tuple[str, str, tuple[tuple[str, int], ...], bool]] = Counter()
    messages: Counter[str] = Counter()
    for each in runs(Tracing(TEXT)):
        if isinstance(each, Publication):
            messages[each.topic] += 1
        else:
            published = tuple((topic, sent.count) for (_, topic), sent in each.published.items())
            name = "nap" if "nap()" in each.callback.name else each.callback.name
            found[each.callback.node, name, published, each.ended] += 1
    assert found == {
        ("/driver", "Driver::tick()", (("/scan", 1),), True): 12,
        ("/mapper", "/scan", (("/map", 1),), True): 8,
        ("/mapper", "/scan", (("/map", 1), ("/log", 1)), True): 4,
        ("/mapper", "/odom", (("/speed", 1),), True): 18,
        ("/mapper", "nap", (("/slow", 2),), True): 6,
        ("/mapper", "/where", (("/asked", 1),), True): 5,
        ("/mapper", "/where", (("/asked", 1),), False): 1,
    }
    assert messages == {
        "/scan": 12,
        "/map": 12,
        "/log": 4,
        "/speed": 18,
        "/slow": 12,
        "/asked": 6,
        "/health": 9,
    }


def test_threads_of_one_executor_are_apart(mapper: Mapper, tmp_path: Path) -> None:
    mapper.start(mapper.scan, thread=11)
    mapper.start(mapper.odom, thread=12)
    mapper.publish(mapper.map, thread=11)
    mapper.publish(mapper.log, thread=12)
    mapper.end(mapper.scan, thread=11)
    mapper.publish(mapper.log, thread=12)
    mapper.end(mapper.odom, thread=12)
    found, topics, _ = told(mapper, tmp_path)
    assert found == [("/scan", [("/map", 1)], True), ("/odom", [("/log", 2)], True)]
    assert topics == ["/map", "/log", "/log"]


def test_one_callback_may_run_on_two_threads(mapper: Mapper, tmp_path: Path) -> None:
    """Of a reentrant group."""
    mapper.start(mapper.scan, thread=11)
    mapper.start(mapper.scan, thread=12)
    mapper.publish(mapper.map, thread=12)
    mapper.end(mapper.scan, thread=11)
    mapper.end(mapper.scan, thread=12)
    assert told(mapper, tmp_path)[0] == [("/scan", [], True), ("/scan", [("/map", 1)], True)]


def test_numbers_of_processes_and_threads_are_those_of_a_host(mapper: Mapper, tmp_path: Path) -> None:
    mapper.start(mapper.scan)
    mapper.event("ros2:rcl_publish", f"publisher_handle = {mapper.map:#x}", host="other")
    mapper.end(mapper.scan)
    found, topics, uncertain = told(mapper, tmp_path)
    assert (found, topics, uncertain.messages) == ([("/scan", [], True)], [], 1)


def test_addresses_are_those_of_a_process(mapper: Mapper, tmp_path: Path) -> None:
    mapper._next = 0x5000  # the other process has the same addresses
    planner = mapper.node("/planner", 2)
    path = mapper.publisher(planner, "/path", 2)
    assert path == mapper.map
    mapper.start(mapper.scan)
    mapper.publish(path, thread=2, process=2)
    mapper.publish(mapper.map)
    mapper.end(mapper.scan)
    found, topics, _ = told(mapper, tmp_path)
    assert (found, topics) == ([("/scan", [("/map", 1)], True)], ["/path", "/map"])


def test_what_is_published_outside_of_callbacks_is_of_none(mapper: Mapper, tmp_path: Path) -> None:
    mapper.publish(mapper.map)
    mapper.run(mapper.scan)
    mapper.publish(mapper.map)
    mapper.start(mapper.scan)
    mapper.publish(mapper.map, thread=99)
    mapper.end(mapper.scan)
    found, topics, _ = told(mapper, tmp_path)
    assert (found, topics) == ([("/scan", [], True)] * 2, ["/map"] * 3)


def test_a_callback_that_spins_goes_on_afterwards(mapper: Mapper, tmp_path: Path) -> None:
    mapper.start(mapper.scan)
    mapper.publish(mapper.map)
    mapper.executor()
    mapper.run(mapper.odom, [mapper.log])
    mapper.publish(mapper.map)
    mapper.publish(mapper.log)
    mapper.end(mapper.scan)
    assert told(mapper, tmp_path)[0] == [
        ("/odom", [("/log", 1)], True),
        ("/scan", [("/map", 2), ("/log", 1)], True),
    ]


def test_a_service_that_answers_later_has_no_end(mapper: Mapper, tmp_path: Path) -> None:
    """What its thread publishes once the executor has gone on is not of it, nor of who comes then."""
    for _ in range(2):
        mapper.start(mapper.where)
        mapper.publish(mapper.log)
        mapper.executor()
        mapper.publish(mapper.map)  # by the callback of a client, of which no trace tells
        mapper.run(mapper.odom)
        mapper.publish(mapper.map)
    found, topics, _ = told(mapper, tmp_path)
    assert [each for each in found if each[0] == "/odom"] == [("/odom", [], True)] * 2
    assert [each for each in found if each[0] == "/where"] == [
        ("/where", [("/log", 1)], True),
        ("/where", [("/log", 1)], False),
    ]
    assert topics.count("/map") == 4


def test_the_end_of_an_outer_callback_ends_those_within(mapper: Mapper, tmp_path: Path) -> None:
    mapper.start(mapper.scan)
    mapper.start(mapper.where)
    mapper.publish(mapper.log)
    mapper.end(mapper.scan)
    mapper.publish(mapper.map)
    found, _, _ = told(mapper, tmp_path)
    assert found == [("/where", [("/log", 1)], True), ("/scan", [], True)]


@pytest.mark.parametrize("inside", [True, False])
def test_a_message_within_the_process_counts_once(inside: bool, mapper: Mapper, tmp_path: Path) -> None:
    if inside:
        mapper.start(mapper.scan)
    mapper.publish(mapper.map, within=True)
    mapper.publish(mapper.map, within=True)
    mapper.publish(mapper.map, within=True, others=False)
    mapper.publish(mapper.map, within=True, others=False)
    mapper.publish(mapper.log)
    mapper.publish(mapper.log)
    if inside:
        mapper.end(mapper.scan)
    found, topics, _ = told(mapper, tmp_path)
    assert topics == ["/map"] * 4 + ["/log"] * 2
    assert found == ([("/scan", [("/map", 4), ("/log", 2)], True)] if inside else [])


def test_an_address_may_be_used_again(mapper: Mapper, tmp_path: Path) -> None:
    """The publisher is gone, and a new one stands where it stood; so does a callback."""
    mapper.run(mapper.scan, [mapper.map])
    fields = f"publisher_handle = {mapper.map:#x}, node_handle = {mapper.mapper:#x}"
    mapper.event("ros2:rcl_publisher_init", f'{fields}, topic_name = "/path"')
    mapper.event("ros2:rclcpp_timer_callback_added", f"timer_handle = 0x77, callback = {mapper.scan:#x}")
    mapper.event("ros2:rclcpp_timer_link_node", f"timer_handle = 0x77, node_handle = {mapper.mapper:#x}")
    mapper.event("ros2:rcl_timer_init", "timer_handle = 0x77, period = 5")
    mapper.run(mapper.scan, [mapper.map])
    assert [each[1] for each in told(mapper, tmp_path)[0]] == [[("/map", 1)], [("/path", 1)]]
    last = [each for each in runs(Tracing(tmp_path / "trace.txt")) if isinstance(each, Run)][-1]
    assert last.callback == Callback("/mapper", "timer", "", 5)


def test_delays_are_from_the_beginning_to_the_first_message(mapper: Mapper, tmp_path: Path) -> None:
    mapper.at(MILLISECOND)
    mapper.start(mapper.scan)
    mapper.at(5 * MILLISECOND)
    mapper.publish(mapper.map)
    mapper.at(9 * MILLISECOND)
    mapper.publish(mapper.map)
    mapper.end(mapper.scan)
    (run,) = (each for each in runs(Tracing(mapper.write(tmp_path / "t"))) if isinstance(each, Run))
    assert 4 * MILLISECOND <= run.published["/mapper", "/map"].first < 5 * MILLISECOND


def test_names_in_a_namespace(tmp_path: Path) -> None:
    trace = Trace()
    node = trace.node("/robot/left/arm")
    trace.publish(trace.publisher(node, "/robot/left/grip"))
    (message,) = runs(Tracing(trace.write(tmp_path / "t")))
    assert isinstance(message, Publication)
    assert message[1:] == ("/robot/left/arm", "/robot/left/grip")


def test_what_began_before_the_trace_is_counted(mapper: Mapper, tmp_path: Path) -> None:
    mapper.end(0x1)
    mapper.start(0x1)
    mapper.publish(mapper.map)
    mapper.publish(0x2)
    mapper.end(0x1)
    found, topics, uncertain = told(mapper, tmp_path)
    assert (found, topics, uncertain) == ([], ["/map"], Uncertain(1, 1))


def test_a_trace_that_tells_of_no_node(tmp_path: Path) -> None:
    trace = Trace()
    trace.run(0x1, [0x2])
    with pytest.raises(TracingError, match=r"contains no node .*start tracing before the nodes"):
        list(runs(Tracing(trace.write(tmp_path / "t"))))


def test_what_is_remembered_is_bounded(
    mapper: Mapper, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(attributing, "MOST", 5)
    for number in range(100):  # threads that are in no callback are forgotten
        mapper.publish(mapper.map, thread=1000 + number, within=True, others=False)
    for number in range(1000):
        mapper.start(0x10000 + number)  # callbacks that never end
    mapper.run(mapper.scan, [mapper.map])
    assert told(mapper, tmp_path)[0] == [("/scan", [("/map", 1)], True)]
    for number in range(6):
        mapper.publisher(mapper.mapper, f"/topic_{number}")
    with pytest.raises(TracingError, match="contains more than 5 publishers"):
        told(mapper, tmp_path)
