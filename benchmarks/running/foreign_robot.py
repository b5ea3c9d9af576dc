"""The robot of `examples/foreign`, recorded and explained: ``python -m benchmarks.running.foreign_robot``.

Its twelve nodes, fixed, run as processes of their own; the recorder comes later, as `ros2 bag record` does.
Then the model that is imported explains the recording, with several tolerances. With ``--messages`` it
explains so many, of the recording again and again, each time with other times within a millisecond: so they
come in orders that were not there before.
"""

import argparse
import random
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

from benchmarks._processes import watched
from dineros.metamodel import sym
from dineros.observation.explaining import Explainer, explain
from dineros.observation.importing.building import to_model
from dineros.observation.systems import RecordedTopic
from dineros.runtime.ros.process.domains import claimed_domain
from dineros.runtime.ros.process.environment import ros_environment
from dineros.runtime.ros.process.memory import remove_abandoned
from tests.support.systems.foreign import given, heard, record, robot, running

STARTING = 15.0
"""Seconds until all nodes run, also where a machine is busy."""

PAUSE = 1_000_000_000
"""Nanoseconds between a recording and its repetition."""
JITTER = 1_000_000
"""Nanoseconds by which messages are later at most."""

TOLERANCES = (0.0, 0.001, 0.002, 0.01)
"""Seconds."""


def recorded(path: Path, seconds: float) -> list[tuple[str, int]]:
    """Record all topics of the corrected robot, each node of it in a process."""
    with claimed_domain() as domain, ExitStack() as stack:
        environment = ros_environment(path.parent / "ros", domain)
        for node in robot(fixed=True).nodes:
            name = node.name.rpartition("/")[2]
            stack.enter_context(running(environment, name, "--mended"))
        time.sleep(STARTING)
        messages = record(path, environment, seconds)
    remove_abandoned()
    return messages


def explained(name: str, model: sym.SystemModel, messages: list[tuple[str, int]], tolerance: float) -> None:
    """Explain what was recorded, and print how fast that is."""
    topics = [RecordedTopic(topic, "") for topic in sorted({topic for topic, _ in messages})]
    began = 0.0

    def read() -> Iterator[tuple[str, int]]:
        nonlocal began
        began = time.process_time()  # the model is ready
        yield from messages

    verdict = explain(model, topics, read(), tolerance=tolerance, midway=True)
    if verdict.status != "conforms":
        raise SystemExit(f"{name}: {verdict.unexplained or verdict.reason}")
    seconds = time.process_time() - began
    print(f"{name:>8} {tolerance:10} {len(messages):10,} {len(messages) / seconds:12,.0f}", flush=True)


def again(messages: list[tuple[str, int]], count: int) -> Iterator[tuple[str, int]]:
    """Yield so many messages: those of a recording again and again, a little earlier or later each time."""
    drawn = random.Random(1)
    length = messages[-1][1] - messages[0][1] + PAUSE
    last: dict[str, int] = {}
    for turn in range(-(-count // len(messages))):
        moved = []
        for topic, at in messages[: count - turn * len(messages)]:
            last[topic] = max(last.get(topic, 0) + 1, at + turn * length + drawn.randrange(JITTER))
            moved.append((last[topic], topic))
        yield from ((topic, at) for at, topic in sorted(moved))


def followed(messages: list[tuple[str, int]], count: int, tolerance: float) -> None:
    """Explain many messages by the open model, and print speed and memory now and then."""
    model = to_model(robot(fixed=True)).model
    topics = [RecordedTopic(topic, "") for topic in sorted({topic for topic, _ in messages})]
    explainer = Explainer(model, topics, tolerance=tolerance, midway=True)
    for topic, at in watched(again(messages, count), count):
        if (first := explainer.add(topic, at)) is not None:
            raise SystemExit(str(first))
    assert explainer.finish() is None


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=180.0, help="how long is recorded")
    parser.add_argument("--bag", type=Path, help="a recording made before")
    parser.add_argument("--messages", type=int, help="explain so many, and look at the memory")
    parser.add_argument("--tolerance", type=float, default=0.01, help="with --messages")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        messages = heard(options.bag) if options.bag else recorded(Path(folder, "bag"), options.seconds)
        if options.messages:
            followed(messages, options.messages, options.tolerance)
            return
        print(f"{'model':>8} {'tolerance':>10} {'messages':>10} {'per second':>12}")
        for tolerance in TOLERANCES:
            explained("given", to_model(robot(fixed=True), given(fixed=True)).model, messages, tolerance)
            explained("open", to_model(robot(fixed=True)).model, messages, tolerance)


if __name__ == "__main__":
    main()
