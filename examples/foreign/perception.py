"""Nodes that evaluate sensor data: obstacles, position and map."""

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Detector(Node):
    """Finds obstacles in images; requests a stricter QoS than the camera offers, unless it is fixed."""

    def __init__(self, *, fixed: bool = False) -> None:
        super().__init__("detector")
        self.obstacles = self.create_publisher(String, "/obstacles", 10)
        self.create_subscription(String, "/image", self.on_image, qos_profile_sensor_data if fixed else 10)

    def on_image(self, image: String) -> None:
        self.obstacles.publish(String(data=f"box in the {image.data}"))


class Localizer(Node):
    """Publishes the position of the robot with each scan, and on request."""

    def __init__(self) -> None:
        super().__init__("localizer")
        self.turned = 0.0
        self.poses = self.create_publisher(Float64, "/pose", 10)
        self.create_subscription(String, "/scan", self.on_scan, qos_profile_sensor_data)
        self.create_subscription(Float64, "/imu", self.on_imu, 10)
        self.create_service(Trigger, "/where", self.on_where)

    def on_scan(self, scan: String) -> None:
        self.poses.publish(Float64(data=self.turned))

    def on_imu(self, turn: Float64) -> None:
        self.turned += turn.data

    def on_where(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success, response.message = True, str(self.turned)
        return response


class Mapper(Node):
    """Makes a map from the scans of the lidar."""

    def __init__(self) -> None:
        super().__init__("mapper")
        self.maps = self.create_publisher(String, "/map", LATCHED)
        self.create_subscription(Float64, "/pose", self.on_pose, 10)
        self.create_subscription(String, "/scan", self.on_scan, qos_profile_sensor_data)

    def on_pose(self, pose: Float64) -> None:
        self.maps.publish(String(data=f"wall at {pose.data}"))

    def on_scan(self, scan: String) -> None:
        self.get_logger().debug("a scan")
