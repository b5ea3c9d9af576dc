"""Blocks: timer and client are in the group that the node has by default, which runs one thing at a time."""

import rclpy
from battery import Battery
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from spinning import spin
from std_srvs.srv import Trigger


class Monitor(Node):
    """Asks for the level of the battery, again and again."""

    def __init__(self) -> None:
        super().__init__("monitor")
        self.level = self.create_client(Trigger, "level")
        self.create_timer(0.03, self.on_timer)

    def on_timer(self) -> None:
        if self.level.service_is_ready():
            self.get_logger().info("asks")
            self.level.call(Trigger.Request())
            self.get_logger().info("answered")


if __name__ == "__main__":
    rclpy.init()
    spin({Battery(): SingleThreadedExecutor(), Monitor(): MultiThreadedExecutor(num_threads=2)})
