"""Reads the source code of ROS 2 packages without running it: nodes, ports and callbacks."""
