"""Systems with counted times on real rclpy: ``python -m benchmarks.running.timed_systems --seconds 60``.

Each system runs as the nodes of one process, each node with an executor of its own. A callback works by
sleeping, which holds its thread and needs no processor. A message is held back for its latency before it is
published; what the middleware takes is added to that. Times are drawn from their intervals: every fourth is
the least, every fourth the greatest, the others are uniform. The nodes are made again several times, and each
time the timers whose offset is open begin at other moments.

The table compares the greatest response times and latencies observed with the counted ones, which `dineros
latency` answers exactly (``tests/analysis/latencies/test_answers.py``). A response of a subscription is taken
from the moment of publication, so it contains the latency of its topic. Times are in units. The status is 1
unless all that was observed is within the bounds and the allowance, and each greatest value at least half of
its bound.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import queue
import random
import subprocess
import sys
import tempfile
import threading
import time
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

from dineros.runtime.ros.process.domains import claimed_domain
from dineros.runtime.ros.process.environment import ros_environment
from tests.support.timed_systems.counted import CHAINS, COUNTED, RESPONSES

ROOT = Path(__file__).resolve().parents[2]
TEN = (1, 2, 3, 4, 7, 9, 10, 11, 12, 14)
WARM_UP = 2.0
"""Seconds at the beginning of each part that do not count: nodes discover each other."""
LEAST_SHARE = 0.5
"""How close to its bound the greatest value observed must come, as a part of the bound."""
SHARE_OF_ENDS = 0.25
"""How many of the drawn times are the least, and how many are the greatest."""


HEADER = (
    f"{'system':12} {'from':>5} {'to':>5} {'times':>7} {'least':>7} {'50 %':>7} {'99 %':>7} {'most':>7}"
    f" {'share':>6} {'over':>5} {'late':>5} {'early':>5}  as asked"
)
"""Bounds; what was observed; the greatest as a part of its bound; over the bound, and over the allowance.

