"""Reads the source code of ROS 2 packages without running it: nodes, their ports, and the actions of
callbacks."""
