"""Conversion of tokens to ROS messages and back."""
