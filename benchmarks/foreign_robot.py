"""The robot of `examples/foreign`, recorded and explained: ``python -m benchmarks.foreign_robot``.

Its twelve nodes, mended, run as processes of their own; the recorder comes later, as `ros2 bag record` does.
Then the model that is imported explains the recording, with several tolerances.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

from dineros.metamodel import sym
from dineros.observation.explaining import Explainer
from dineros.observation.importing.building import to_model
from dineros.observation.recordings import Recording
from dineros.runtime.ros.process.domains import claimed_domain
from dineros.runtime.ros.process.environment import ros_environment
from dineros.runtime.ros.process.memory import remove_abandoned
from tests.support.foreign import given, robot, running

STARTING = 15.0
"""Seconds until all nodes run, also where a machine is busy."""

TOLERANCES = (0.0, 0.001, 0.002, 0.01)
"""Seconds."""


def record(path: Path, seconds: float) -> None:
    """Record all topics of the mended robot."""
    system = robot(mended=True)
    types = {port.topic: port.type for node in system.nodes for port in node.publishers}
    with claimed_domain() as domain, ExitStack() as stack:
        environment = ros_environment(path.parent / "ros", domain)
        for node in system.nodes:
            name = node.name.rpartition("/")[2]
            stack.enter_context(running(environment, name, "--mended"))
        time.sleep(STARTING)
        words = [f"{topic}={kind}" for topic, kind in types.items()]
        recorder = subprocess.Popen(
            [sys.executable, "-m", "tests.support.recorder", str(path), *words],
            env=environment,
            stdout=subprocess.DEVNULL,
        )
        time.sleep(seconds)
        recorder.terminate()
        recorder.wait()
    remove_abandoned()


def explained(name: str, model: sym.SystemModel, path: Path, tolerance: float) -> None:
    """Explain a recording, and print how fast that is."""
    with Recording(path) as recording:
        messages = [(topic, at) for topic, at, _ in recording.messages()]
        explainer = Explainer(model, recording.topics, tolerance=tolerance, midway=True)
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
        path = options.bag or Path(folder, "bag")
        if options.bag is None:
            record(path, options.seconds)
        print(f"{'model':>8} {'tolerance':>10} {'messages':>10} {'per second':>12}")
        for tolerance in TOLERANCES:
            explained("given", to_model(robot(mended=True), given(mended=True)).model, path, tolerance)
            explained("open", to_model(robot(mended=True)).model, path, tolerance)


if __name__ == "__main__":
    main()
