"""What the engine adds to a topic round trip between two processes on ROS 2: at most 150 us (median).

Two nodes throw a text of 200 bytes to and fro: once as plain rclpy callbacks, once as two nets, by turns in
the same two processes, so that both meet the same machine. ``--journal`` lets the nets record all they do.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from dineros.metamodel import rtm, sym
from dineros.metamodel.build import flow
from dineros.metamodel.clauses import set_clause
from dineros.runtime.journal import JournalRecorder
from dineros.runtime.net import Net
from dineros.runtime.ros.environment import ros_environment
from dineros.runtime.ros.running import RosNode
from dineros.runtime.ros.session import Session
from dineros.transformations.split import split

LIMIT = 150e-6
BLOCKS = 20
ROUNDS = 150
WARMING = 20
"""Rounds of a block that do not count."""
TEXT = "x" * 200


def game() -> sym.SystemModel:
    """Return two nets that throw one token to and fro."""
    back, again, out = sym.Place(id="Back"), sym.Transition(id="TAgain"), sym.Place(id="Ping", tokens=1)
    out.balloons.append(sym.BalloonToken(data=f'{{"text": "{TEXT}"}}'))
    ping = sym.NodeNet(
        id="ping", objects=[back, again, out], signals=[sym.InputSignal(id="Go", initial=True)]
    )
    flow(back, again, out)
    set_clause(again, "Go")
    heard, echo, pong = sym.Place(id="Heard"), sym.Transition(id="TEcho"), sym.Place(id="Pong")
    pong_net = sym.NodeNet(id="pong", objects=[heard, echo, pong])
    flow(heard, echo, pong)

    def topic(id: str, source: sym.Place, target: sym.Place) -> sym.TopicChannel:
        return sym.TopicChannel(
            id=id,
            topic=f"/net/{id}",
            type="std_msgs/msg/String",
            mappings=[sym.FieldMapping(part="message", messageField="data", tokenField="text")],
            publishers=[sym.PublisherPort(place=source)],
            subscribers=[sym.SubscriberPort(place=target)],
        )

    return sym.SystemModel(
        id="game",
        tokenType=sym.TokenType(id="Ball", fields=[sym.TokenField(name="text")]),
        pages=[ping, pong_net],
        channels=[topic("to", out, heard), topic("fro", pong, back)],
    )


def part(node: str) -> rtm.RuntimeModel:
    """Return the runtime model of one of the nets."""
    (found,) = (each for each in split(game()) if each.node.id == node)
    return found


def bare(
    name: str, source: str, target: str, answer: Callable[[Any, Callable[[Any], None]], None]
) -> Session:
    """Return a plain rclpy node that answers each message."""
    from std_msgs.msg import String

    session = Session(name)
    publisher = session.node.create_publisher(String, target, 10)
    session.node.create_subscription(String, source, lambda message: answer(message, publisher.publish), 10)
    while name == "bare_ping" and not (
        publisher.get_subscription_count() and session.node.count_publishers(source)
    ):
        time.sleep(0.01)
    if name == "bare_ping":
        session.publisher = publisher  # type: ignore[attr-defined]
    return session


def recorder(folder: Path | None, node: str) -> JournalRecorder | None:
    """Return a recorder where a folder is given."""
    return JournalRecorder(folder, node) if folder else None


def echo(folder: Path | None) -> None:
    """Be the other process until standard input ends."""
    plain = bare("bare_pong", "/bare/to", "/bare/fro", lambda message, publish: publish(message))
    plain.start()
    with RosNode(Net(part("pong")), recorder(folder, "pong")):
        print("ready", flush=True)
        sys.stdin.read()
    plain.close()


class Stopwatch:
    """Notes when each round of a block is over, and says when the block is."""

    def __init__(self) -> None:
        self.seconds: list[float] = []
        self.is_over = threading.Event()
        self._rounds = 0
        self._last = 0.0

    def begin(self) -> None:
        self._rounds = 0
        self.is_over.clear()

    def round(self) -> bool:
        """Note one round; return whether the block goes on."""
        now = time.perf_counter()
        self._rounds += 1
        if self._rounds > WARMING:
            self.seconds.append(now - self._last)
        self._last = now
        if self._rounds < ROUNDS + WARMING:
            return True
        self.is_over.set()
        return False

    def wait(self) -> None:
        if not self.is_over.wait(60):
            sys.exit("no round trip: a message was lost")


def measure(folder: Path | None) -> tuple[list[float], list[float]]:
    """Return the seconds of each round trip, of the plain nodes and of the nets."""
    plain_watch, net_watch = Stopwatch(), Stopwatch()

    def again(message: Any, publish: Callable[[Any], None]) -> None:
        if plain_watch.round():
            publish(message)

    from std_msgs.msg import String

    plain = bare("bare_ping", "/bare/fro", "/bare/to", again)
    plain.start()
    net = Net(part("ping"))
    net_watch.begin()

    @net.handler("TAgain")
    def throw(firing: Any) -> None:
        if not net_watch.round():
            net.signal("Go").set(False)

    arguments = ["--ros-args", "-p", "expected_subscribers.to:=1"]
    with RosNode(net, recorder(folder, "ping"), arguments=arguments):
        for block in range(BLOCKS):
            plain_watch.begin()
            plain.publisher.publish(String(data=TEXT))  # type: ignore[attr-defined]
            plain_watch.wait()
            if block:
                net_watch.begin()
                net.signal("Go").set(True)
            net_watch.wait()
            net.wait_for(lambda state: not state.signals["Go"] and state.count("Back") == 1, 60)
    plain.close()
    return plain_watch.seconds, net_watch.seconds


def main() -> None:
    """Measure, print, and fail where the engine adds too much."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--journal", action="store_true", help="let the nets record all they do")
    parser.add_argument("--echo", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.echo is not None:
        echo(Path(options.echo) if options.echo else None)
        return
    with tempfile.TemporaryDirectory() as folder:
        journal = Path(folder) / "journal" if options.journal else None
        domain = 1 + os.getpid() % 100
        os.environ.update(ros_environment(Path(folder), domain, "memory"))
        command = [sys.executable, __file__, "--echo", str(journal or "")]
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
            assert other.stdin is not None
            assert other.stdout is not None
            other.stdout.readline()
            try:
                plain, nets = measure(journal)
            finally:
                other.stdin.close()
    added = statistics.median(nets) - statistics.median(plain)
    for name, seconds in (("plain rclpy", plain), ("two nets", nets)):
        quarters = statistics.quantiles(seconds, n=20)
        print(
            f"{name:<12} median {statistics.median(seconds) * 1e6:6.0f} us, 5 % {quarters[0] * 1e6:6.0f} us, "
            f"95 % {quarters[-1] * 1e6:6.0f} us, {len(seconds)} round trips"
        )
    print(f"the engine adds {added * 1e6:.0f} us to a round trip, on both sides together")
    if added > LIMIT:
        sys.exit(f"more than {LIMIT * 1e6:.0f} us")


if __name__ == "__main__":
    main()
