"""Two more nodes: one that is managed, and one that obeys simulated time and ends when it is told to."""

import sys
from contextlib import suppress

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.lifecycle import LifecycleNode
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_msgs.msg import Empty


def main(name: str) -> None:
    """Make a node and run it."""
    rclpy.init()
    node: Node
    if name == "managed":
        node = LifecycleNode("managed")
    else:
        node = Node(name, parameter_overrides=[Parameter("use_sim_time", value=True)])
        node.create_publisher(Empty, "/tick", 10)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    with suppress(ExternalShutdownException):
        while node.context.ok():  # a signal wakes a wait without an end not always
            executor.spin_once(timeout_sec=0.2)
    node.destroy_node()  # the interpreter alone may end before the others are told


if __name__ == "__main__":
    main(sys.argv[1])
