"""What the engine adds to a topic round trip between two processes on ROS 2: under 60 us (median).

Two nodes throw a text of 200 bytes to and fro: once as plain rclpy callbacks, once as two nets, by turns in
the same two processes, so that both meet the same machine. ``--journal`` lets the nets record all they do.
The processor time that both processes take for a round trip is reported as well: it says more than the time
on the clock if the machine has other work.
"""

from __future__ import annotations

import argparse
import contextlib
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
from dineros.runtime import Net
from dineros.runtime.journal import JournalRecorder
from dineros.runtime.ros.process.domains import claimed_domain
from dineros.runtime.ros.process.environment import ros_environment
from dineros.runtime.ros.running import RosNode
from dineros.transformations.flattening.split import split

LIMIT = 60e-6
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


class Bare:
    """A node with nothing but rclpy, which answers each message."""

    def __init__(
        self, name: str, source: str, target: str, answer: Callable[[Any, Callable[[Any], None]], None]
    ) -> None:
        import rclpy
        from rclpy.context import Context
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.node import Node
        from std_msgs.msg import String

        self._context = Context()
        rclpy.init(context=self._context)
        self._node = Node(name, context=self._context)
        self.publish = publish = self._node.create_publisher(String, target, 10).publish
        self._node.create_subscription(String, source, lambda message: answer(message, publish), 10)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._spin, daemon=True)
        self._thread.start()
        self._source, self._target = source, target

    def _spin(self) -> None:
        from rclpy.executors import ExternalShutdownException

        with contextlib.suppress(ExternalShutdownException):
            self._executor.spin()

    def await_partner(self) -> None:
        """Wait until a subscription exists and answers."""
        while not (self._node.count_subscribers(self._target) and self._node.count_publishers(self._source)):
            time.sleep(0.01)

    def close(self) -> None:
        import rclpy

        self._executor.shutdown()
        self._thread.join()
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)


def recorder(folder: Path | None, node: str) -> JournalRecorder | None:
    """Return a recorder where a folder is given."""
    return JournalRecorder(folder, node) if folder else None


def echo(folder: Path | None) -> None:
    """Be the other process until standard input ends."""
    plain = Bare("bare_pong", "/bare/to", "/bare/fro", lambda message, publish: publish(message))
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
        """Note one round; return whether the block continues."""
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


def measure(folder: Path | None, other: int) -> tuple[list[float], list[float], list[float]]:
    """Return the seconds of each round trip, of the plain nodes and of the nets, and both processor times."""
    from benchmarks._processes import thread_seconds  # the other process is none of a package

    processes, times = [os.getpid(), other], [0.0, 0.0]
    plain_watch, net_watch = Stopwatch(), Stopwatch()

    def again(message: Any, publish: Callable[[Any], None]) -> None:
        if plain_watch.round():
            publish(message)

    from std_msgs.msg import String

    plain = Bare("bare_ping", "/bare/fro", "/bare/to", again)
    plain.await_partner()
    net = Net(part("ping"))
    net_watch.begin()

    @net.handler("TAgain")
    def throw(firing: Any) -> None:
        if not net_watch.round():
            net.signal("Go").set(False)

    arguments = ["--ros-args", "-p", "expected_subscribers.to:=1"]
    with RosNode(net, recorder(folder, "ping"), arguments=arguments):
        for block in range(BLOCKS):
            begun = sum(map(thread_seconds, processes))
            plain_watch.begin()
            plain.publish(String(data=TEXT))
            plain_watch.wait()
            between = sum(map(thread_seconds, processes))
            if block:
                net_watch.begin()
                net.signal("Go").set(True)
            net_watch.wait()
            if block:  # the first one begins before
                times[0] += between - begun
                times[1] += sum(map(thread_seconds, processes)) - between
            net.wait_for(lambda state: not state.signals["Go"] and state.count("Back") == 1, 60)
    plain.close()
    rounds = (BLOCKS - 1) * (ROUNDS + WARMING)
    return plain_watch.seconds, net_watch.seconds, [seconds / rounds for seconds in times]


def main() -> None:
    """Measure, print, and fail where the engine adds too much."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--journal", action="store_true", help="let the nets record all they do")
    parser.add_argument("--echo", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.echo is not None:
        echo(Path(options.echo) if options.echo else None)
        return
    with tempfile.TemporaryDirectory() as folder, claimed_domain() as domain:
        journal = Path(folder) / "journal" if options.journal else None
        os.environ.update(ros_environment(Path(folder), domain, "memory"))
        command = [sys.executable, __file__, "--echo", str(journal or "")]
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
            assert other.stdin is not None
            assert other.stdout is not None
            other.stdout.readline()
            try:
                plain, nets, times = measure(journal, other.pid)
            finally:
                other.stdin.close()
    added = statistics.median(nets) - statistics.median(plain)
    for name, seconds, time_ in (("plain rclpy", plain, times[0]), ("two nets", nets, times[1])):
        quarters = statistics.quantiles(seconds, n=20)
        print(
            f"{name:<12} median {statistics.median(seconds) * 1e6:6.0f} us, 5 % {quarters[0] * 1e6:6.0f} us, "
            f"95 % {quarters[-1] * 1e6:6.0f} us, {len(seconds)} round trips, "
            f"processor time {time_ * 1e6:6.0f} us each"
        )
    print(f"the engine adds {added * 1e6:.0f} us to a round trip, on both sides together")
    if added > LIMIT:
        sys.exit(f"more than {LIMIT * 1e6:.0f} us")


if __name__ == "__main__":
    main()
