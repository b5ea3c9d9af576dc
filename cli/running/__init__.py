"""Runs an application in this process or on ROS 2, and watches it until it ends."""
