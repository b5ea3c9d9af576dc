"""How fast a recording is explained, and in how much memory: a stream of messages, and files of both kinds.

Usage: ``python -m benchmarks.running.recordings [--messages 10000000] [--tolerance 0.01]``
"""

import argparse
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from rosbags.rosbag2 import StoragePlugin, Writer

from benchmarks._processes import mebibytes, watched
from dineros.metamodel import sym
from dineros.metamodel.files import load
from dineros.observation.explaining import Explainer
from dineros.observation.recordings import Recording
from dineros.observation.systems import RecordedTopic

MODEL = Path(__file__).resolve().parents[2] / "examples/callbacks/sensor_fixed.sym.xmi"
TOPICS = ("/scans", "/dones")
TEXT = "std_msgs/msg/String"
GAP = 2_000_000
"""Nanoseconds between two messages."""
IN_FILE = 200_000
"""Messages of each file."""


def stream(messages: int) -> Iterator[tuple[str, int]]:
    """Yield what a sensor and a mapper say that work at the same pace, up to three scans apart."""
    ahead = 0
    for number in range(messages):
        sends = ahead == 0 or (ahead < 3 and number % 7 < 3)
        ahead += 1 if sends else -1
        yield TOPICS[0] if sends else TOPICS[1], number * GAP


def explained(messages: int, tolerance: float) -> None:
    """Explain a stream, and print speed and memory now and then."""
    model = load(MODEL)
    assert isinstance(model, sym.SystemModel)
    recorded = [RecordedTopic(topic, TEXT) for topic in TOPICS]
    explainer = Explainer(model, recorded, tolerance=tolerance)
    for number, (topic, at) in enumerate(watched(stream(messages), messages), 1):
        if explainer.add(topic, at) is not None:
            raise SystemExit(f"no run shows message {number}")
    assert explainer.finish() is None


def read(storage: StoragePlugin) -> None:
    """Write a recording, read it, and print the speed."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "bag")
        with Writer(path, version=9, storage_plugin=storage) as writer:
            connections = {
                topic: writer.add_connection(topic, TEXT, msgdef="string data\n", rihs01="RIHS01_0")
                for topic in TOPICS
            }
            for topic, at in stream(IN_FILE):
                writer.write(connections[topic], at, b"\x00\x01\x00\x00" + bytes(60))
        began = time.process_time()
        with Recording(path) as recording:
            count = sum(1 for _ in recording.messages())
        seconds = time.process_time() - began
        print(f"{storage.name.lower():>12} {count / seconds:12,.0f} {mebibytes():8.1f}")


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--messages", type=int, default=10_000_000)
    parser.add_argument("--tolerance", type=float, default=0.01)
    options = parser.parse_args()
    explained(options.messages, options.tolerance)
    for storage in (StoragePlugin.MCAP, StoragePlugin.SQLITE3):
        read(storage)


if __name__ == "__main__":
    main()
