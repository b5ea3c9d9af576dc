"""A recorder: ``python -m tests.support.programs.recorder OUT /topic=package/msg/Type ..``, until SIGTERM.

It stands for ``ros2 bag record``, which comes with ROS 2 only.
"""

from __future__ import annotations

import signal
import sys
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rosbags.interfaces import Connection
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

SILENT = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Matches every publisher, and holds none of them back."""


def record(path: Path, topics: dict[str, str]) -> None:
    """Record topics, by name and type, until the process is asked to end."""
    store = get_typestore(Stores.ROS2_JAZZY)
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        node = Node("recorder")

        def write(connection: Connection, data: bytes, info: dict[str, Any]) -> None:
            writer.write(connection, info["source_timestamp"], data)

        for topic, kind in topics.items():
            connection = writer.add_connection(topic, kind, **_definition(kind, store))
            node.create_subscription(_class_of(kind), topic, partial(write, connection), SILENT, raw=True)
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        ending: list[int] = []
        signal.signal(signal.SIGTERM, lambda number, _: ending.append(number))
        print("records", flush=True)
        while not ending:
            executor.spin_once(timeout_sec=0.1)


def _class_of(kind: str) -> Any:
    """Return the class of a message, or of a service's events: ``package/srv/Name_Event``."""
    package, folder, name = kind.split("/")
    module = import_module(f"{package}.{folder}")
    return getattr(module, name.removesuffix("_Event")).Event if folder == "srv" else getattr(module, name)


def _definition(kind: str, store: Typestore) -> dict[str, Any]:
    """Return what says what a type is; of events, `ros2 bag` writes down their fields, which nobody reads."""
    if "/srv/" not in kind:
        return {"typestore": store}
    return {"msgdef": "service_msgs/ServiceEventInfo info\n", "rihs01": "RIHS01_0"}


if __name__ == "__main__":
    record(Path(sys.argv[1]), dict(each.split("=") for each in sys.argv[2:]))
