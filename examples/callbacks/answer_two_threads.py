"""Runs: what the answer begins is in no group, so that the other thread takes the answer it waits for."""

import rclpy
from battery import Battery
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future
from spinning import spin
from std_srvs.srv import Trigger


class Monitor(Node):
    """Asks for the level of the battery, and asks again when the answer is there."""

    def __init__(self) -> None:
        super().__init__("monitor")
        self.level = self.create_client(Trigger, "level")
        self.again = self.create_client(Trigger, "level")
        self.is_idle = True
        self.create_timer(0.03, self.on_timer)

    def on_timer(self) -> None:
        if self.is_idle and self.level.service_is_ready():
            self.is_idle = False
            self.get_logger().info("asks")
            self.level.call_async(Trigger.Request()).add_done_callback(self.on_level)

    def on_level(self, future: Future) -> None:
        self.get_logger().info("answered")
        self.get_logger().info("asks")
        self.again.call(Trigger.Request())
        self.get_logger().info("answered")
        self.is_idle = True


if __name__ == "__main__":
    rclpy.init()
    spin({Battery(): SingleThreadedExecutor(), Monitor(): MultiThreadedExecutor(num_threads=2)})
