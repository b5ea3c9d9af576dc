"""Nodes that drive the robot: commander, planner, follower and wheels."""

from perception import LATCHED
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger


class Planner(Node):
    """Plans a path on request; for that, it calls another service for the position of the robot.

    With one thread this waits forever. Fixed, it has a callback group and a thread that take the answer.
    """

    def __init__(self, *, fixed: bool = False) -> None:
        super().__init__("planner")
        group = MutuallyExclusiveCallbackGroup() if fixed else None
        self.paths = self.create_publisher(String, "/path", 10)
        self.where = self.create_client(Trigger, "/where", callback_group=group)
        self.create_subscription(String, "/map", self.on_map, LATCHED)
        self.create_service(Trigger, "/plan", self.on_plan)

    def on_map(self, map: String) -> None:
        self.get_logger().debug("a map")

    def on_plan(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        where = self.where.call(Trigger.Request())
        self.paths.publish(String(data=f"from {where.message}"))
        response.success = True
        return response


class Commander(Node):
    """Requests a new path from time to time, without waiting for it."""

    def __init__(self) -> None:
        super().__init__("commander")
        self.missions = self.create_publisher(String, "/mission", 10)
        self.plan = self.create_client(Trigger, "/plan")
        self.is_planning = False
        self.create_timer(self.declare_parameter("period", 0.5).value, self.on_timer)

    def on_timer(self) -> None:
        if not self.is_planning and self.plan.service_is_ready():
            self.is_planning = True
            self.plan.call_async(Trigger.Request()).add_done_callback(self.on_planned)

    def on_planned(self, future: Future) -> None:
        self.is_planning = False
        self.missions.publish(String(data="planned"))


class Driver(Node):
    """Sends the speed to the wheels."""

    def __init__(self) -> None:
        super().__init__("driver")
        self.speeds = self.create_publisher(Float64, "/speed", 10)
        self.create_subscription(String, "/path", self.on_path, 10)
        self.create_subscription(String, "/obstacles", self.on_obstacle, 10)

    def on_path(self, path: String) -> None:
        self.speeds.publish(Float64(data=1.0))

    def on_obstacle(self, obstacle: String) -> None:
        self.speeds.publish(Float64(data=0.0))


class Base(Node):
    """Turns the wheels, and publishes the distance."""

    def __init__(self) -> None:
        super().__init__("base")
        self.way = 0.0
        self.ways = self.create_publisher(Float64, "/odometry", 10)
        self.create_subscription(Float64, "/speed", self.on_speed, 10)

    def on_speed(self, speed: Float64) -> None:
        self.way += speed.data
        self.ways.publish(Float64(data=self.way))
