"""Three plain nodes that tell of their calls: each image is classified by a service, and then labelled."""

from __future__ import annotations

import os
import sys
from threading import Thread
from time import sleep
from typing import Any

import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_services_default
from rclpy.service_introspection import ServiceIntrospectionState
from rclpy.utilities import ok
from std_msgs.msg import String
from std_srvs.srv import Trigger


class Camera(Node):
    """Publishes an image ten times a second, once somebody records all that follows from it."""

    def __init__(self) -> None:
        super().__init__("camera")
        self.images = self.create_publisher(String, "/image", 10)
        self.create_timer(0.1, self.on_timer)

    def on_timer(self) -> None:
        recorded = ("/label", "/look", "/classify/_service_event")
        if self.images.get_subscription_count() == 2 and all(map(self.count_subscribers, recorded)):
            self.images.publish(String(data="picture"))


class Detector(Node):
    """Has each image classified, waits for that, and publishes a label."""

    def __init__(self) -> None:
        super().__init__("detector")
        self.labels = self.create_publisher(String, "/label", 10)
        self.classify = self.create_client(
            Trigger, "/classify", callback_group=MutuallyExclusiveCallbackGroup()
        )
        self.classify.configure_introspection(
            self.get_clock(), qos_profile_services_default, ServiceIntrospectionState.METADATA
        )
        self.classify.wait_for_service()
        self.create_subscription(String, "/image", self.on_image, 10)

    def on_image(self, image: String) -> None:
        found: Any = self.classify.call(Trigger.Request())
        self.labels.publish(String(data=found.message))


class Classifier(Node):
    """Answers, and says before that it was asked."""

    def __init__(self) -> None:
        super().__init__("classifier")
        self.looks = self.create_publisher(String, "/look", 10)
        service = self.create_service(Trigger, "/classify", self.on_classify)
        service.configure_introspection(
            self.get_clock(), qos_profile_services_default, ServiceIntrospectionState.CONTENTS
        )

    def on_classify(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self.looks.publish(String(data="hm"))
        response.success, response.message = True, "cat"
        return response


def main() -> None:
    """Run them until the process is ended, each by an executor of its own."""
    rclpy.init(args=sys.argv)
    executors = [SingleThreadedExecutor(), MultiThreadedExecutor(num_threads=2), SingleThreadedExecutor()]
    for executor, make in zip(executors, (Classifier, Detector, Camera), strict=True):
        executor.add_node(make())
        Thread(target=executor.spin, daemon=True).start()
    while ok():  # until a signal
        sleep(0.1)
    os._exit(0)


if __name__ == "__main__":
    main()
