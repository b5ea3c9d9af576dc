"""Interprets rclpy and other libraries, as far as it matters for facts."""
