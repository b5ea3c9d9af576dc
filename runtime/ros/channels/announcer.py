"""Publishes on ROS that the process of a node has ended, which the node itself cannot do.

A supervisor starts ``python -m dineros.runtime.ros.channels.announcer`` after a node has failed, and writes
one line of JSON for each announcement: ``{"topic": "/cell/arm/state", "text": "..."}``. The text is latched
until a line without ``text`` withdraws it, because the node runs again and publishes its own state, or until
the input ends.
"""

from __future__ import annotations

import json
import os
import signal
import sys
from collections.abc import Iterable
from typing import Any

from dineros.metamodel.errors import DinerosError
from dineros.runtime.ros.channels.quality import reliable_quality
from dineros.runtime.ros.process.session import Session

_PATIENCE = 2.0
"""Seconds for subscribers to receive the last message."""


def announce(lines: Iterable[str], session: Session) -> None:
    """Publish and withdraw according to the lines, until there are no more."""
    from rclpy.duration import Duration
    from std_msgs.msg import String

    publishers: dict[str, Any] = {}
    for line in lines:
        order = json.loads(line)
        topic, text = order["topic"], order.get("text")
        publisher = publishers.pop(topic, None)
        if text is None:
            if publisher is not None:
                session.node.destroy_publisher(publisher)
            continue
        if publisher is None:
            publisher = session.node.create_publisher(String, topic, reliable_quality(is_kept=True))
        publishers[topic] = publisher
        publisher.publish(String(data=text))
    for publisher in publishers.values():
        if publisher.get_subscription_count():
            publisher.wait_for_all_acked(Duration(seconds=_PATIENCE))


def main() -> int:
    """Publish according to stdin; return the exit status."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # it ends at the end of its input
    try:
        session = Session(f"dineros_supervisor_{os.getpid()}")
    except DinerosError as error:
        print(error, file=sys.stderr)
        return 2
    try:
        session.start()
        announce(sys.stdin, session)
    finally:
        session.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
