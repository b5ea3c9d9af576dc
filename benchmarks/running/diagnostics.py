"""What diagnostics cost a busy node: processor time of a firing, with and without.

A node with a handler fires as fast as it can on ROS, in a process of its own, by turns: without looking at
itself (``diagnostics_period`` 0), looking each second without and with a subscription on
``/diagnostics``. It should add less than 1 %. The time of one look is printed, too, by the clock of the
thread that looks: on a busy machine, runs differ by more than looks cost.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

from dineros.metamodel import rtm, sym
from dineros.metamodel.build import flow
from dineros.runtime import Net
from dineros.runtime.ros.diagnostics import Diagnostics
from dineros.runtime.ros.process.domains import claimed_domain
from dineros.runtime.ros.process.environment import ros_environment
from dineros.runtime.ros.process.memory import remove_abandoned
from dineros.runtime.ros.running import RosNode
from dineros.transformations.flattening.split import split

WAYS = {"no look": ("0.0", False), "nobody listens": ("1.0", False), "somebody listens": ("1.0", True)}
WARM = 5_000

LISTENER = """
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
rclpy.init()
node = rclpy.create_node("listener")
node.create_subscription(DiagnosticArray, "/diagnostics", lambda message: None, 10)
rclpy.spin(node)
"""


def lamp(tokens: int = 1) -> rtm.RuntimeModel:
    """Return a node that blinks forever; without tokens it waits."""
    on, off = sym.Place(id="On", tokens=tokens), sym.Place(id="Off")
    dim, light = sym.Transition(id="Dim"), sym.Transition(id="Light")
    node = sym.NodeNet(id="lamp", objects=[on, off, dim, light])
    flow(on, dim, off, light, on)
    (part,) = split(sym.SystemModel(id="room", pages=[node]))
    return part


def blink(period: str, firings: int) -> None:
    """Print the processor time of a firing, and of a look, in microseconds."""
    looks = []
    tick = Diagnostics._tick

    def timed(self: Diagnostics) -> None:
        begun = time.thread_time()
        tick(self)
        looks.append(time.thread_time() - begun)

    Diagnostics._tick = timed  # type: ignore[method-assign]
    net = Net(lamp(), seed=1)
    net.handler("Dim")(lambda firing: None)
    net.handler("Light")(lambda firing: None)
    execution = net.core.execution
    with RosNode(net, arguments=["--ros-args", "-p", f"diagnostics_period:={period}"]):
        while execution.firings < WARM:
            time.sleep(0.05)
        begun, used = execution.firings, time.process_time()
        while execution.firings < begun + firings:
            time.sleep(0.2)
        used, done = time.process_time() - used, execution.firings - begun
        print(used / done * 1e6, statistics.median(looks or [0.0]) * 1e6)


@contextmanager
def listening(environment: dict[str, str]) -> Iterator[None]:
    """Keep a subscription as long as the block lasts."""
    listener = subprocess.Popen(
        [sys.executable, "-P", "-c", LISTENER], env=environment, stderr=subprocess.DEVNULL
    )
    try:
        yield
    finally:
        listener.kill()
        listener.wait()
        remove_abandoned()


def main() -> None:
    """Measure, by turns."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--firings", type=int, default=100_000, help="in each run")
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--blink", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.blink is not None:
        blink(given.blink, given.firings)
        return
    found: dict[str, list[float]] = {way: [] for way in WAYS}
    looks: dict[str, list[float]] = {way: [] for way in WAYS}
    with tempfile.TemporaryDirectory() as folder, claimed_domain() as domain:
        environment = ros_environment(Path(folder), domain, "memory", os.environ)
        command = [sys.executable, "-P", __file__, "--firings", str(given.firings), "--blink"]
        for _ in range(given.turns):
            for way, (period, is_heard) in WAYS.items():
                with listening(environment) if is_heard else nullcontext():
                    done = subprocess.run(
                        [*command, period], env=environment, capture_output=True, text=True, check=True
                    )
                firing, look = map(float, done.stdout.split())
                found[way].append(firing)
                looks[way].append(look)
    plain = found["no look"]
    for way, times in found.items():
        added = 100 * (min(times) / min(plain) - 1)
        pairs = sorted(100 * (one / other - 1) for one, other in zip(times, plain, strict=True))
        median = statistics.median(times)
        print(
            f"{way:18} {min(times):6.2f} µs a firing (median {median:.2f}), {added:+.1f} %; "
            f"by turns {pairs[0]:+.1f} to {pairs[-1]:+.1f} %, median {statistics.median(pairs):+.1f} %; "
            f"a look {statistics.median(looks[way]):.0f} µs"
        )


if __name__ == "__main__":
    main()
