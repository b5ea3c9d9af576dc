"""A robot of twelve nodes in plain rclpy, written without any model in mind.

``python robot.py`` starts all of them, each with an executor and a thread of its own, as if they were
processes; ``python robot.py lidar mapper`` only these. With ``--mended``, two subscriptions ask for no more
than is offered, and the planner gets a second thread.
"""

import os
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from threading import Thread
from time import sleep

import rclpy
from driving import Base, Commander, Driver, Planner
from health import Battery, Monitor
from perception import Detector, Localizer, Mapper
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from sensors import Camera, Imu, Lidar


def nodes(fixed: bool) -> dict[str, Callable[[], Node]]:
    """Return the constructor of each node."""
    return {
        "lidar": Lidar,
        "camera": Camera,
        "imu": Imu,
        "detector": partial(Detector, fixed=fixed),
        "localizer": Localizer,
        "mapper": Mapper,
        "planner": partial(Planner, fixed=fixed),
        "commander": Commander,
        "driver": Driver,
        "base": Base,
        "battery": Battery,
        "monitor": partial(Monitor, fixed=fixed),
    }


def spin(name: str, make: Callable[[], Node], fixed: bool) -> None:
    """Make a node and run its callbacks, until Ctrl-C."""
    many = fixed and name == "planner"
    executor = MultiThreadedExecutor(num_threads=2) if many else SingleThreadedExecutor()
    executor.add_node(make())
    with suppress(ExternalShutdownException):
        executor.spin()


def main() -> None:
    """Start the nodes that the command line names; by default, all."""
    fixed = "--mended" in sys.argv
    known = nodes(fixed)
    wanted = [word for word in sys.argv[1:] if word in known] or list(known)
    rclpy.init(args=sys.argv)
    threads = [Thread(target=spin, args=(name, known[name], fixed), daemon=True) for name in wanted]
    for thread in threads:
        thread.start()
    while rclpy.ok():  # until a signal
        sleep(0.1)
    for thread in threads:
        thread.join(0.2)
    os._exit(0)  # a callback may still wait, forever


if __name__ == "__main__":
    main()
