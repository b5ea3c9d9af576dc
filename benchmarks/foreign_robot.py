"""The robot of `examples/foreign`, recorded and explained: ``python -m benchmarks.foreign_robot``.

Its twelve nodes, mended, run as processes of their own; the recorder comes later, as `ros2 bag record` does.
Then the model that is imported explains the recording, with several tolerances.
"""

import argparse
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

from dineros.metamodel import sym
from dineros.observation.explaining import Explainer
from dineros.observation.importing.building import to_model
from dineros.observation.systems import RecordedTopic
from dineros.runtime.ros.process.domains import claimed_domain
from dineros.runtime.ros.process.environment import ros_environment
from dineros.runtime.ros.process.memory import remove_abandoned
from tests.support.foreign import given, heard, record, robot, running

STARTING = 15.0
"""Seconds until all nodes run, also where a machine is busy."""

TOLERANCES = (0.0, 0.001, 0.002, 0.01)
"""Seconds."""


def recorded(path: Path, seconds: float) -> list[tuple[str, int]]:
    """Record all topics of the mended robot, each node of it in a process."""
    with claimed_domain() as domain, ExitStack() as stack:
        environment = ros_environment(path.parent / "ros", domain)
        for node in robot(mended=True).nodes:
            name = node.name.rpartition("/")[2]
            stack.enter_context(running(environment, name, "--mended"))
        time.sleep(STARTING)
        messages = record(path, environment, seconds)
    remove_abandoned()
    return messages


def explained(name: str, model: sym.SystemModel, messages: list[tuple[str, int]], tolerance: float) -> None:
    """Explain what was recorded, and print how fast that is."""
    topics = [RecordedTopic(topic, "") for topic in sorted({topic for topic, _ in messages})]
    explainer = Explainer(model, topics, tolerance=tolerance, midway=True)
    began = time.process_time()
    for topic, at in messages:
        if (first := explainer.add(topic, at)) is not None:
            raise SystemExit(f"{name}: {first}")
    assert explainer.finish() is None
    seconds = time.process_time() - began
    print(f"{name:>8} {tolerance:10} {len(messages):10,} {len(messages) / seconds:12,.0f}", flush=True)


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=180.0, help="how long is recorded")
    parser.add_argument("--bag", type=Path, help="a recording made before")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        messages = heard(options.bag) if options.bag else recorded(Path(folder, "bag"), options.seconds)
        print(f"{'model':>8} {'tolerance':>10} {'messages':>10} {'per second':>12}")
        for tolerance in TOLERANCES:
            explained("given", to_model(robot(mended=True), given(mended=True)).model, messages, tolerance)
            explained("open", to_model(robot(mended=True)).model, messages, tolerance)


if __name__ == "__main__":
    main()
