"""Says on ROS what nodes cannot say themselves: that their process is gone.

A supervisor starts it where a node has failed: ``python -m dineros.runtime.ros.channels.announcer``, and
writes a line of JSON for each thing to say: ``{"topic": "/cell/arm/state", "text": "..."}``. It is latched
until a line without ``text`` takes it back, because the node runs again and speaks for itself, or until the
input ends.
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
"""Seconds that those who listen have to get the last word."""


def announce(lines: Iterable[str], session: Session) -> None:
    """Do as the lines say, until there are no more."""
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
    """Announce what stdin says; return the exit status."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the end of the input ends it
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
