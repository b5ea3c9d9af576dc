"""Rules of ROS 2 for clients that do not wait for responses or results."""
