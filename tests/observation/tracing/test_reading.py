"""Events are read from whatever Babeltrace 2 writes; what is none is counted, or said in one line."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dineros.metamodel.errors import DinerosError
from dineros.observation.tracing import Tracing, TracingError
from dineros.observation.tracing.lines import LONGEST_LINE
from dineros.observation.tracing.reading import TracedEvent
from tests.support.traces import Trace

DATA = Path(__file__).parent / "data"
TEXT = DATA / "trace.txt"
"""Written by Babeltrace 2.0.4 of a trace of LTTng 2.13: see ABOUT.md there."""


def read(path: Path) -> list[TracedEvent]:
    return list(Tracing(path).events())


def read_lines(tmp_path: Path, *lines: str) -> list[TracedEvent]:
    path = tmp_path / "trace.txt"
    path.write_text("".join(lines))
    return read(path)


def test_what_babeltrace_writes_of_a_real_trace() -> None:
    tracing = Tracing(TEXT)
    events = list(tracing.events())
    assert (tracing.read, tracing.foreign, tracing.odd) == (TEXT.read_text().count("\n"), 0, 0)
    begun = [each for each in events if each.name == "rcl_node_init"]
    assert [each.fields for each in begun] == [
        ("0x561200000100", "driver", "/"),
        ("0x561200000200", "mapper", "/"),
    ]
    assert len({each.process for each in events}) == 1
    assert len({each.thread for each in events}) == 5
    times = [each.time for each in events]
    assert times == sorted(times)
    # The first two events are 24 microseconds apart or so: parts of a second are nanoseconds.
    first, second = (line.split()[0] for line in TEXT.read_text().splitlines()[1:3])
    assert times[1] - times[0] == round((float(second[-13:-1]) - float(first[-13:-1])) * 1e9)


def test_the_strings_of_a_process_are_no_fields() -> None:
    """It is named ``a "b" } = 1,\\``, and a function has a signature with braces and a field in it."""
    events = read(TEXT)
    symbols = {each.fields[1] for each in events if each.name == "rclcpp_callback_register"}
    assert r"Mapper::nap() \"{ callback = 0x1 }\"" in symbols
    assert not [each for each in events if "callback" in each.name and each.fields[0] == "0x1"]


PUBLISHED = "{ vpid = 7, vtid = 8 }, { publisher_handle = 0xa, message = 0x1 }\n"


@pytest.mark.parametrize(
    ("head", "tail"),
    [
        ("[13:10:14.000000005] (+0.000000001) robot ros2:rcl_publish: { cpu_id = 2 }, ", PUBLISHED),
        ("[13:10:14.000000005] (+?.?????????) robot ros2:rcl_publish: { cpu_id = 2 }, ", PUBLISHED),
        ("[2026-11-23 13:10:14.000000005] robot ros2:rcl_publish: { cpu_id = 2 }, ", PUBLISHED),
        ("[1795458770.000000005] (+0.000000001) robot ros2:rcl_publish: { cpu_id = 2 }, ", PUBLISHED),
        ("[1795458770.000000005] ros2:rcl_publish: { cpu_id = 2 }, ", PUBLISHED),
        (
            "\x1b[1m[\x1b[22m1795458770.000000005\x1b[1m]\x1b[22m robot \x1b[35mros2:rcl_publish\x1b[0m: "
            "{ cpu_id = 2 }, ",
            PUBLISHED,
        ),
        (
            "timestamp = 13:10:14.000000005, delta = +0.000000001, trace:hostname = robot, "
            "name = ros2:rcl_publish, stream.packet.context = { cpu_id = 2 }, ",
            "stream.event.context = { vpid = 7, vtid = 8 }, event.fields = { message = 0x1, publisher_handle "
            "= 0xa }\n",
        ),
        (
            "[13:10:14.000000005] (+0.000000001) robot/ust/uid/0/64-bitrobot:ust:TRACE_DEBUG_LINE (13) "
            "ros2:rcl_publish: { cpu_id = 2 }, ",
            PUBLISHED,
        ),
        (
            "[13:10:14.000000005] robot ros2:rcl_publish: { cpu_id = 2 }, ",
            '{ procname = "x", vtid = 8, cpu = 1, vpid = 7 }, { message = 0x1, publisher_handle = 0xa }\r\n',
        ),
    ],
)
def test_whatever_fields_and_times_are_shown(head: str, tail: str, tmp_path: Path) -> None:
    (event,) = read_lines(tmp_path, head + tail)
    assert event.time % 1_000_000_000 == 5
    assert event.process.split()[-1:] + event.thread.split()[-2:] == ["7", "7", "8"]
    assert (event.name, event.fields) == ("rcl_publish", ("0xa",))


def line(time: str, name: str = "ros2:rcl_publish", rest: str = PUBLISHED) -> str:
    return f"[{time}] robot {name}: {{ cpu_id = 0 }}, {rest}"


def test_midnight_is_no_way_back(tmp_path: Path) -> None:
    events = read_lines(
        tmp_path, line("23:59:59.999999999"), line("00:00:00.000000001"), line("00:00:00.000000001")
    )
    assert [each.time - events[0].time for each in events] == [0, 2, 2]
    with pytest.raises(TracingError, match=r"trace\.txt:2: is earlier than the event before"):
        read_lines(tmp_path, line("13:00:00.000000001"), line("12:59:59.999999999"))


def test_what_is_not_understood_is_counted(tmp_path: Path) -> None:
    path = tmp_path / "trace.txt"
    path.write_text(
        line("1.000000000")
        + "11-23 18:33:15.363 23376 W PLUGIN/SRC.CTF.FS something is wrong\n"
        + line(
            "2.000000000", "sched_switch", '{ prev_comm = "ros2:rcl_publish: { publisher_handle = 0x1 }" }\n'
        )
        + line("3.000000000", "ros2:not_yet_known", "{ thing = 1 }\n")
        + line("4.000000000", rest="{ vpid = 7, vtid = 8 }, { message = 0x1 }\n")
        + line("5.000000000")[:-5]
    )
    tracing = Tracing(path)
    assert [each.time for each in tracing.events()] == [1_000_000_000]
    assert (tracing.read, tracing.foreign, tracing.odd) == (3, 1, 3)
    assert len(list(tracing.events())) == 1
    assert (tracing.read, tracing.foreign, tracing.odd) == (3, 1, 3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b"", "is empty"),
        (b"Dear reader,\n" * 3, "is not a trace"),
        (b"\x00\xff" * 300, "is not a trace"),
        (b"x" * (LONGEST_LINE + 2), "a line is too long"),
        (line("1.0").encode(), "is not a trace"),
        (line("1.000000000", "sched_switch").encode(), "holds no event of ROS 2"),
        (
            line("1.000000000", rest="{ 7, 8 }, { 0xa, 0x1 }\n").encode(),
            "has no process and thread",
        ),
        (line("1.000000000", rest="{ vpid = 7 }, { publisher_handle = 0xa }\n").encode(), "vpid, vtid"),
    ],
)
def test_what_is_no_trace_is_one_line(text: bytes, message: str, tmp_path: Path) -> None:
    path = tmp_path / "trace.txt"
    path.write_bytes(text)
    with pytest.raises(TracingError, match=message) as raised:
        read(path)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("long", ["o" * 60_000, '\\"' * 30_000, '"' + '\\"' * 30_000 + "\\", "a = " * 15_000])
@pytest.mark.parametrize(
    "beginning", ["[1.000000000] ", line("1.000000000", rest="{ vpid = 1, vtid = 1 }, { ")]
)
def test_long_lines_take_no_time_that_grows_faster_than_they_do(
    beginning: str, long: str, tmp_path: Path
) -> None:
    """With a pattern that tries all places again, each of these hundred lines would take seconds or more."""
    with pytest.raises(TracingError, match="is not a trace"):
        read_lines(tmp_path, *[f"{beginning}{long}\n"] * 100)


def test_long_names_are_cut(tmp_path: Path) -> None:
    trace = Trace()
    trace.node(f"/{'n' * 10_000}")
    (event,) = read(trace.write(tmp_path / "trace.txt"))
    assert 100 < len(event.fields[1]) <= 300


@settings(suppress_health_check=list(HealthCheck), deadline=None)
@given(st.data())
def test_damage_ends_in_an_error_or_fewer_events(tmp_path: Path, data: st.DataObject) -> None:
    content = bytearray(TEXT.read_bytes()[:4000])
    for _ in range(data.draw(st.integers(1, 5))):
        at = data.draw(st.integers(0, len(content) - 1))
        content[at : at + data.draw(st.integers(0, 40))] = data.draw(st.binary(max_size=40))
    path = tmp_path / "damaged.txt"
    path.write_bytes(content)
    tracing = Tracing(path)
    try:
        found = list(tracing.events())
    except DinerosError as error:
        assert "\n" not in str(error)
    else:
        assert len(found) <= tracing.read <= content.count(b"\n")
