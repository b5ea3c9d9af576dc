"""Interprets calls of rclcpp and the standard library."""