At the end of a row: whether nothing is beyond bounds and allowance, and the share is at least `LEAST_SHARE`.
"""


def drawn(least: float, greatest: float) -> float:
    """Return a time of an interval, its two ends more often than others: they make the worst cases."""
    share = random.random()
    if share < SHARE_OF_ENDS:
        return least
    return greatest if share < 2 * SHARE_OF_ENDS else random.uniform(least, greatest)


class Late:
    """A thread that does things at their times.

    It holds messages back for their latencies. Things with the same time are done in the order in which they
    were asked for.
    """

    def __init__(self) -> None:
        self._due: queue.PriorityQueue[tuple[float, int, Callable[[], None]]] = queue.PriorityQueue()
        self._count = itertools.count()
        self._wakes = threading.Condition()
        self._is_over = False
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def at(self, moment: float, thing: Callable[[], None]) -> None:
        """Do a thing at a moment of the monotonic clock."""
        with self._wakes:
            self._due.put((moment, next(self._count), thing))
            self._wakes.notify()

    def stop(self) -> None:
        """Leave out what is not done yet, and end the thread."""
        with self._wakes:
            self._is_over = True
            self._wakes.notify()
        self._thread.join()

    def _serve(self) -> None:
        while True:
            with self._wakes:
                while not self._is_over and (self._due.empty() or self._due.queue[0][0] > time.monotonic()):
                    rest = None if self._due.empty() else self._due.queue[0][0] - time.monotonic()
                    self._wakes.wait(rest)
                if self._is_over:
                    return
                _, _, thing = self._due.get()
            thing()


class Running:
    """One system as nodes of rclpy.

    Parameters
    ----------
    number : int
        Of the system.
    unit : float
        Seconds of a unit.
    """

    def __init__(self, number: int, unit: float) -> None:
        import rclpy
        from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor

        system = COUNTED[number].system
        self.unit, self.chain, self.latency = unit, CHAINS.get(number), system["latency"]
        self.late = Late()
        self.arrivals: dict[str, float] = {}
        """By topic, when the message that was published last arrives: messages keep their order."""
        self.times: dict[str, list[float]] = defaultdict(list)
        self.nodes: dict[str, Any] = {name: rclpy.create_node(name) for name in system["nodes"]}
        self.publishers: dict[tuple[str, str], Any] = {}
        self.groups: dict[tuple[str, str], Any] = {}
        self.executors = []
        for callback in system["callbacks"]:
            self._add(callback)
        for name, node in self.nodes.items():
            threads = system["nodes"][name]["threads"]
            executor = SingleThreadedExecutor() if threads == 1 else MultiThreadedExecutor(threads)
            executor.add_node(node)
            self.executors.append(executor)

    def spin(self, seconds: float) -> dict[str, list[float]]:
        """Run for some seconds, and return what ended after the warm-up, by callback."""
        threads = [threading.Thread(target=executor.spin, daemon=True) for executor in self.executors]
        for thread in threads:
            thread.start()
        time.sleep(WARM_UP)
        self.times.clear()
        time.sleep(seconds)
        observed = {name: list(values) for name, values in list(self.times.items())}
        for executor in self.executors:
            executor.shutdown()
        for thread in threads:
            thread.join()
        self.late.stop()
        for node in self.nodes.values():
            node.destroy_node()
        return observed

    def _group(self, callback: dict[str, Any]) -> Any:
        from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup

        key = callback["node"], callback["group"]
        if key not in self.groups:
            kind = ReentrantCallbackGroup if key[1] == "reentrant" else MutuallyExclusiveCallbackGroup
            self.groups[key] = kind()
        return self.groups[key]

    def _add(self, callback: dict[str, Any]) -> None:
        from std_msgs.msg import String

        node = self.nodes[callback["node"]]
        for _, *rest in callback["script"]:
            topic = rest[-1]
            if isinstance(topic, str) and (callback["node"], topic) not in self.publishers:
                self.publishers[callback["node"], topic] = node.create_publisher(String, topic, 10)
        if "period" in callback:
            period = callback["period"] * self.unit

            def strikes() -> None:
                # The timer keeps its phase, so the next strike says when this one was.
                released = time.monotonic() + timer.time_until_next_call() / 1e9 - period
                self._run(callback, released, {})

            if callback["offset"] == "any":
                time.sleep(random.uniform(0, period))
            timer = node.create_timer(period, strikes, callback_group=self._group(callback))
            return

        def hears(message: Any) -> None:
            said = json.loads(message.data)
            self._run(callback, said["sent"], said["began"])

        node.create_subscription(
            String, callback["topic"], hears, callback["depth"], callback_group=self._group(callback)
        )

    def _run(self, callback: dict[str, Any], released: float, began: dict[str, float]) -> None:
        name = callback["name"]
        began = {**began, name: released}
        for kind, *rest in callback["script"]:
            if kind == "work":
                self._work(drawn(*rest))
            elif kind == "publish":
                self._publish(callback["node"], rest[0], began)
            else:
                raise ValueError(f"a step of another kind: {kind}")
        ended = time.monotonic()
        self.times[name].append((ended - released) / self.unit)
        if self.chain is not None and name == self.chain[1] and self.chain[0] in began:
            self.times["chain"].append((ended - began[self.chain[0]]) / self.unit)

    def _work(self, units: float) -> None:
        if units > 0:
            time.sleep(units * self.unit)

    def _publish(self, node: str, topic: str, began: dict[str, float]) -> None:
        from std_msgs.msg import String

        now = time.monotonic()
        message = String(data=json.dumps({"sent": now, "began": began}))
        arrival = now + drawn(*self.latency.get(topic, (0, 0))) * self.unit
        self.arrivals[topic] = arrival = max(arrival, self.arrivals.get(topic, 0))
        publisher = self.publishers[node, topic]
        if arrival <= now:
            publisher.publish(message)
        else:
            self.late.at(arrival, lambda: publisher.publish(message))


def bounds_of(number: int) -> dict[str, tuple[float, float]]:
    """Return by callback, and for the chain, what may be observed, in units."""
    system = COUNTED[number].system
    found: dict[str, tuple[float, float]] = {}
    for callback in system["callbacks"]:
        name = callback["name"]
        if name in RESPONSES.get(number, {}):
            least, greatest = RESPONSES[number][name]
            late = system["latency"].get(callback.get("topic"), (0, 0))[1]
            found[name] = least, greatest + late
    if number in CHAINS:
        found["chain"] = CHAINS[number][2:4]
    return found


def one(number: int, unit: float, seconds: float, parts: int) -> None:
    """Run a system several times, and print what was observed as JSON."""
    import rclpy

    rclpy.init()
    observed: dict[str, list[float]] = defaultdict(list)
    for _ in range(parts):
        for name, values in Running(number, unit).spin(seconds / parts).items():
            observed[name] += values
    print(json.dumps({name: sorted(values) for name, values in observed.items()}), flush=True)
    rclpy.shutdown()


def table(number: int, unit: float, seconds: float, parts: int, allowance: float) -> bool:
    """Run a system in a process of its own, print its rows, and return whether all is as it must be."""
    command = [sys.executable, "-P", "-m", "benchmarks.running.timed_systems"]
    arguments = [f"--one={number}", f"--unit={unit}", f"--seconds={seconds}", f"--parts={parts}"]
    with tempfile.TemporaryDirectory() as folder, claimed_domain() as domain:
        environment = ros_environment(Path(folder), domain)
        paths = environment.get("PYTHONPATH", "").split(os.pathsep)
        environment["PYTHONPATH"] = os.pathsep.join(filter(None, [str(ROOT), *paths]))
        said = subprocess.run(
            [*command, *arguments], env=environment, stdout=subprocess.PIPE, check=True,
            timeout=seconds + 60 * parts,
        ).stdout  # fmt: skip
    observed = json.loads(said)
    is_fine = True
    for name, (least, greatest) in bounds_of(number).items():
        values = observed.get(name, [])
        if not values:
            print(f"{number:>3} {name:8} {least:5} {greatest:5}   nothing was observed")
            is_fine = False
            continue
        late = sum(value > greatest + allowance for value in values)
        early = sum(value < least - allowance for value in values)
        middle, most = values[len(values) // 2], values[-1]
        is_right = not late and not early and most >= LEAST_SHARE * greatest
        is_fine &= is_right
        print(
            f"{number:>3} {name:8} {least:5} {greatest:5} {len(values):7} {values[0]:7.2f} {middle:7.2f} "
            f"{values[int(0.99 * len(values))]:7.2f} {most:7.2f} {most / greatest:6.2f} "
            f"{sum(value > greatest for value in values):5} {late:5} {early:5}"
            f"  {'yes' if is_right else 'no'}",
            flush=True,
        )
    return is_fine


def main() -> None:
    """Run the systems one after another."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0, help="of each system")
    parser.add_argument("--parts", type=int, default=6, help="how often the nodes are made, in that time")
    parser.add_argument("--unit", type=float, default=0.05, help="seconds of a unit of time")
    parser.add_argument("--allowance", type=float, default=0.2, help="for the machine, in units")
    parser.add_argument("--systems", type=int, nargs="*", default=TEN)
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.one is not None:
        one(given.one, given.unit, given.seconds, given.parts)
        return
    print(HEADER)
    results = [
        table(number, given.unit, given.seconds, given.parts, given.allowance) for number in given.systems
    ]
    right = sum(results)
    print(
        f"{right} of {len(results)} systems as asked: nothing more than {given.allowance} units"
        f" ({given.allowance * given.unit * 1000:g} ms) beyond its bounds, each greatest value at least"
        f" {LEAST_SHARE} of its bound"
    )
    sys.exit(0 if right == len(results) else 1)


if __name__ == "__main__":
    main()
