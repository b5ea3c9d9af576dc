"""A battery, which takes its time to say how full it is: the server of most examples."""

import time

from rclpy.node import Node
from std_srvs.srv import Trigger


class Battery(Node):
    """Serves ``level``; one thread, one group."""

    def __init__(self) -> None:
        super().__init__("battery")
        self.create_service(Trigger, "level", self.on_level)

    def on_level(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        time.sleep(0.1)
        self.get_logger().info("served")
        response.success = True
        return response
