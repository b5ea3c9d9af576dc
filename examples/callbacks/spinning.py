"""Run several nodes in one process, each with an executor of its own."""

from threading import Thread

import rclpy
from rclpy.executors import Executor
from rclpy.node import Node


def spin(nodes: dict[Node, Executor]) -> None:
    """Spin each node on a thread of its own, until Ctrl-C."""
    for node, executor in nodes.items():
        executor.add_node(node)
    threads = [Thread(target=executor.spin, daemon=True) for executor in nodes.values()]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    rclpy.try_shutdown()
