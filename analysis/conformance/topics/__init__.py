"""Unrecorded steps inside of topics: queues of ROS 1, histories of ROS 2."""
