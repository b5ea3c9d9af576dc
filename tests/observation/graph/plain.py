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
        executor.spin()


if __name__ == "__main__":
    main(sys.argv[1])
