"""Sensors: a lidar, a camera and an IMU."""

from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from std_msgs.msg import Float64, String


class Lidar(Node):
    """Scans ten times a second."""

    def __init__(self) -> None:
        super().__init__("lidar", namespace="sensors")
        self.scans = self.create_publisher(String, "/scan", qos_profile_sensor_data)
        self.create_timer(self.declare_parameter("period", 0.1).value, self.on_timer)

    def on_timer(self) -> None:
        self.scans.publish(String(data="wall"))


class Camera(Node):
    """Publishes an image from time to time, best effort."""

    def __init__(self) -> None:
        super().__init__("camera", namespace="sensors")
        self.images = self.create_publisher(String, "/image", qos_profile_sensor_data)
        self.create_timer(self.declare_parameter("period", 0.2).value, self.on_timer)

    def on_timer(self) -> None:
        self.images.publish(String(data="picture"))


class Imu(Node):
    """Publishes the rotation of the robot."""

    def __init__(self) -> None:
        super().__init__("imu", namespace="sensors")
        self.turns = self.create_publisher(Float64, "/imu", 10)
        self.create_timer(self.declare_parameter("period", 0.1).value, self.on_timer)

    def on_timer(self) -> None:
        self.turns.publish(Float64(data=0.1))
