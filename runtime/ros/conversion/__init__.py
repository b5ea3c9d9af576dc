"""Tokens as ROS messages and back."""
