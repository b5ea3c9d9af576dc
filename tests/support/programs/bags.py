"""Recordings of rosbag2 for tests, written by the library that reads them."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping
from pathlib import Path

from rosbags.interfaces import Qos
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

MILLISECOND = 1_000_000
STRING = b"\x00\x01\x00\x00\x02\x00\x00\x00a\x00"
"""The text ``a`` as std_msgs/msg/String."""


def service_event(kind: int, number: int, client: int = 1) -> bytes:
    """Return an event of service introspection: its kind (0 to 3), its request's number, its client."""
    info = struct.pack("<B3xiI16sxxxxq", kind, 0, 0, bytes([client] * 16), number)
    return b"\x00\x01\x00\x00" + info + bytes(8)


def write_bag(
    path: Path,
    messages: Iterable[tuple[str, int] | tuple[str, int, bytes]],
    *,
    types: Mapping[str, str] | None = None,
    offered: Mapping[str, list[Qos]] | None = None,
    storage: str = "mcap",
) -> Path:
    """Write a recording; return its folder.

    Parameters
    ----------
    messages
        Topic and time in nanoseconds of each; its data, where that is not text ``a``.
    types
        Of topics that carry no std_msgs/msg/String; topics named here are there without a message, too.
    """
    kinds = {"std_msgs/msg/String": get_typestore(Stores.ROS2_JAZZY)}
    types, offered = types or {}, offered or {}
    with Writer(path, version=9, storage_plugin=StoragePlugin[storage.upper()]) as writer:
        connections = {}

        def connection(topic: str):  # type: ignore[no-untyped-def]
            if topic not in connections:
                kind = types.get(topic, "std_msgs/msg/String")
                store = kinds.get(kind)
                definition = (
                    {"typestore": store} if store else {"msgdef": "string data\n", "rihs01": "RIHS01_0"}
                )
                qualities = offered.get(topic, [])
                connections[topic] = writer.add_connection(
                    topic, kind, offered_qos_profiles=qualities, **definition
                )
            return connections[topic]

        for topic in types:
            connection(topic)
        for topic, time, *data in messages:
            writer.write(connection(topic), time, data[0] if data else STRING)
    return path
