"""Reads packages of ROS 2 without running them: which nodes there are, their ports, and what callbacks do."""
