"""Nodes that supervise the robot: battery and monitor."""

from perception import LATCHED
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger


class Battery(Node):
    """Publishes its level from time to time, and on request."""

    def __init__(self) -> None:
        super().__init__("battery")
        self.levels = self.create_publisher(Float64, "/battery_level", 10)
        self.create_timer(self.declare_parameter("period", 0.5).value, self.on_timer)
        self.create_service(Trigger, "/charge", self.on_charge)

    def on_timer(self) -> None:
        self.levels.publish(Float64(data=0.9))

    def on_charge(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = True
        return response


class Monitor(Node):
    """Receives missions and paths; requests the last level of the battery, which keeps none unless fixed."""

    def __init__(self, *, fixed: bool = False) -> None:
        super().__init__("monitor")
        self.charge = self.create_client(Trigger, "/charge")
        self.create_subscription(Float64, "/battery_level", self.on_level, 10 if fixed else LATCHED)
        self.create_subscription(Float64, "/odometry", self.on_way, 10)
        self.create_subscription(String, "/mission", self.on_mission, 10)

    def on_level(self, level: Float64) -> None:
        if level.data < 0.2:
            self.charge.call_async(Trigger.Request()).add_done_callback(self.on_charged)

    def on_charged(self, future: Future) -> None:
        self.get_logger().info("charged")

    def on_way(self, way: Float64) -> None:
        self.get_logger().debug("moves")

    def on_mission(self, mission: String) -> None:
        self.get_logger().debug("has a mission")
