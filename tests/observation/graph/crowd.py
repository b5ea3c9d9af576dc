"""A crowd of nodes: ``python crowd.py 200 500`` makes 200 nodes, and 500 topics from one node to another."""

import sys
import time

import rclpy
from rclpy.node import Node
from std_msgs.msg import Empty


def main(nodes: int, topics: int) -> None:
    """Make them, say so, and stay until a signal comes."""
    rclpy.init()
    made = [Node(f"node_{number}", namespace=f"part_{number % 4}") for number in range(nodes)]
    for number in range(topics):
        made[number % nodes].create_publisher(Empty, f"/topic_{number}", 10)
        made[(number * 7 + 1) % nodes].create_subscription(Empty, f"/topic_{number}", print, 10)
    print("ready", flush=True)
    while rclpy.ok():
        time.sleep(0.1)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
