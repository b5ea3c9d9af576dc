"""Runs: the planner, too, has a thread and a group that take the answer which its callback waits for."""

import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from spinning import spin
from std_srvs.srv import Trigger


class Robot(Node):
    """Asks for a route, again and again, and publishes where it is."""

    def __init__(self) -> None:
        super().__init__("robot")
        others = MutuallyExclusiveCallbackGroup()
        self.route = self.create_client(Trigger, "route", callback_group=others)
        self.create_service(Trigger, "position", self.on_position, callback_group=others)
        self.create_timer(0.03, self.on_timer)

    def on_timer(self) -> None:
        if self.route.service_is_ready():
            self.get_logger().info("asks")
            self.route.call(Trigger.Request())
            self.get_logger().info("answered")

    def on_position(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self.get_logger().info("served")
        response.success = True
        return response


class Planner(Node):
    """Plans routes."""

    def __init__(self) -> None:
        super().__init__("planner")
        others = MutuallyExclusiveCallbackGroup()
        self.position = self.create_client(Trigger, "position", callback_group=others)
        self.create_service(Trigger, "route", self.on_route)

    def on_route(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = self.position.call(Trigger.Request()).success
        return response


if __name__ == "__main__":
    rclpy.init()
    threads = {"num_threads": 2}
    spin({Robot(): MultiThreadedExecutor(**threads), Planner(): MultiThreadedExecutor(**threads)})
