"""ROS 2 as a transport of the engine: nodes, messages and environment (guide: docs/ros2.md)."""
