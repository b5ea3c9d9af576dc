"""The twelve plain nodes of `examples/foreign`: as processes, and as what is to be seen of them."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from time import sleep

from dineros.analysis.answers.budget import Budget
from dineros.analysis.callbacks.searching import Search, searched
from dineros.analysis.callbacks.waiting import Waiting
from dineros.analysis.model.subject import base_subject
from dineros.analysis.nets.witness import replay
from dineros.metamodel import sym
from dineros.metamodel.constraints import validate
from dineros.metamodel.matching import Quality
from dineros.observation.importing.given import Given, GivenCallback
from dineros.observation.importing.given_reading import read_given
from dineros.observation.recordings import Recording, RecordingError
from dineros.observation.systems import USUAL, Endpoint, ObservedNode, ObservedSystem, TopicEndpoint

FOREIGN = Path(__file__).resolve().parents[3] / "examples/foreign"
SENSOR = USUAL._replace(reliability="bestEffort")
LATCHED = USUAL._replace(durability="transientLocal")
SECOND = 1_000_000_000
TEXT, NUMBER, TRIGGER = "std_msgs/msg/String", "std_msgs/msg/Float64", "std_srvs/srv/Trigger"

NESTED = (
    "deadlock in node planner: service callback planner.serves_plan (instance 1) blocks in a call of service "
    "/where; the response needs the default callback group and the only thread, which planner.serves_plan "
    "(instance 1) itself holds"
)
"""Why the robot's planner waits forever."""


def port(topic: str, type: str = TEXT, quality: Quality = USUAL, depth: int | None = None) -> TopicEndpoint:
    return TopicEndpoint(topic, type, quality, depth)


def trigger(name: str) -> Endpoint:
    return Endpoint(name, TRIGGER)


def given(fixed: bool = False) -> Given:
    """Return what people know of the robot; fixed, its planner takes the answer on a second thread."""
    known = read_given(FOREIGN / "robot.given.toml")
    if not fixed:
        return known
    planner, monitor = (known.node(name) for name in ("/planner", "/monitor"))
    group = {"/where": GivenCallback((), "answers")}
    changed = {
        "/planner": replace(
            planner, threads=2, groups={"answers": "exclusive"}, callbacks={**planner.callbacks, **group}
        ),
        "/detector": replace(known.node("/detector"), depths={"/image": 5, "/obstacles": 10}),
        "/monitor": replace(monitor, depths={**monitor.depths, "/battery_level": 10}),
    }
    return replace(known, nodes={**known.nodes, **changed})


def robot(fixed: bool = False) -> ObservedSystem:
    """Return what is to be seen of the robot, written down by hand from its programs."""
    nodes = [
        ObservedNode("/sensors/lidar", publishers=(port("/scan", quality=SENSOR),)),
        ObservedNode("/sensors/camera", publishers=(port("/image", quality=SENSOR),)),
        ObservedNode("/sensors/imu", publishers=(port("/imu", NUMBER),)),
        ObservedNode(
            "/detector",
            publishers=(port("/obstacles"),),
            subscribers=(port("/image", quality=SENSOR if fixed else USUAL),),
        ),
        ObservedNode(
            "/localizer",
            publishers=(port("/pose", NUMBER),),
            subscribers=(port("/imu", NUMBER), port("/scan", quality=SENSOR)),
            servers=(trigger("/where"),),
        ),
        ObservedNode(
            "/mapper",
            publishers=(port("/map", quality=LATCHED),),
            subscribers=(port("/pose", NUMBER), port("/scan", quality=SENSOR)),
        ),
        ObservedNode(
            "/planner",
            publishers=(port("/path"),),
            subscribers=(port("/map", quality=LATCHED),),
            servers=(trigger("/plan"),),
            clients=(trigger("/where"),),
        ),
        ObservedNode("/commander", publishers=(port("/mission"),), clients=(trigger("/plan"),)),
        ObservedNode(
            "/driver", publishers=(port("/speed", NUMBER),), subscribers=(port("/obstacles"), port("/path"))
        ),
        ObservedNode("/base", publishers=(port("/odometry", NUMBER),), subscribers=(port("/speed", NUMBER),)),
        ObservedNode("/battery", publishers=(port("/battery_level", NUMBER),), servers=(trigger("/charge"),)),
        ObservedNode(
            "/monitor",
            subscribers=(
                port("/battery_level", NUMBER, USUAL if fixed else LATCHED),
                port("/mission"),
                port("/odometry", NUMBER),
            ),
            clients=(trigger("/charge"),),
        ),
    ]
    return ObservedSystem("the robot", tuple(sorted(nodes, key=lambda node: node.name)))


@contextmanager
def running(
    environment: Mapping[str, str], *arguments: str, program: Path = FOREIGN / "robot.py"
) -> Iterator[subprocess.Popen[bytes]]:
    """Run a program until the block ends."""
    process = subprocess.Popen(
        [sys.executable, str(program), *arguments],
        env=dict(environment),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield process
    finally:
        process.terminate()
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def record(path: Path, environment: Mapping[str, str], seconds: float) -> list[tuple[str, int]]:
    """Record the robot that runs; return topic and time of what was said while all topics were heard.

    Who has published before the recorder came is heard a little later than others; and what is under way when
    it ends is lost. Both is left out.
    """
    types = {port.topic: port.type for node in robot().nodes for port in node.publishers}
    words = [f"{topic}={kind}" for topic, kind in types.items()]
    recorder = subprocess.Popen(
        [sys.executable, "-m", "tests.support.programs.recorder", str(path), *words],
        env=dict(environment),
        cwd=FOREIGN.parents[1],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
    )
    try:
        sleep(seconds)
    finally:
        recorder.terminate()
        recorder.wait()
    return heard(path)


def heard(path: Path) -> list[tuple[str, int]]:
    """Return topic and time of each message of a recording, without its ends."""
    try:
        with Recording(path) as recording:
            messages = [(topic, time) for topic, time, _ in recording.messages()]
    except RecordingError:  # nothing was said yet
        return []
    firsts: dict[str, int] = {}
    for topic, time in messages:
        firsts.setdefault(topic, time)
    begins, ends = max(firsts.values()), messages[-1][1] - SECOND // 2
    return [(topic, time) for topic, time in messages if begins <= time <= ends]


def search(model: sym.SystemModel) -> Search:
    """Return which callbacks wait forever; the run to each, replayed on the whole net, closes its circle."""
    assert [each for each in validate(model) if each.severity == "error"] == []
    subject = base_subject(model)
    waiting = Waiting(subject)
    found = searched(subject.net, waiting, Budget(seconds=300).begun())
    for each in found.blocked:
        assert waiting.circle(replay(subject.net, each.trace)[-1], each.callback) == each.circle
    return found
