"""The cell as a ROS process of its own: it talks to the nodes through topics, services and signals only."""

from __future__ import annotations

import argparse
import json
import queue
import signal
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.utilities import try_shutdown
from std_msgs.msg import Bool, String  # type: ignore[import-untyped]
from std_srvs.srv import SetBool  # type: ignore[import-untyped]

from sorting_cell.cell import COMMAND_TOPIC, HUMAN_TOPIC, latched
from sorting_cell.world import Visit, World

PERIOD = 0.05
PATIENCE = 1.0


class SignalSetter:
    """Sets input signals of a node, one after the other; asks again until the node has answered.

    Parameters
    ----------
    ros : rclpy.node.Node
        The simulator's node.
    node : str
        The node that has the signals.
    """

    def __init__(self, ros: Any, node: str) -> None:
        self._ros = ros
        self._node = node
        self._clients: dict[str, Any] = {}
        self._values: dict[str, bool] = {}
        self._waiting: queue.Queue[tuple[str, bool] | None] = queue.Queue()
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._work, name=f"signals of {node}")
        self._thread.start()
        self._wanted = ros.create_subscription(String, f"/{node}/signals_wanted", self.announce, latched(1))

    def set(self, name: str, value: bool) -> None:
        """Have a signal set, after those asked for before."""
        self._values[name] = value
        self._waiting.put((name, value))

    def announce(self, _: object) -> None:
        """Have all signals set again: the node has been started, or continues after a restart."""
        for name, value in list(self._values.items()):
            self._waiting.put((name, value))

    def close(self) -> None:
        """Ask no more."""
        self._ends.set()
        self._waiting.put(None)
        self._thread.join()

    def _work(self) -> None:
        while (order := self._waiting.get()) is not None and not self._ends.is_set():
            name, value = order
            while not self._ends.is_set() and not self._ask(name, value):
                pass

    def _ask(self, name: str, value: bool) -> bool:
        if name not in self._clients:
            self._clients[name] = self._ros.create_client(SetBool, f"/{self._node}/set_signal/{name}")
        client = self._clients[name]
        if not client.wait_for_service(timeout_sec=PATIENCE):
            return False
        answered = threading.Event()
        future = client.call_async(SetBool.Request(data=value))
        future.add_done_callback(lambda _: answered.set())
        if not answered.wait(PATIENCE):
            client.remove_pending_request(future)
            return False
        return future.exception() is None and bool(future.result().success)


class Simulator:
    """The world, on ROS.

    Parameters
    ----------
    world : callable
        Makes the world, given how it sets signals and where it logs.
    """

    def __init__(
        self, world: Callable[[Callable[[str, str, bool], None], Callable[[str], None]], World]
    ) -> None:
        self.ros: Any = rclpy.create_node("cell")
        self._setters = {name: SignalSetter(self.ros, name) for name in ("executor", "selector", "sensorics")}
        self._human = self.ros.create_publisher(Bool, HUMAN_TOPIC, latched())
        self._commands = self.ros.create_subscription(String, COMMAND_TOPIC, self._command, latched())
        self.world = world(self._set, self.ros.get_logger().info)  # type: ignore[no-untyped-call]
        self.world.start()
        self._seen: bool | None = None
        self._last = time.monotonic()
        self._timer = self.ros.create_timer(PERIOD, self._tick)

    def close(self) -> None:
        """End the threads and the node."""
        for setter in self._setters.values():
            setter.close()
        self.ros.destroy_node()

    def _set(self, node: str, name: str, value: bool) -> None:
        self._setters[node].set(name, value)

    def _command(self, message: Any) -> None:
        command = json.loads(message.data)
        if command["operation"] == "abort":
            self.world.abort()
        else:
            self.world.command(command["operation"], command["object"])

    def _tick(self) -> None:
        now = time.monotonic()
        self.world.advance(now - self._last)
        self._last = now
        if self.world.is_human_inside is not self._seen:
            self._seen = self.world.is_human_inside
            self._human.publish(Bool(data=self._seen))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the cell until it is told to end."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--motion-time", type=float, default=0.4, help="seconds of a pick or a place")
    parser.add_argument(
        "--visit", type=int, action="append", default=[], help="number of a motion to interrupt"
    )
    options, ros_arguments = parser.parse_known_args(arguments)
    rclpy.init(args=ros_arguments, signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
    visits = [Visit(motion, options.motion_time / 2, 1.0) for motion in options.visit]
    simulator = Simulator(
        lambda set_signal, log: World(set_signal, visits=visits, motion_time=options.motion_time, log=log)
    )
    ends = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ends.set())
    executor = SingleThreadedExecutor()
    executor.add_node(simulator.ros)
    try:
        while not ends.is_set():
            executor.spin_once(timeout_sec=0.1)
    except ExternalShutdownException:
        pass
    finally:
        executor.shutdown()
        simulator.close()
        try_shutdown()
    return 0
