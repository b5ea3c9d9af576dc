"""`dineros narrow --tracing`: alone and beside a recording; files written; errors of one line."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from dineros.metamodel import sym
from dineros.metamodel.files import load
from dineros.observation.importing.given_reading import given_beside, read_given
from tests.cli.conftest import Run
from tests.support.programs.bags import write_bag
from tests.support.traces import MILLISECOND, Trace, program

GIVEN = """
[topic."/scan"]
publishers = ["/lidar"]
subscribers = ["/mapper"]
[topic."/odom"]
publishers = ["/wheels"]
subscribers = ["/mapper"]
[topic."/map"]
publishers = ["/mapper"]
"""
MAPS = (1, 2, 5, 6, 7, 11, 12, 15, 18, 19)
"""Rounds in which the map is published: 49 ms after the scan, and right after /odom."""


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    messages = []
    for number in range(20):
        time = number * 100 * MILLISECOND
        messages += [("/scan", time), ("/odom", time + 48 * MILLISECOND)]
        messages += [("/map", time + 50 * MILLISECOND)] if number in MAPS else []
    return write_bag(tmp_path / "monday", messages)


@pytest.fixture
def seen(bag: Path, tmp_path: Path, run: Run) -> Path:
    model = tmp_path / "seen.sym.xmi"
    given_beside(model).write_text(GIVEN)
    assert run("import", "--bag", bag, "-o", model).exit_code == 0
    return model


def traced() -> Trace:
    """The scan leads to the map, whatever times say; the wheels are not rclcpp."""
    trace = Trace()
    lidar, mapper, wheels = (trace.node(f"/{each}") for each in ("lidar", "mapper", "wheels"))
    scan, odom, grid = (
        trace.publisher(node, topic)
        for node, topic in ((lidar, "/scan"), (wheels, "/odom"), (mapper, "/map"))
    )
    tick = trace.timer(lidar, 100 * MILLISECOND)
    on_scan, on_odom = (trace.subscription(mapper, topic) for topic in ("/scan", "/odom"))
    for number in range(20):
        time = (number + 1) * 100 * MILLISECOND
        trace.at(time)
        trace.run(tick, [scan], thread=2)
        trace.start(on_scan, thread=3)
        trace.at(time + 48 * MILLISECOND)
        trace.publish(odom, thread=9)
        trace.run(on_odom, thread=4)
        trace.at(time + 49 * MILLISECOND)
        if number in MAPS:
            trace.publish(grid, thread=3)
        trace.end(on_scan, thread=3)
    return trace


@pytest.fixture
def trace(tmp_path: Path) -> Path:
    return traced().write(tmp_path / "trace.txt")


def same(count: int, time: str) -> str:
    """Return what is said of times that are all the same."""
    return f"{count} measured: least {time}, 50 % {time}, 95 % {time}, 99 % {time}, greatest {time}"


def test_proposals_of_a_trace_alone(seen: Path, trace: Path, run: Run) -> None:
    before = sorted(seen.parent.iterdir())
    result = run("narrow", seen, "--tracing", trace)
    assert (result.exit_code, result.stderr) == (0, ""), result.output
    lines = [line.split("  ", 2)[-1] for line in result.stdout.splitlines()]
    assert lines == [
        "/lidar: timer_100ms always leads to /scan (in 20 of 20 runs, after 0.002 ms to 0.002 ms; "
        "20 of 20 messages; traced)",
        "/mapper: /odom never leads to /map (in none of 20 runs; traced)",
        "/mapper: /scan sometimes leads to /map (in 10 of 20 runs, after 49 ms to 49 ms; 10 of 10 messages; "
        "traced)",
        "/wheels: a timer of 0.1 s publishes /odom (20 messages, 100 ms to 100 ms apart)",
        f"/lidar: timer_100ms takes 3 µs to 3 µs ({same(20, '3 µs')})",
        f"/lidar: timer_100ms ticks every 100 ms, jitter 0 s ({same(19, '100 ms')})",
        f"/mapper: /odom takes 1 µs to 1 µs ({same(20, '1 µs')})",
        f"/mapper: /scan takes 49 ms to 49 ms ({same(20, '49 ms')})",
        f"{trace}: 60 runs of 3 callbacks; 20 of 50 messages outside of them",
    ]
    assert sorted(seen.parent.iterdir()) == before


def test_a_trace_stands_above_the_times_of_a_recording(seen: Path, bag: Path, trace: Path, run: Run) -> None:
    by_times = run("narrow", seen, "--bag", bag).stdout
    assert "/mapper: /odom sometimes leads to /map" in by_times and "/scan sometimes" not in by_times
    both = run("narrow", seen, "--bag", bag, "--tracing", trace)
    assert "/mapper: /scan sometimes leads to /map (in 10 of 20 runs" in both.stdout
    assert "/odom sometimes" not in both.stdout


@pytest.mark.long
@pytest.mark.parametrize("with_bag", [True, False])
def test_the_narrowed_model(with_bag: bool, seen: Path, bag: Path, trace: Path, run: Run) -> None:
    output = seen.with_name("narrowed.sym.xmi")
    recording = ("--bag", bag) if with_bag else ()
    result = run("narrow", seen, *recording, "--tracing", trace, "--threshold", "0.8", "-o", output, "--json")
    assert result.exit_code == 0, result.output
    report = json.loads(result.stdout)
    assert report["narrowed"]["status"] == "conforms" and report["narrowed"]["messages"] == 50
    assert report["narrowed"]["dropped"] == []
    assert report["tracing"] == {
        "nodes": ["/lidar", "/mapper", "/wheels"],
        "runs": 60,
        "messages": 50,
        "outside": 20,
        "unknown": {"callbacks": 0, "messages": 0},
        "discarded": 0,
        "odd": 0,
    }
    nodes = read_given(given_beside(output)).nodes
    assert nodes["/lidar"].timers == {"timer_100ms": 0.1}
    assert [str(step) for step in nodes["/mapper"].callbacks["/scan"].does or ()] == ["publish /map ?"]
    assert nodes["/mapper"].callbacks["/odom"].does == ()
    head = given_beside(output).read_text().splitlines()[0]
    sources = "monday and trace.txt show" if with_bag else "trace.txt shows"
    assert head == f"# Facts that {sources} of narrowed.sym.xmi, and the facts given before."
    assert run("conform", output, "--bag", bag).exit_code == 0
    # A map after /odom, and no scan before it.
    odd = write_bag(
        bag.with_name("odd"), [("/odom", 0), ("/map", 5 * MILLISECOND), ("/scan", 400 * MILLISECOND)]
    )
    assert run("conform", seen, "--bag", odd).exit_code == 0
    assert run("conform", output, "--bag", odd).exit_code == 1


def test_what_the_trace_lacks_is_said(
    seen: Path, tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    trace = Trace()
    mapper = trace.node("/mapper")
    grid = trace.publisher(mapper, "/map")
    trace.publish(grid)
    trace.run(0x1, [0x2, 0x3])
    text = trace.write(tmp_path / "short.txt")
    with text.open("a") as file:
        file.write("[17000")
    (tmp_path / "folder").mkdir()
    script = f"echo 'Tracer discarded 3 events between' >&2; cat {text}"
    monkeypatch.setenv("PATH", f"{program(tmp_path / 'bin', script)}{os.pathsep}{os.environ['PATH']}")
    result = run("narrow", seen, "--tracing", tmp_path / "folder")
    assert result.exit_code == 0
    assert [line.partition(": ")[2] for line in result.stderr.splitlines()] == [
        "the tracer's buffer was full: 3 events are missing",
        "1 line ignored: not an event, or cut off",
        "unknown nodes of 1 run of callbacks and 2 messages: they started before the trace",
        "it contains no data of 2 nodes of the model: /lidar, /wheels",
    ]
    assert json.loads(run("narrow", seen, "--tracing", tmp_path / "folder", "--json").stdout)["tracing"] == {
        "nodes": ["/mapper"],
        "runs": 0,
        "messages": 1,
        "outside": 1,
        "unknown": {"callbacks": 1, "messages": 2},
        "discarded": 3,
        "odd": 1,
    }


def test_bad_traces_are_one_line_and_nothing_is_half_written(
    seen: Path, bag: Path, tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "empty.txt").touch()
    (tmp_path / "letter.txt").write_text("Dear reader,\n")
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    late = Trace()
    late.run(0x1, [0x2])
    late.write(tmp_path / "late.txt")
    foreign = Trace()
    foreign.publish(foreign.publisher(foreign.node("/robot/mapper"), "/map"))
    foreign.write(tmp_path / "foreign.txt")
    bad = {
        "empty.txt": "is empty",
        "letter.txt": "is not a trace",
        "pipe": "is not a plain file",
        "missing": "cannot be read: No such file",
        "late.txt": "contains no node",
        "foreign.txt": "it contains no data of a node of the model (it contains /robot/mapper)",
        "folder": "babeltrace2, which is not on the PATH",
    }
    monkeypatch.setenv("PATH", str(tmp_path))
    before = sorted(tmp_path.iterdir())
    for name, message in bad.items():
        output = tmp_path / "out.sym.xmi"
        for more in ((), ("--bag", bag)):
            result = run(
                "narrow", seen, *more, "--tracing", tmp_path / name, "--threshold", "0.5", "-o", output
            )
            assert result.exit_code == 2, name
            assert message in result.stderr and result.stderr.count("\n") == 1, result.stderr
            assert sorted(tmp_path.iterdir()) == before


def test_something_must_have_been_seen(seen: Path, run: Run) -> None:
    result = run("narrow", seen)
    assert result.exit_code == 2
    assert "--bag RECORDING, --tracing TRACE, or both" in result.stderr and result.stderr.count("\n") == 1


@pytest.mark.parametrize("odd", ["\x1b]0;pwned\x07", "\x9b2J", "\u202e", "\x1b[31m", "\x08"])
def test_names_in_a_trace_steer_no_terminal(odd: str, seen: Path, tmp_path: Path, run: Run) -> None:
    where = "host ros2:{}: {{ cpu_id = 0 }}, {{ vpid = 1, vtid = 1 }}, "
    lines = (
        where.format("rcl_node_init") + f'{{ node_handle = 0x1, node_name = "A{odd}B", namespace = "/" }}',
        where.format("rcl_publisher_init")
        + f'{{ publisher_handle = 0x2, node_handle = 0x1, topic_name = "/a{odd}" }}',
        where.format("rcl_publish") + "{ publisher_handle = 0x2 }",
    )
    trace = tmp_path / "t.txt"
    trace.write_bytes(
        "".join(f"[12:00:00.00000000{n}] (+0.1) {line}\n" for n, line in enumerate(lines)).encode()
    )
    result = run("narrow", seen, "--tracing", trace)
    assert result.exit_code == 2
    assert "it contains no data of a node of the model (it contains /A" in result.stderr
    assert all(each.isprintable() for each in result.output.splitlines())


def test_accepted_times_are_intervals_of_the_model(seen: Path, bag: Path, trace: Path, run: Run) -> None:
    """Those of a timer count if the timer is accepted, too; the file beside the model keeps them."""
    output = seen.with_name("measured.sym.xmi")
    words = ("narrow", seen, "--bag", bag, "--tracing", trace)
    listed = [line.split()[0] for line in run(*words).stdout.splitlines() if " takes " in line]
    accept = [word for number in listed for word in ("--accept", number)]
    result = run(*words, *accept, "-o", output)
    assert "omitted, because the model has no such callback" in result.stderr, result.output
    pages = [each for each in load(output).eAllContents() if isinstance(each, sym.CallbackPage)]
    times = {str(each.id): each.duration for each in pages if each.duration is not None}
    assert [(each.earliest, each.latest) for each in times.values()] == [(1e-06, 1e-06), (0.048996, 0.048998)]
    assert all(str(each.source).startswith("trace.txt: 20 measured: ") for each in times.values())
    again = seen.with_name("again.sym.xmi")
    given_beside(again).write_text(given_beside(output).read_text())
    assert run("import", "--bag", bag, "-o", again).exit_code == 0
    assert run("diff", output, "--bag", bag).exit_code == 0
    assert "trace.txt: 20 measured" in again.read_text()
