"""Loses scans: the sensor is faster than who works on them, and the histories keep five."""

import time

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from spinning import spin
from std_msgs.msg import Int32


class Sensor(Node):
    """Sends a scan, which is a number here, each 5 ms."""

    def __init__(self) -> None:
        super().__init__("sensor")
        self.scans = self.create_publisher(Int32, "scans", 5)
        self.sent = 0
        self.create_timer(0.005, self.on_timer)

    def on_timer(self) -> None:
        if self.scans.get_subscription_count():
            self.sent += 1
            self.scans.publish(Int32(data=self.sent))


class Mapper(Node):
    """Works on scans, 20 ms each."""

    def __init__(self) -> None:
        super().__init__("mapper")
        self.create_subscription(Int32, "scans", self.on_scan, 5)

    def on_scan(self, scan: Int32) -> None:
        time.sleep(0.02)
        self.get_logger().info(f"scan {scan.data}")


if __name__ == "__main__":
    rclpy.init()
    spin({Mapper(): SingleThreadedExecutor(), Sensor(): SingleThreadedExecutor()})
