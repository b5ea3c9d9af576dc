"""Loses nothing: the mapper says when it is done with a scan, and the sensor has three under way at most."""

import time

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from spinning import spin
from std_msgs.msg import Empty, Int32


class Sensor(Node):
    """Sends a scan, which is a number here, each 5 ms where the mapper keeps up."""

    def __init__(self) -> None:
        super().__init__("sensor")
        self.scans = self.create_publisher(Int32, "scans", 5)
        self.create_subscription(Empty, "done", self.on_done, 5)
        self.sent, self.may_send = 0, 3
        self.create_timer(0.005, self.on_timer)

    def on_timer(self) -> None:
        if self.scans.get_subscription_count() and self.may_send:
            self.may_send -= 1
            self.sent += 1
            self.scans.publish(Int32(data=self.sent))

    def on_done(self, message: Empty) -> None:
        self.may_send += 1


class Mapper(Node):
    """Works on scans, 20 ms each."""

    def __init__(self) -> None:
        super().__init__("mapper")
        self.done = self.create_publisher(Empty, "done", 5)
        self.create_subscription(Int32, "scans", self.on_scan, 5)

    def on_scan(self, scan: Int32) -> None:
        time.sleep(0.02)
        self.get_logger().info(f"scan {scan.data}")
        self.done.publish(Empty())


if __name__ == "__main__":
    rclpy.init()
    spin({Mapper(): SingleThreadedExecutor(), Sensor(): SingleThreadedExecutor()})
